"""``map`` makes the map of a log, ``view`` draws a map file."""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mapper.mapping.parameters import PARAMETERS
from server.cli.app import app
from server.cli.common import (
    MOUNT,
    AsJson,
    FirstScans,
    LogPath,
    Mount,
    TopicName,
    TrajectoryName,
    TumTrajectory,
    configured,
    fail,
    given_parameters,
    print_json,
    progress_bar,
    read_log,
    refusing,
    with_parameter_options,
)
from server.cli.drift import Quiet, drift_note
from server.cli.map_files import OUT_HELP, MapMode, check_mode, save, states
from server.cli.prior import Prior, PriorFrame, given_prior

if TYPE_CHECKING:
    from mapper.io.export import GrowingMap
    from mapper.sensors.scan import ScanLog


@app.command("map")
@with_parameter_options(*(row.name for row in PARAMETERS if row.name not in (*MOUNT, "log_odds_prior")))
def map_log(
    log: LogPath,
    topic: TopicName = None,
    trajectory: TrajectoryName = None,
    tum_trajectory: TumTrajectory = None,
    mount: Mount = None,
    prior: Prior = None,
    prior_frame: PriorFrame = None,
    first_scans: FirstScans = None,
    out: Annotated[Path | None, typer.Option(metavar="PREFIX", help=OUT_HELP)] = None,
    mcap: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the map, the poses and the scans for Foxglove and ROS 2.")
    ] = None,
    tum: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the trajectory in TUM format.")] = None,
    mode: MapMode = "trinary",
    quiet: Quiet = False,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each row of the table
) -> None:
    """Make the map of a log."""
    from mapper.io.export import GrowingMap  # noqa: PLC0415 - start-up
    from mapper.mapping.integrate import grid_for, integrate_log  # noqa: PLC0415 - start-up
    from mapper.mapping.sensor_defaults import sensor_defaults  # noqa: PLC0415 - start-up

    given, prior_map = given_prior(prior, prior_frame, given_parameters(parameters, mount))
    check_mode(mode)
    scans = read_log(log, topic, tum_trajectory)
    with refusing(log):
        frame = scans.trajectory(trajectory).frame_id
    notes = [*scans.notes, *(prior_map.notes_for(scans, trajectory) if prior_map else ())]
    if prior_map is not None:
        frame = prior_map.frame
    config = configured(sensor_defaults(scans.beam_width, given))
    with refusing(log):
        grid = grid_for(scans, config, trajectory, prior=prior_map.grid if prior_map else None)
        # No scan at all: the kernels are compiled, or loaded from the cache, before the clock runs.
        integrate_log(grid, scans, config, trajectory, 0, 0)
        with progress_bar("Mapping") as bar:
            start = time.perf_counter()
            updated = integrate_log(
                grid,
                scans,
                config,
                trajectory,
                stop=first_scans,
                progress=bar and (lambda done, total: bar(done / max(1, total))),
            )
            seconds = time.perf_counter() - start
    drift = None if quiet else drift_note(scans, trajectory, config)
    written = save(grid, out, mode, frame) if out is not None else []
    written += _export(scans, GrowingMap(grid, config, first_scans), trajectory, mcap, tum)
    geometry = grid.geometry
    facts: dict[str, Any] = {
        "log": scans.name,
        "trajectory": trajectory or scans.default_trajectory,
        "frame": frame,
        "scans": scans.n_scans if first_scans is None else first_scans,
        "beams": scans.n_beams,
        "cells_updated": updated,
        "seconds": round(seconds, 6),
        "resolution": geometry.resolution,
        "rows": geometry.rows,
        "cols": geometry.cols,
        "origin": list(geometry.origin),
        **states(grid),
        "files": [str(path) for path in written],
        "notes": notes,
    }
    if not quiet:
        facts["drift"] = drift
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{facts['log']}: {facts['scans']} scans of {facts['beams']} beams, trajectory {facts['trajectory']}")
    typer.echo(
        f"  {geometry.size_text} cells of {geometry.resolution:g} m, "
        f"origin {', '.join(f'{value:g}' for value in geometry.origin)}"
    )
    typer.echo(f"  {facts['occupied']} occupied, {facts['free']} free, {facts['unknown']} unknown")
    typer.echo(
        f"  {facts['information_gain_bits']:.0f} bits learned, {facts['entropy_bits']:.0f} bits open in seen cells"
    )
    typer.echo(f"  {updated} cell updates in {seconds:.3f} s")
    for path in written:
        typer.echo(f"  wrote {path}")
    if quiet:
        return
    for note in [*notes, *([drift] if drift else [])]:
        typer.echo(f"  note: {note}")


def _export(
    log: ScanLog, growing_map: GrowingMap, trajectory: str | None, mcap: Path | None, tum: Path | None
) -> list[Path]:
    """Write what was asked for; return the paths."""
    from mapper.core.atomic_file import atomic_write  # noqa: PLC0415 - start-up
    from mapper.io.export import tum_text, write_mcap  # noqa: PLC0415 - start-up

    for path in (mcap, tum):
        if path is None:
            continue
        try:
            with atomic_write(path) as file:
                if path is tum:
                    file.write(tum_text(log, trajectory).encode())
                else:
                    with progress_bar("Writing") as progress:
                        write_mcap(file, log, growing_map, trajectory, progress)
        except OSError as error:
            fail(f"{path}: the file cannot be written: {error.strerror}.")
    return [path for path in (mcap, tum) if path is not None]


@app.command()
def view(
    map_yaml: Annotated[Path, typer.Argument(metavar="MAP.yaml", help="A map file.")],
    width: Annotated[int | None, typer.Option(help="Characters across. [the terminal's]")] = None,
) -> None:
    """Draw a map file as text: in three states, and in characters that grow denser with the occupancy."""
    from mapper.grid.text import RAMP, density, three_state  # noqa: PLC0415 - start-up
    from mapper.io.maps import load_map  # noqa: PLC0415 - start-up

    across = shutil.get_terminal_size().columns if width is None else width
    with refusing(map_yaml):
        loaded = load_map(map_yaml)
        pictures = three_state(loaded.grid, across), density(loaded.grid, across)
    geometry = loaded.grid.geometry
    typer.echo(
        f"{map_yaml.name}: {geometry.size_text} cells of {geometry.resolution:g} m, "
        f"{loaded.description.mode}, origin {', '.join(f'{value:g}' for value in geometry.origin)}"
    )
    for note in loaded.notes:
        typer.echo(f"note: {note}")
    typer.echo("\n# occupied   . free   ? unknown\n" + pictures[0])
    typer.echo(f"\n{RAMP[0]} free … {RAMP[-1]} occupied, blank: never observed\n" + pictures[1])
