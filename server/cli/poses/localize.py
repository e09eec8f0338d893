"""``localize``: the robot's poses in a map at the scans of a log."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from mapper.core.errors import MapperError
from mapper.io.export import tum_text
from mapper.io.maps import load_map
from mapper.localization import PARAMETERS, LocalizationConfig, Localized, localize_log, read_amcl_yaml
from mapper.localization.localize import LOCALIZED, covariance_lines
from mapper.localization.map_model import check_pose
from mapper.sensors.scan import ScanLog, Trajectory
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
    make_folder_of,
    numbers,
    output_file,
    print_json,
    print_notes,
    progress_bar,
    refusing,
    set_values,
    with_parameter_options,
)
from server.cli.reading import read_joint, with_corrections

#: How to provide the command with odometry that the log lacks.
NO_ODOMETRY = " `gridbloom slam {log} --out out/slam` writes it: then add --tum-trajectory out/slam.tum here."
COVARIANCE = ".covariance.csv"
LEAST_CONVERGED = 0.5  #: share of the scans since the filter first converged; a smaller share is reported


@app.command()
@with_parameter_options("mount_upside_down", "time_offset")
def localize(
    log: LogPath,
    map_file: Annotated[Path, typer.Option("--map", metavar="MAP.yaml", help="The map, or a map of CMU's course.")],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="POSES.tum",
            help="Write the poses in the map, in the log's order, of the scans at which they are known, and "
            "POSES.covariance.csv: how certain that of each scan is, and whether the filter had converged.",
        ),
    ] = None,
    initial_pose: Annotated[
        str | None,
        typer.Option(metavar="X,Y,YAW", help="Where in the map the robot starts (m, m, rad). [anywhere]"),
    ] = None,
    params: Annotated[
        Path | None, typer.Option(metavar="AMCL.yaml", help="Parameters of an AMCL, as Nav2 or ROS 1 has them.")
    ] = None,
    values: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A localization parameter; given again, another one."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Seed of random numbers. [0]", show_default=False)] = 0,
    topic: TopicNames = None,
    trajectory: TrajectoryName = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Find the robot of a log in a map, by its odometry and its scans (Monte Carlo localization)."""
    mapping = configured(given_parameters(parameters, mount))
    begin = None
    if initial_pose is not None:
        begin = numbers("--initial-pose", "three numbers, X,Y,YAW in metres and radians", 3, initial_pose)
    config, of_parameters = _configured(params, values or [])
    with refusing(map_file):
        loaded = load_map(map_file)
        if begin is not None:
            check_pose(loaded.grid.geometry, begin)
    if out is not None:
        make_folder_of(out)
    scans = with_corrections(log, read_joint(log, topic or (), tum_trajectory, tf), mapping)
    with progress_bar("Localizing") as bar:
        try:
            localized = localize_log(
                scans, loaded.grid, config, trajectory=trajectory, initial_pose=begin, seed=seed, progress=bar
            )
        except MapperError as error:
            remedy = NO_ODOMETRY.format(log=log) if error.code == "localization.no_odometry" else ""
            fail(f"{log} in {map_file}: {error.message}{remedy}")
    written = [] if out is None else _write(out, scans, localized, loaded.description.frame or "map")
    notes = [*scans.notes, *loaded.notes, *of_parameters]
    first = localized.first_converged
    notes += [] if first is None else doubts(localized, first)
    unknown = localized.is_known.size - int(localized.is_known.sum())
    last_pose = [round(float(v), 6) for v in localized.poses[-1]]
    facts: dict[str, object] = {
        "log": scans.name,
        "map": map_file.name,
        "scans": scans.n_scans,
        "odometry": localized.odometry,
        "initial_pose": begin,
        "converged_at_scan": first,
        "scans_converged": int(localized.is_converged.sum()),
        "scans_sure": int(localized.is_sure.sum()),
        "scans_left_out": unknown,
        "last_pose": last_pose,
        "last_converged": bool(localized.is_converged[-1]),
        "last_sure": bool(localized.is_sure[-1]),
        "median_fit": round(float(sorted(localized.fit)[len(localized.fit) // 2]), 4),
        "cpu_seconds": round(localized.cpu_seconds, 3),
        "files": [str(path) for path in written],
        "notes": notes,
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{scans.name} in {map_file.name}: {scans.n_scans} scans, odometry {localized.odometry!r}")
    if first is None:
        typer.echo("  The filter never converged: where the robot was is not known.")
    else:
        typer.echo(f"  converged at scan {first}; it had converged at {facts['scans_converged']} scans")
        typer.echo(f"  sure of the place at {facts['scans_sure']} scans: other places in the map were ruled out there")
    if unknown:
        typer.echo(f"  left out: {unknown} scans, at which the filter had not converged and no pose is known")
    x, y, yaw = last_pose
    not_there = "" if facts["last_sure"] else ", not sure: other places in the map were not ruled out there"
    if not facts["last_converged"]:
        not_there = ", not certain: the filter had not converged there"
    typer.echo(f"  last pose {x:.3f} m, {y:.3f} m, {yaw:.4f} rad{not_there}")
    typer.echo(f"  median fit {facts['median_fit']:.2f}; 1 is the greatest")
    typer.echo(f"  {localized.cpu_seconds:.1f} s of processor time")
    for path in written:
        typer.echo(f"  wrote {path}")
    print_notes(notes)


def doubts(localized: Localized, first: int) -> list[str]:
    """Return a sentence if the filter, once converged, was mostly uncertain, and one if it was never sure.

    ``first`` is the scan at which it converged.
    """
    since, out = localized.is_converged[first:], []
    if since.mean() < LEAST_CONVERGED:
        out.append(
            f"From scan {first} on the filter had converged at {int(since.sum())} of {len(since)} scans only: "
            "this may not be the map of where the log was recorded."
        )
    if not localized.is_sure.any():
        out.append(
            "The place is not sure at any scan: the robot may have been elsewhere. The scans fit other places of this "
            "map nearly as well, or they contradict it."
        )
    return out


def _configured(params: Path | None, values: list[str]) -> tuple[LocalizationConfig, list[str]]:
    """Return the parameters of a yaml with those given as NAME=VALUE replaced, and notes on the yaml.

    Errors end the command.
    """
    config = LocalizationConfig()
    notes: list[str] = []
    if params is not None:
        with refusing(params):
            read = read_amcl_yaml(params)
        config, notes = read.config, [*read.notes]
        if read.ignored:
            notes.append(f"Of the parameters, these say nothing about where the robot is: {', '.join(read.ignored)}.")
    typed = set_values({row.name: row for row in PARAMETERS}, values)
    try:
        return config.with_values(typed), notes
    except MapperError as error:
        fail(error.message)


def _write(path: Path, log: ScanLog, localized: Localized, frame: str) -> list[Path]:
    placed = replace(
        log, trajectories={LOCALIZED: Trajectory(localized.poses, "localized in a map", frame, from_scans=True)}
    ).take(localized.is_known)
    texts = {path.with_suffix(COVARIANCE): "".join(covariance_lines(log, localized))}
    if placed.n_scans:
        texts = {path: tum_text(placed, LOCALIZED), **texts}
    for place, text in texts.items():
        with output_file(place) as file:
            file.write(text.encode())
    return list(texts)
