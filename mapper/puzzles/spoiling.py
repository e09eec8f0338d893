"""Logs with a fault for puzzles, and their repair."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.parameter import Values
from mapper.core.se2 import compose
from mapper.puzzles.causes import CAUSES, Cause
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses
from mapper.simulation.odometry import WORN_ALPHAS, WORN_TURN_BIAS, drifting_odometry

Positions = NDArray[np.float64]
Altering = Callable[[NDArray[np.int64], Positions], Positions]
"""Maps stamps (n,), nanoseconds, and positions (n, 2), metres, to the altered positions (n, 2)."""


def with_positions(log: ScanLog, name: str, alter: Altering) -> Trajectory:
    """Return the trajectory ``name`` of a log with altered positions, at and between the scans; headings are
    unchanged.
    """
    trajectory = log.trajectory(name)
    timed = trajectory.timed
    return replace(
        trajectory,
        poses=_altered(log.stamps_ns, trajectory.poses, alter),
        timed=None if timed is None else TimedPoses(timed.stamps_ns, _altered(timed.stamps_ns, timed.poses, alter)),
    )


def _altered(stamps_ns: NDArray[np.int64], poses: NDArray[np.float64], alter: Altering) -> NDArray[np.float64]:
    return np.column_stack([alter(stamps_ns, poses[:, :2]), poses[:, 2]])


def truncated_positions(xy: Positions, side: float) -> Positions:
    """Return positions converted by truncation to a cell index and a position within the cell, and back.

    ``xy`` are metres, any shape, and ``side`` is that of a cell, metres. The index is ``trunc(x / side)``, which is
    ``floor(x / side)`` above zero and one more below it; the position is the remainder ``x mod side``, at least 0. So
    positive values are unchanged, and negative ones are shifted by one cell: −0.1 m in cells of 0.25 m becomes 0.15 m.
    """
    result: Positions = side * np.trunc(xy / side) + np.mod(xy, side)
    return result


PERSON_RADIUS = 0.22  #: metres
FOLLOWING_M = (1.3, 2.4)  #: metres of the robot's path by which people follow it
SWAY_M = 0.35  #: metres to either side of that path
BEFORE_RANGE_MAX = 0.1  #: metres by which the max range must be lowered, so that readings at it are not hits
SEEN_BEYOND, BEYOND = 0.05, 0.15  #: minimum fraction of readings without return; their fraction otherwise
RESTARTED = (0.4, 0.6)  #: fraction of the scans after which positions count from another origin
WHEELS, LOCALIZATION = "What the wheels report.", "Where localization says that the robot is."
MISS_OF_TRAILS, LOWER_CLAMP_OF_TRAILS = -0.1, -0.5  #: values with which trails of people stay in the map


@dataclass(frozen=True, slots=True)
class Spoiled:
    """A log with a fault.

    ``log`` is shown, mapped along ``trajectory`` with the parameters ``start``; ``repair`` are the parameters and
    ``repair_trajectory`` the trajectory that repair it. ``reference`` is the log without the fault, mapped with
    ``reference_values`` along ``reference_trajectory``. All values are changes relative to the log's initial
    parameters.
    """

    log: ScanLog
    trajectory: str
    reference: ScanLog
    reference_trajectory: str
    start: Mapping[str, Any] = field(default_factory=dict)
    repair: Mapping[str, Any] = field(default_factory=dict)
    reference_values: Mapping[str, Any] = field(default_factory=dict)
    repair_trajectory: str = ""

    @property
    def repaired_along(self) -> str:
        """The trajectory of the repaired map."""
        return self.repair_trajectory or self.trajectory


def spoil(log: ScanLog, cause: str, seed: int, trajectory: str | None = None) -> Spoiled:
    """Return ``log`` with a fault that any log can have, with a random size determined by ``seed``.

    Raises :class:`ConfigError` for another cause, and for a log whose poses do not reveal a drift or an offset.
    """
    if cause not in _SPOILERS:
        raise ConfigError(
            "puzzle.cause", f"There is no fault {cause!r:.80} of a log; there are {', '.join(_SPOILERS)}."
        )
    if log.n_scans < 2:
        raise ConfigError("puzzle.short", "A puzzle needs a log of at least two scans.")
    name = trajectory or log.default_trajectory
    if log.trajectory(name).is_placeholder:
        raise ConfigError("puzzle.poses", "This log has no poses: its map says nothing about a fault.")
    return _SPOILERS[cause](log, name, np.random.default_rng(seed))


def _size(cause: Cause, rng: np.random.Generator, *, signed: bool = True) -> float:
    value = round(float(rng.uniform(*cause.amount)), 2)
    return value if not signed or rng.random() < 0.5 else -value


def _with_values(log: ScanLog, name: str, start: Values) -> Spoiled:
    return Spoiled(log, name, log, name, start)


def _resolution(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    return _with_values(log, name, {"resolution": _size(CAUSES["resolution"], rng, signed=False)})


def _window(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    if log.beam_width > 0.0:
        raise ConfigError("puzzle.cause", "A wide hit window is not a fault of a sonar’s map.")
    return _with_values(log, name, {"window": _size(CAUSES["window"], rng, signed=False)})


def _max_range(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:  # noqa: ARG001 - as all of them
    beyond = log.ranges >= log.range_max  # also +inf
    top = min(round(log.range_max, 1), 100.0)
    if beyond.mean() < SEEN_BEYOND:
        # As measured by a sensor of shorter range.
        finite = log.ranges[np.isfinite(log.ranges)]
        top = max(1.0, round(float(np.quantile(finite, 1.0 - BEYOND)), 1)) if len(finite) else 1.0
        beyond = log.ranges > top
    top = max(top, log.range_min + 2.0 * BEFORE_RANGE_MAX)
    short = {"range_max": float(np.clip(top, 0.5, 100.0))}
    repaired = {"range_max": round(short["range_max"] - BEFORE_RANGE_MAX, 2)}
    ranges = np.where(beyond, np.float32(short["range_max"]), log.ranges)
    shown = replace(log, ranges=np.minimum(ranges, np.float32(short["range_max"])), range_max=short["range_max"] + 0.01)
    clean = replace(log, ranges=np.where(beyond, np.float32(np.inf), log.ranges))
    return Spoiled(shown, name, clean, name, short, repaired, repaired)


def _mounted(log: ScanLog, off: tuple[float, float, float]) -> ScanLog:
    """Return the log with a wrong stated mount: composed with ``off``."""
    x, y, yaw = (float(v) for v in compose(np.array(log.mount), np.array(off)))
    mounts = None if log.mounts is None else compose(log.mounts, np.array(off))
    return replace(log, mount=(x, y, yaw), mounts=mounts)


def _mount_yaw(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    yaw = _size(CAUSES["mount_yaw"], rng)
    return Spoiled(_mounted(log, (0.0, 0.0, -yaw)), name, log, name, {}, {"mount_yaw": yaw})


def _mount_x(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    x = _size(CAUSES["mount_x"], rng)
    return Spoiled(_mounted(log, (-x, 0.0, 0.0)), name, log, name, {}, {"mount_x": x})


def _beam_order(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:  # noqa: ARG001 - as all of them
    shown = replace(log, upside_down=not log.upside_down)
    return Spoiled(shown, name, log, name, {}, {"mount_upside_down": True})


def _along_wrong(log: ScanLog, name: str, wrong: str, poses: Trajectory) -> Spoiled:
    """Return the log along the trajectory ``poses``, called ``wrong``, with the correct one called ``name`` in
    addition.
    """
    # The log may already have a trajectory of that name, which is then replaced.
    others = {key: value for key, value in log.trajectories.items() if key not in (wrong, name)}
    right = name if name != wrong else "corrected"
    shown = replace(log, trajectories={wrong: poses, right: log.trajectory(name), **others})
    return Spoiled(shown, wrong, log, name, repair_trajectory=right)


def _drift(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    times = _size(CAUSES["drift"], rng, signed=False)
    a1, a2, a3, a4 = (times * value for value in WORN_ALPHAS)
    poses = drifting_odometry(log.trajectory(name).poses, rng, (a1, a2, a3, a4), times * WORN_TURN_BIAS)
    return _along_wrong(log, name, "odometry", Trajectory(poses, WHEELS, "odom"))


def _grid_origin(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    size, angle = _size(CAUSES["grid_origin"], rng, signed=False), rng.uniform(0.0, 2.0 * math.pi)
    offset = np.array([size * math.cos(angle), size * math.sin(angle)])
    first = log.stamps_ns[round(log.n_scans * float(rng.uniform(*RESTARTED)))]
    moved = with_positions(log, name, lambda stamps, xy: xy + np.where((stamps >= first)[:, np.newaxis], offset, 0.0))
    return _along_wrong(log, name, "localization", replace(moved, description=LOCALIZATION))


def _truncation(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    side = _size(CAUSES["truncation"], rng, signed=False)
    middle = np.median(log.trajectory(name).poses[:, :2], axis=0)
    centred = replace(
        log,
        trajectories={key: with_positions(log, key, lambda _, xy: xy - middle) for key in log.trajectories},
    )
    wrong = with_positions(centred, name, lambda _, xy: truncated_positions(xy, side))
    if np.array_equal(wrong.poses, centred.trajectory(name).poses):
        raise ConfigError("puzzle.still", "The robot does not move in this log: no pose is truncated to another cell.")
    return _along_wrong(centred, name, "localization", replace(wrong, description=LOCALIZATION))


def _time_offset(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    late = _size(CAUSES["time_offset"], rng)
    if not (np.diff(log.stamps_ns) > 0).any():
        raise ConfigError("puzzle.stamps", "All stamps of this log are equal: a time offset changes nothing.")
    motions = {key: Motion.of(log, key) for key in log.trajectories}
    stamps = log.stamps_ns + round(late * 1e9)
    shown = replace(
        log,
        stamps_ns=stamps,
        order_ns=None if log.order_ns is None else log.order_ns + round(late * 1e9),
        trajectories={
            key: replace(
                trajectory,
                poses=motions[key].at(seconds(log) + late),
                timed=TimedPoses(np.rint(motions[key].times * 1e9).astype(np.int64), motions[key].poses),
            )
            for key, trajectory in log.trajectories.items()
        },
    )
    return Spoiled(shown, name, log, name, {}, {"time_offset": -late})


def _people(log: ScanLog, name: str, rng: np.random.Generator) -> Spoiled:
    ranges = log.ranges.copy()
    poses, sensor = log.trajectory(name).poses, log.sensor_poses(name)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))])
    for behind in FOLLOWING_M:
        phase = rng.uniform(0.0, 2.0 * math.pi)
        at = np.searchsorted(along, along - behind, side="right") - 1
        walking = along >= behind
        side = poses[at, 2] + 0.5 * math.pi
        sway = SWAY_M * np.sin(along + phase)
        places = poses[at, :2] + sway[:, np.newaxis] * np.column_stack([np.cos(side), np.sin(side)])
        seen = disc_ranges(sensor, log.angles, places, PERSON_RADIUS)
        ranges = np.where(walking[:, np.newaxis] & (seen < ranges) & (seen > log.range_min), seen, ranges)
    start = {"log_odds_miss": MISS_OF_TRAILS, "log_odds_min": LOWER_CLAMP_OF_TRAILS}
    repair = {"log_odds_miss": -0.4, "log_odds_min": -6.0}
    return Spoiled(replace(log, ranges=ranges.astype(np.float32)), name, log, name, start, repair)


def disc_ranges(
    sensor_poses: NDArray[np.float64], angles: NDArray[np.float64], centres: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    """Return the ranges (n, b), metres, at which beams hit a disc, +inf if they miss.

    ``sensor_poses`` (n, 3) are ``T_map_laser``, ``angles`` (b,) radians in the laser frame, ``centres`` (n, 2) metres.
    A beam at an angle δ from the direction of the centre, which is at distance d, hits it at d cos δ − √(r² − d² sin²
    δ).
    """
    dx, dy = (centres - sensor_poses[:, :2]).T
    distance = np.hypot(dx, dy)[:, np.newaxis]
    off = np.arctan2(dy, dx)[:, np.newaxis] - sensor_poses[:, 2:] - angles[np.newaxis, :]
    root = radius**2 - (distance * np.sin(off)) ** 2
    met = (root > 0.0) & (np.cos(off) > 0.0) & (distance > radius)
    return np.where(met, distance * np.cos(off) - np.sqrt(np.maximum(root, 0.0)), np.inf)


_SPOILERS: Mapping[str, Callable[[ScanLog, str, np.random.Generator], Spoiled]] = MappingProxyType(
    {
        "resolution": _resolution,
        "window": _window,
        "max_range": _max_range,
        "mount_yaw": _mount_yaw,
        "mount_x": _mount_x,
        "beam_order": _beam_order,
        "drift": _drift,
        "grid_origin": _grid_origin,
        "truncation": _truncation,
        "time_offset": _time_offset,
        "people": _people,
    }
)
