"""The notes of ``map`` and ``info`` on what makes the map bad: the doctor's first cause, or that poses drift."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from mapper.mapping.parameters import MappingConfig

if TYPE_CHECKING:
    from mapper.diagnosis import Finding
    from mapper.sensors.scan import ScanLog

Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Print no notes, and do not look for what makes the map bad.")
]

SAME_POSES_M = 0.2  #: trajectories that are nowhere farther apart count as the same poses from two sources
DRIFT = "walls.drift"


def cause_and_drift(log: ScanLog, trajectory: str | None, config: MappingConfig) -> tuple[str | None, str | None]:
    """Return the line on the first cause of a bad map, and where none is known the line that the poses drift."""
    from mapper.diagnosis import first_cause  # noqa: PLC0415 - start-up

    found = first_cause(log, trajectory, config)
    if found is None:
        return None, None
    if found.check != DRIFT:
        return cause_line(found), None
    return None, _drift_line(log, trajectory)


def cause_line(finding: Finding) -> str:
    """Return a finding with its advice, and the options that help."""
    options = [f"--{name.replace('_', '-')} {value}" for name, value in _options(finding).items()]
    remedy = f" Try {' '.join(options)}." if options else ""
    return f"{finding.sentence} {finding.advice}{remedy}"


def _options(finding: Finding) -> dict[str, object]:
    """Return the parameters that help, as options of ``map`` that its advice does not name already."""
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
        other for other, one in log.trajectories.items() if np.abs(one.poses[:, :2] - poses[:, :2]).max() > SAME_POSES_M
    ]
    remedy = (
        f"try other poses of this log with --trajectory {' or '.join(others)}, or correct them with gridbloom slam"
        if others
        else "correct them with gridbloom slam; the log has no different ones"
    )
    return f"The poses of trajectory {name!r} drift, so walls may be double: {remedy}."
