"""``slam``: correct the poses of a log by aligning its scans."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from mapper.core.errors import MapperError
from mapper.diagnosis import events_of
from mapper.diagnosis.figures import MapFigures, map_figures
from mapper.diagnosis.verdict import map_of
from mapper.io.export import tum_text
from mapper.io.graphs import g2o_lines
from mapper.mapping.parameters import MappingConfig, recorded_defaults
from mapper.sensors.georeference import NO_OFFSET
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.slam import SLAM_PARAMETERS, SlamConfig, SlamProgress, SlamResult, slam_log
from mapper.slam.estimate import estimate
from server.cli.commands import app
from server.cli.common import (
    AsJson,
    LogPath,
    Mount,
    TfTopic,
    TopicNames,
    TrajectoryName,
    TumTrajectory,
    configured,
    fail,
    given_parameters,
    output_file,
    print_json,
    print_notes,
    progress_bar,
    refusing,
    set_values,
    with_parameter_options,
)
from server.cli.map_files import save
from server.cli.reading import read_joint, with_corrections

SLAM = "slam"  #: name of the trajectory
#: of :class:`mapper.diagnosis.figures.MapFigures`: description and number format
FIGURES: Mapping[str, tuple[str, Callable[[float], str]]] = {
    "drift_m": ("drift of the walls", "{:.2f} m".format),
    "contradicted": ("readings contradicted by those of another time", lambda share: f"{100 * share:.1f} %"),
    "sharpness": ("sharpness of the walls", "{:.3f}".format),
}
WORTH_SAYING_S = 10.0  #: seconds of processor time above which they are announced


@app.command()
@with_parameter_options("mount_upside_down", "time_offset")
def slam(
    log: LogPath,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="PREFIX",
            help="Write PREFIX.pgm and PREFIX.yaml, the map; PREFIX.tum, a pose for each scan in the log's order; and "
            "PREFIX.g2o, the graph.",
        ),
    ] = None,
    topic: TopicNames = None,
    trajectory: TrajectoryName = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    values: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A SLAM parameter; given again, another one."),
    ] = None,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Correct the poses of a log by aligning its scans with one another (SLAM)."""
    config = _configured(values or [])
    mapping = configured(given_parameters(parameters, mount))
    scans = with_corrections(log, read_joint(log, topic or (), tum_trajectory, tf), mapping)
    with refusing(log):
        expected = estimate(scans, config, trajectory)
        if expected.seconds > WORTH_SAYING_S and not as_json:
            typer.echo(
                f"{scans.n_scans} scans, of which {expected.n_matched} are matched: about {expected.seconds:.0f} s of "
                f"processor time and {expected.n_bytes / 1e6:.0f} MB of memory.",
                err=True,
            )
        with progress_bar("SLAM") as bar:

            def report(done: SlamProgress) -> None:
                if bar is not None:
                    bar(done.fraction)

            result = slam_log(scans, config, trajectory=trajectory, progress=report)
        corrected = with_slam_poses(scans, result)
        config_of_map = MappingConfig().with_values(recorded_defaults(scans.beam_width))
        before = None if result.odometry is None else map_figures(scans, result.odometry, config_of_map)
        grid = map_of(corrected, SLAM)
        after = map_figures(corrected, SLAM, config_of_map)
        events = events_of(scans, result.odometry)
    offset = corrected.trajectory(SLAM).offset
    written = [] if out is None else [*save(grid, out, "trinary", "map", offset), *_write(out, corrected, result)]
    loops = result.graph.kind == 1
    residuals = result.graph.residual[loops]
    notes = [*scans.notes, *result.notes]
    facts: dict[str, object] = {
        "log": scans.name,
        "scans": scans.n_scans,
        "odometry": result.odometry,
        "cpu_seconds": round(result.cpu_seconds, 3),
        "nodes": len(result.graph.nodes),
        "loops": result.graph.n_loops,
        "loops_tried": len(result.candidates),
        "loops_outweighed": int((result.graph.weight[loops] < 0.5).sum()),
        "residuals": {
            "mean": round(float(residuals.mean()), 4) if len(residuals) else None,
            "max": round(float(residuals.max()), 4) if len(residuals) else None,
        },
        **{
            f"{name}_{when}": None if figures is None or (value := getattr(figures, name)) is None else round(value, 4)
            for name in FIGURES
            for when, figures in (("before", before), ("after", after))
        },
        "events": [event.public() for event in events],
        "files": [str(path) for path in written],
        "notes": notes,
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{facts['log']}: {scans.n_scans} scans, from {result.odometry or 'the scans alone, without odometry'}")
    typer.echo(f"  {result.cpu_seconds:.1f} s of processor time, {facts['nodes']} poses in the graph")
    typer.echo(
        f"  {facts['loops']} loops closed of {facts['loops_tried']} tried; the graph outweighs "
        f"{facts['loops_outweighed']} of them"
    )
    if len(residuals):
        typer.echo(f"  residuals of the loops: mean {residuals.mean():.2f}, largest {residuals.max():.2f} σ")
    for line in (*_figure_lines(before, after), *(event.sentence for event in events)):
        typer.echo(f"  {line}")
    for path in written:
        typer.echo(f"  wrote {path}")
    print_notes(notes)


def _figure_lines(before: MapFigures | None, after: MapFigures) -> list[str]:
    """Return figures that show whether the map can be trusted, along the poses after SLAM and before."""
    lines = []
    for name, (words, form) in FIGURES.items():
        was, now = (None if value_ is None else getattr(value_, name) for value_ in (before, after))
        if now is not None:
            lines.append(f"{words} {form(now)}{'' if was is None else f', before {form(was)}'}")
    return lines


def _configured(values: list[str]) -> SlamConfig:
    """Return the parameters with those given as NAME=VALUE replaced, or end the command with an error."""
    typed = set_values({row.name: row for row in SLAM_PARAMETERS}, values)
    try:
        return SlamConfig().with_values(typed)
    except MapperError as error:
        fail(error.message)


def with_slam_poses(log: ScanLog, result: SlamResult) -> ScanLog:
    """Return the log with the poses from SLAM as its last trajectory, :data:`SLAM`."""
    offset = NO_OFFSET if result.odometry is None else log.trajectory(result.odometry).offset
    corrected = Trajectory(result.poses, "poses corrected by SLAM", "map", from_scans=True, offset=offset)
    return replace(log, trajectories={**{k: v for k, v in log.trajectories.items() if k != SLAM}, SLAM: corrected})


def _write(prefix: Path, log: ScanLog, result: SlamResult) -> list[Path]:
    return write_texts(prefix, {".tum": tum_text(log, SLAM), ".g2o": "".join(g2o_lines(result.graph))})


def write_texts(prefix: Path, texts: dict[str, str]) -> list[Path]:
    """Write files named by a prefix and the endings in ``texts``; return their paths."""
    paths = []
    for ending, text in texts.items():
        path = prefix.with_name(prefix.name + ending)
        with output_file(path) as file:
            file.write(text.encode())
        paths.append(path)
    return paths
