"""The note of ``map`` on poses that drift."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from mapper.mapping.parameters import MappingConfig

if TYPE_CHECKING:
    from mapper.sensors.scan import ScanLog

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print no notes, and do not check whether the poses drift.")]

SAME_POSES_M = 0.2  #: trajectories that are nowhere farther apart count as the same poses from two sources


def drift_note(log: ScanLog, trajectory: str | None, config: MappingConfig) -> str | None:
    """Return one line that says that the poses drift and what to do about it; None if they do not."""
    from mapper.diagnosis import drift_finding  # noqa: PLC0415 - start-up

    found = drift_finding(log, trajectory, config)
    if found is None or found.check != "walls.drift":  # a log without poses already has a note
        return None
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
