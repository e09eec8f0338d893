"""Duplicate trajectories of a log, such as from tf and odometry, and the default pair for comparison."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.sensors.scan import Trajectory

SAME_M, SAME_RAD = 0.001, 0.001  #: tolerance for the poses of one path, each relative to its first pose
FEW = 64  #: poses sufficient to distinguish most paths
_WHEELS = re.compile("odom|wheel", re.IGNORECASE)  #: in the names of wheel odometry


def is_same_path(first: Float64Array, second: Float64Array) -> bool:
    """Return whether poses (n, 3) equal those of another trajectory at the same times, up to the choice of origin."""
    if first.shape != second.shape:
        return False
    return all(_are_close(first[::step], second[::step]) for step in (1 + len(first) // FEW, 1))


def _are_close(first: Float64Array, second: Float64Array) -> bool:
    if not len(first):
        return True
    from_first = [compose(inverse(poses[0]), poses) for poses in (first, second)]
    off = from_first[0] - from_first[1]
    return bool(np.hypot(off[:, 0], off[:, 1]).max() <= SAME_M and np.abs(wrap_angle(off[:, 2])).max() <= SAME_RAD)


def stated_before(trajectories: Mapping[str, Trajectory]) -> dict[str, str]:
    """Return, for each trajectory whose path is also that of an earlier one, the name of the earlier one."""
    same: dict[str, str] = {}
    for name, trajectory in trajectories.items():
        for earlier in trajectories:
            if earlier == name:
                break
            if earlier not in same and is_same_path(trajectories[earlier].poses, trajectory.poses):
                same[name] = earlier
                break
    return same


def first_pair(trajectories: Mapping[str, Trajectory], same: Mapping[str, str]) -> tuple[str, str] | None:
    """Return the default reference and estimate for comparison; None with fewer than two trajectories.

    The reference is the last one estimated from the scans, and the estimate is the wheels. They are never the same
    path, according to ``same`` (:func:`stated_before`), unless there is only one path.
    """
    paths = [name for name in trajectories if name not in same]
    if len(trajectories) < 2:
        return None
    if len(paths) < 2:
        first, second, *_ = trajectories
        return first, second
    by_scans = [name for name in paths if trajectories[name].from_scans][-1:]
    others = [name for name in paths if name not in by_scans]
    wheels = [name for name in others if by_scans and not trajectories[name].from_scans and _WHEELS.search(name)]
    reference, estimate = [*by_scans, *wheels[:1], *(name for name in others if name not in wheels[:1])][:2]
    return reference, estimate
