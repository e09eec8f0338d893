"""``map`` computes the map of a log and reports why it is bad."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from mapper.diagnosis import Finding, first_cause
from mapper.io.export import GrowingMap, tum_text, write_mcap
from mapper.mapping.integrate import bounds_of_logs, grid_for, integrate_log, integrate_logs
from mapper.mapping.parameters import PARAMETERS, MappingConfig, recorded_defaults
from mapper.mapping.scan_batch import covered_scans, deskewed_scans
from mapper.mapping.update_plan import plan_update
from mapper.sensors.joint_log import JointLog, sensors_of
from mapper.sensors.planar.options import PARAMETERS as CUT_PARAMETERS
from mapper.sensors.scan import ScanLog
from server.cli.commands import app
from server.cli.common import (
    MOUNT,
    AsJson,
    FirstScans,
    LogPath,
    Mount,
    TfTopic,
    TopicNames,
    TrajectoryName,
    TumTrajectory,
    configured,
    fail,
    given_cut,
    given_parameters,
    output_file,
    print_json,
    print_notes,
    progress_bar,
    refusing,
    with_parameter_options,
)
from server.cli.map_files import OUT_HELP, MapMode, check_mode, save, states
from server.cli.maps.prior import Prior, PriorFrame, given_prior
from server.cli.reading import check_mount, read_sensors

Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Print no notes, and do not look for what makes the map bad.")
]

SAME_POSES_M = 0.2  #: trajectories that are never farther apart count as the same poses from two sources
DRIFT = "walls.drift"


@app.command("map")
@with_parameter_options(
    *(row.name for row in PARAMETERS if row.name not in (*MOUNT, "log_odds_prior")), more=CUT_PARAMETERS
)
def map_log(
    log: LogPath,
    topic: TopicNames = None,
    trajectory: TrajectoryName = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
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
    cut = given_cut(parameters)
    values, prior_map = given_prior(prior, prior_frame, given_parameters(parameters, mount))
    check_mode(mode)
    topics = list(dict.fromkeys(topic or ()))
    logs = read_sensors(log, topics, tum_trajectory, cut, tf)
    check_mount(len(logs), configured(values))
    scans = logs[0]
    with refusing(log):
        trajectory = trajectory or scans.default_trajectory
        frame, notes_on_sensors = _frame_of(logs, trajectory)
    read_notes = [*dict.fromkeys(note for log in logs for note in log.notes), *notes_on_sensors]
    notes = [*read_notes, *(prior_map.notes_for(scans, trajectory) if prior_map else ())]
    if prior_map is not None:
        frame = prior_map.frame
    config = _config_for(logs, values)
    with refusing(log, notes):
        grid = grid_for(
            scans,
            config,
            trajectory,
            prior=prior_map.grid if prior_map else None,
            bounds_of=lambda _, config, name: bounds_of_logs(logs, config, name),
        )
        # With no scans, this compiles the kernels, or loads them from the cache, before time is measured.
        integrate_log(grid, scans, config, trajectory, 0, 0)
        with progress_bar("Mapping") as bar:
            start = time.perf_counter()
            updated = integrate_logs(
                grid,
                logs,
                config,
                trajectory,
                first_scans,
                progress=bar and (lambda done, total: bar(done / max(1, total))),
            )
            seconds = time.perf_counter() - start
    deskewed, notes_on_times = _deskewed(logs, config, trajectory)
    notes += notes_on_times
    cause, drift = (None, None) if quiet else cause_and_drift(scans, trajectory, config)
    offset = scans.trajectory(trajectory).offset
    written = save(grid, out, mode, frame, offset) if out is not None else []
    if mcap is not None or tum is not None:
        with refusing(log):
            whole = _joined(logs)
        written += _export(whole, GrowingMap(grid, config, first_scans), trajectory, mcap, tum)
    geometry = grid.geometry
    origin = [geometry.origin[0] + offset[0], geometry.origin[1] + offset[1], geometry.origin[2]]
    facts: dict[str, object] = {
        "log": scans.name,
        "trajectory": trajectory,
        "frame": frame,
        "scans": sum(log.n_scans for log in logs) if first_scans is None else first_scans,
        "beams": scans.n_beams,
        "deskewed_scans": deskewed,
        "cells_updated": updated,
        "seconds": round(seconds, 6),
        "resolution": geometry.resolution,
        "rows": geometry.rows,
        "cols": geometry.cols,
        "origin": origin,
        **states(grid),
        "files": [str(path) for path in written],
        "notes": notes,
    }
    if len(logs) > 1:
        facts["sensors"] = [{"topic": log.topic, "scans": log.n_scans, "beams": log.n_beams} for log in logs]
    if not quiet:
        facts |= {"cause": cause, "drift": drift}
    if as_json:
        print_json(facts)
        return
    beams = " and ".join(dict.fromkeys(str(log.n_beams) for log in logs))
    of = f" of {len(logs)} sensors" if len(logs) > 1 else ""
    typer.echo(f"{facts['log']}: {facts['scans']} scans of {beams} beams{of}, trajectory {facts['trajectory']}")
    typer.echo(
        f"  {geometry.size_text} cells of {geometry.resolution:g} m, "
        f"origin {', '.join(f'{value:.10g}' for value in origin)}"
    )
    typer.echo(f"  {facts['occupied']} occupied, {facts['free']} free, {facts['unknown']} unknown")
    typer.echo(
        f"  {facts['information_gain_bits']:.0f} bits learned, {facts['entropy_bits']:.0f} bits open in seen cells"
    )
    if deskewed:
        typer.echo(f"  {deskewed} of the log's scans deskewed")
    typer.echo(f"  {updated} cell updates in {seconds:.3f} s")
    for path in written:
        typer.echo(f"  wrote {path}")
    if quiet:
        return
    print_notes([*notes, *(finding for finding in (cause, drift) if finding)])


def _joined(logs: Sequence[ScanLog]) -> ScanLog:
    """Return the sensors as one log."""
    return logs[0] if len(logs) == 1 else JointLog.of(logs)


def _frame_of(logs: Sequence[ScanLog], trajectory: str) -> tuple[str | None, list[str]]:
    """Return the frame of the poses of all sensors, and notes; end the command if they differ."""
    trajectories = [log.trajectory(trajectory) for log in logs]
    frames = dict.fromkeys(trajectory.frame_id for trajectory in trajectories)
    if len(frames) < 2:
        return trajectories[0].frame_id, []
    if not all(trajectory.is_placeholder for trajectory in trajectories):
        fail(f"The poses of these sensors are in different frames: {', '.join(map(repr, frames))}.")
    return trajectories[0].frame_id, [
        "Where these sensors sit on the robot is not known; all are taken to be in one place."
    ]


def _deskewed(logs: Sequence[ScanLog], config: MappingConfig, trajectory: str) -> tuple[int, list[str]]:
    """Return the number of deskewed scans, and a note on those that have no pose because of the time offset."""
    deskewed = left_out = 0
    for sensor in (part for log in logs for part in sensors_of(log)):
        plan = plan_update(config, sensor.range_min, sensor.range_max)
        deskewed += int(deskewed_scans(sensor, plan, trajectory).sum())
        left_out += int((~covered_scans(sensor, plan, trajectory)).sum())
    scans, are = ("1 scan is", "is") if left_out == 1 else (f"{left_out} scans are", "are")
    note = f"With this time offset {scans} from before or after all poses, and {are} left out."
    return deskewed, [note] if left_out else []


def _config_for(logs: Sequence[ScanLog], values: dict[str, object]) -> MappingConfig:
    """Return the parameters that suit all sensors; end the command if these need different ones."""
    configs = {configured(recorded_defaults(log.beam_width, values)) for log in logs}
    if len(configs) > 1:
        fail("The sensors need different models, as a sonar and a lidar do: map each by itself, and merge the maps.")
    return configs.pop()


def _export(
    log: ScanLog, growing_map: GrowingMap, trajectory: str | None, mcap: Path | None, tum: Path | None
) -> list[Path]:
    """Write the requested files; return their paths."""
    for path in (mcap, tum):
        if path is None:
            continue
        with output_file(path) as file:
            if path is tum:
                file.write(tum_text(log, trajectory).encode())
            else:
                with progress_bar("Writing") as progress:
                    write_mcap(file, log, growing_map, trajectory, progress)
    return [path for path in (mcap, tum) if path is not None]


def cause_and_drift(log: ScanLog, trajectory: str | None, config: MappingConfig) -> tuple[str | None, str | None]:
    """Return the line on the first cause of a bad map, and if none is known the line that the poses drift."""
    cause = first_cause(log, trajectory, config)
    if cause is None or any(note.startswith(cause.sentence) for note in log.notes):
        return None, None
    if cause.check != DRIFT:
        return cause_line(cause), None
    return None, _drift_line(log, trajectory)


def cause_line(finding: Finding) -> str:
    """Return a finding with its advice, and the options that help."""
    options = [f"--{name.replace('_', '-')} {value}" for name, value in _options(finding).items()]
    remedy = f" Try {' '.join(options)}." if options else ""
    return f"{finding.sentence} {finding.advice}{remedy}"


def _options(finding: Finding) -> dict[str, object]:
    """Return the helpful parameters, as options of ``map`` that its advice does not already name."""
    values = dict(finding.parameters or {})
    mount = [values.pop(f"mount_{axis}", 0.0) for axis in ("x", "y", "yaw")]
    options: dict[str, object] = {"mount": ",".join(f"{value:g}" for value in mount)} if any(mount) else {}
    for name, value in values.items():
        if f"--{name.replace('_', '-')}" not in finding.advice and value is not False:
            options[name] = "on" if value is True else value
    return options


def _drift_line(log: ScanLog, trajectory: str | None) -> str:
    """Return the line that the poses drift and what to do about it."""
    name = trajectory or log.default_trajectory
    poses = log.trajectory(name).poses
    others = [
        other
        for other, trajectory in log.trajectories.items()
        if np.abs(trajectory.poses[:, :2] - poses[:, :2]).max() > SAME_POSES_M
    ]
    remedy = (
        f"try other poses of this log with --trajectory {' or '.join(others)}, or correct them with gridbloom slam"
        if others
        else "correct them with gridbloom slam; the log has no different ones"
    )
    return f"The poses of trajectory {name!r} drift, so walls may be double: {remedy}."
