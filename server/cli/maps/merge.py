"""``merge``: add map files of one place, or combine two logs of one place in one map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from mapper.grid.merge import merged
from mapper.io.export import tum_text
from mapper.io.graphs import g2o_lines
from mapper.io.logs import is_log
from mapper.io.maps import load_map
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.slam import MergeProgress, map_along, merge_logs
from server.cli.commands import app
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
    progress_bar,
    refusing,
    with_parameter_options,
)
from server.cli.map_files import OUT_HELP, MapMode, check_mode, save, states
from server.cli.poses.slam import SLAM, write_texts
from server.cli.reading import read_joint, with_corrections


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
    check_mode(mode)
    begin = None if guess is None else numbers("--guess", "three numbers, X,Y,YAW in metres and radians", 3, guess)
    values = given_parameters(parameters, mount)
    if are_logs(maps):

        def read(path: Path) -> ScanLog:
            return with_corrections(path, read_joint(path, topic or (), tf=tf), configured(values))

        merge_log_files(maps, read, out, mode, begin, as_json=as_json)
        return
    if topic or tf or values:
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
    facts: dict[str, object] = {
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


def are_logs(paths: list[Path]) -> bool:
    """Return whether all files are logs; end the command with an error if only some are."""
    logs = [path for path in paths if path.suffix.lower() not in {".yaml", ".yml"} and is_log(path)]
    if logs and len(logs) != len(paths):
        fail(f"{logs[0]} is a log and others are map files: map files can be merged, or two logs.")
    return bool(logs)


def merge_log_files(
    paths: list[Path],
    read: Callable[[Path], ScanLog],
    out: Path,
    mode: str,
    guess: list[float] | None,
    *,
    as_json: bool,
) -> None:
    """Merge two logs, which ``read`` returns, and print the result."""
    if len(paths) != 2:
        fail(f"merge takes two logs at a time, not {len(paths)}.")
    first, second = map(read, paths)
    with refusing(paths[1]), progress_bar("Merging") as bar:

        def report(done: MergeProgress) -> None:
            if bar is not None:
                bar(done.fraction)

        merged = merge_logs(first, second, guess=None if guess is None else np.array(guess), progress=report)
        grid = map_along([(first, merged.poses[0]), (second, merged.poses[1])])
    texts = {".g2o": "".join(g2o_lines(merged.graph))}
    for number, (log, poses) in enumerate(zip((first, second), merged.poses, strict=True), 1):
        texts[f"-{number}.tum"] = tum_text(replace(log, trajectories={SLAM: Trajectory(poses)}), SLAM)
    written = [*save(grid, out, mode, "map"), *write_texts(out, texts)]
    geometry = grid.geometry
    facts: dict[str, object] = {
        "logs": [str(path) for path in paths],
        "placed": merged.placed.tolist(),
        "score": round(merged.score, 4),
        "loops": len(merged.loops),
        "loops_tried": len(merged.tried),
        "cpu_seconds": round(merged.cpu_seconds, 3),
        "resolution": geometry.resolution,
        "rows": geometry.rows,
        "cols": geometry.cols,
        "origin": list(geometry.origin),
        **states(grid),
        "files": [str(path) for path in written],
    }
    if as_json:
        print_json(facts)
        return
    x, y, theta = merged.placed
    typer.echo(f"{paths[1]} in the frame of {paths[0]}: {x:.2f} m, {y:.2f} m, {np.degrees(theta):.1f}°")
    typer.echo(
        f"  {len(merged.loops)} loops between the logs, of {len(merged.tried)} tried; {merged.cpu_seconds:.1f} s"
    )
    typer.echo(f"  {facts['occupied']} occupied, {facts['free']} free, {facts['unknown']} unknown")
    for path in written:
        typer.echo(f"  wrote {path}")
