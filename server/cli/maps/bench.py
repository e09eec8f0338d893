"""``bench map``: time to compute the map of a log."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from mapper.mapping.parameters import recorded_defaults
from mapper.tools.bench import bench_map
from server.cli.commands import app
from server.cli.common import (
    AsJson,
    LogPath,
    Mount,
    TfTopic,
    TopicName,
    TrajectoryName,
    TumTrajectory,
    configured,
    given_parameters,
    print_json,
    refusing,
    with_parameter_options,
)
from server.cli.reading import read_log

bench_app = typer.Typer(no_args_is_help=True)
app.add_typer(bench_app, name="bench")


@bench_app.callback()
def bench() -> None:
    """Measure, in this process, without reading and start-up."""


@bench_app.command("map")
@with_parameter_options("resolution", "range_max", "mount_upside_down", "time_offset")
def bench_map_command(
    log: LogPath,
    topic: TopicName = None,
    trajectory: TrajectoryName = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    mount: Mount = None,
    repeats: Annotated[int, typer.Option(help="Number of runs for each kind of update; the shortest counts.")] = 5,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Measure the time to compute a log's map, for each kind of update; the shortest of several runs counts."""
    values = given_parameters(parameters, mount)
    scans = read_log(log, topic, tum_trajectory, tf)
    config = configured(recorded_defaults(scans.beam_width, values))
    with refusing(log):
        measured = bench_map(scans, config, repeats, trajectory)
    facts = {
        "log": scans.name,
        "scans": scans.n_scans,
        "beams": scans.n_beams,
        "resolution": config.resolution,
        "range_max": config.range_max,
        **measured,
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{scans.name}: {scans.n_scans} scans of {scans.n_beams} beams at {config.resolution:g} m a cell")
    typer.echo(f"  per beam {measured['per_beam_ms']:.1f} ms, {measured['cells']} cell updates")
    typer.echo(f"  per scan {measured['per_scan_ms']:.1f} ms, {measured['per_scan_cells']} cell updates")
