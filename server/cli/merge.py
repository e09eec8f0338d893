"""``merge``: add map files of one place, or bring two logs of one place into one map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.app import app
from server.cli.common import (
    AsJson,
    Mount,
    TfTopic,
    TopicNames,
    configured,
    fail,
    given_parameters,
    numbers,
    print_json,
    print_notes,
    read_joint,
    refusing,
    with_corrections,
    with_parameter_options,
)
from server.cli.map_files import OUT_HELP, MapMode, check_mode, save, states
from server.cli.merge_logs import are_logs, merge_log_files

if TYPE_CHECKING:
    from mapper.sensors.scan import ScanLog


@app.command()
@with_parameter_options("mount_upside_down", "time_offset")
def merge(
    maps: Annotated[
        list[Path], typer.Argument(metavar="MAP.yaml|LOG", help="Map files with the same cells; or two logs.")
    ],
    out: Annotated[
        Path,
        typer.Option(
            metavar="PREFIX",
            help=OUT_HELP + " Of logs also PREFIX-1.tum and PREFIX-2.tum, the poses, and PREFIX.g2o, the graph.",
        ),
    ],
    mode: MapMode = "trinary",
    guess: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,YAW",
            help="Of logs: about the pose of the second one's frame in the first one's (m, m, rad). [searched for]",
        ),
    ] = None,
    topic: TopicNames = None,
    tf: TfTopic = None,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Add the evidence of maps that were made from different scans of one place.

    Two logs of one place are corrected by SLAM, their maps laid on one another, and their scans joined in one graph.
    A topic, a mount and a time offset are those of both.
    """
    from mapper.grid.merge import merged  # noqa: PLC0415 - start-up
    from mapper.io.maps import load_map  # noqa: PLC0415 - start-up

    check_mode(mode)
    begin = None if guess is None else numbers("--guess", "three numbers, X,Y,YAW in metres and radians", 3, guess)
    given = given_parameters(parameters, mount)
    if are_logs(maps):

        def read(path: Path) -> ScanLog:
            return with_corrections(path, read_joint(path, topic or (), tf=tf), configured(given))

        merge_log_files(maps, read, out, mode, begin, as_json=as_json)
        return
    if topic or tf or given:
        fail("A topic, a mount and a time offset are those of logs, and these are map files.")
    if begin is not None:
        fail("--guess is for logs: map files are merged where their cells are.")
    whole, frames, notes = None, [], []
    for path in maps:
        with refusing(path):
            loaded = load_map(path)
            whole = loaded.grid if whole is None else merged(whole, loaded.grid)
        notes += [f"{path.name}: {note}" for note in loaded.notes]
        frames.append(loaded.description.frame)
        stated = {frame for frame in frames if frame is not None}
        if len(stated) > 1:
            fail(f"{path}: The maps are in different frames: {' and '.join(map(repr, sorted(stated)))}.")
    assert whole is not None  # noqa: S101 - the command asks for one map at least
    written = save(whole, out, mode, frames[0] if len(set(frames)) == 1 else None)
    geometry = whole.geometry
    facts: dict[str, Any] = {
        "maps": [str(path) for path in maps],
        "resolution": geometry.resolution,
        "rows": geometry.rows,
        "cols": geometry.cols,
        "origin": list(geometry.origin),
        **states(whole),
        "files": [str(path) for path in written],
        "notes": notes,
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(
        f"{len(maps)} maps: {geometry.size_text} cells of {geometry.resolution:g} m, "
        f"origin {', '.join(f'{value:g}' for value in geometry.origin)}"
    )
    typer.echo(f"  {facts['occupied']} occupied, {facts['free']} free, {facts['unknown']} unknown")
    for path in written:
        typer.echo(f"  wrote {path}")
    print_notes(notes)
