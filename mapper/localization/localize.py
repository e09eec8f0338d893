"""Localization of a whole log in a map, as a trajectory in the map's frame."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.se2 import compose, inverse
from mapper.grid import OccupancyGrid
from mapper.localization.confidence import is_jump
from mapper.localization.known import known_scans
from mapper.localization.map_model import MapModel
from mapper.localization.monte_carlo import MonteCarloLocalizer
from mapper.localization.parameters import LocalizationConfig
from mapper.localization.scan_beams import scan_beams
from mapper.sensors.joint_log import sensor_of_scan
from mapper.sensors.scan import ScanLog

LOCALIZED = "localized"  #: name of the trajectory
SETTLED = 20  #: scans after convergence, of which the most certain pose is propagated back
BEFORE_JUMP = 5  #: scans before such a jump at which the robot may already have been elsewhere


@dataclass(frozen=True, slots=True, eq=False)
class Localized:
    """Estimated poses at each scan, in log order.

    ``poses`` (n, 3) are ``T_map_base``; before the filter first converged, they are propagated back along the odometry
    (:func:`carry_back`). ``covariance`` (n, 3, 3) is that of x, y and yaw, of all particles before the filter
    ``is_converged`` (n,). ``share`` (n,) is the weight of the heaviest cluster, ``fit`` (n,) the fit of the last used
    scan, ``n_particles`` (n,) the number of particles, ``entropy`` (n,) that of their histogram, bits, and
    ``is_updated`` (n,) whether the scan was used. ``odometry`` is the trajectory used. ``is_sure`` (n,) means that
    other places were ruled out, by the scans up to then or by later ones (:func:`confirmed`).
    """

    poses: Float64Array
    covariance: Float64Array
    is_converged: NDArray[np.bool_]
    share: Float64Array
    fit: Float64Array
    n_particles: NDArray[np.int64]
    entropy: Float64Array
    is_updated: NDArray[np.bool_]
    odometry: str
    cpu_seconds: float
    is_sure: NDArray[np.bool_]

    @property
    def is_known(self) -> NDArray[np.bool_]:
        """At which scans (n,) the pose is known (:func:`mapper.localization.known.known_scans`); maps contain those."""
        return known_scans(self.is_converged)

    @property
    def first_converged(self) -> int | None:
        """The first scan at which the filter had converged; None if it never did."""
        converged_scans = np.flatnonzero(self.is_converged)
        return int(converged_scans[0]) if len(converged_scans) else None


def odometry_of(log: ScanLog, trajectory: str | None = None) -> str:
    """Return the odometry trajectory: ``trajectory``, else one identified as odometry, else the log's first.

    It is identified by a frame that ends in ``odom``, or else by a name that contains it. Raises :class:`ConfigError`
    for a log without odometry.
    """
    if trajectory is not None:
        moving = [trajectory] if not log.trajectory(trajectory).is_placeholder else []
    else:
        named = [name for name, trajectory in log.trajectories.items() if not trajectory.is_placeholder]
        raw = [name for name in named if (log.trajectories[name].frame_id or "").strip("/").endswith("odom")]
        moving = raw or [name for name in named if "odom" in name.lower()] or named
    if not moving:
        raise ConfigError(
            "localization.no_odometry",
            "The log has no odometry: localization needs to know how the robot moved between its scans. Add a "
            "trajectory to the log, as SLAM makes one of the scans alone.",
        )
    return moving[0]


def localize_log(
    log: ScanLog,
    grid: OccupancyGrid | MapModel,
    config: LocalizationConfig | None = None,
    *,
    trajectory: str | None = None,
    initial_pose: ArrayLike | None = None,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    may_continue: Callable[[], bool] | None = None,
    watch: Callable[[int, MonteCarloLocalizer], None] | None = None,
) -> Localized:
    """Return the robot's pose in a map at each scan of a log, from the odometry ``trajectory`` and the scans.

    The scans of a :class:`mapper.sensors.joint_log.JointLog` belong to several sensors, each with its mount. Without an
    ``initial_pose`` (3,) the filter starts everywhere. ``progress`` is called with the fraction done; ``may_continue``
    is called from time to time, and False raises :class:`WorkCancelledError`; ``watch`` is called with the index of
    each scan and the filter after it. Raises :class:`ConfigError` for a log without scans or odometry, a map without
    free or occupied cells, and a pose outside it.
    """
    began = time.process_time()
    config = config or LocalizationConfig()
    n = log.n_scans
    if not n:
        raise ConfigError("log.no_scans", "The log has no scans to localize with.")
    name = odometry_of(log, trajectory)
    odometry = log.trajectory(name).poses
    robot = MonteCarloLocalizer(
        grid, config, range_min=log.range_min, range_max=log.range_max, mount=log.mount, initial_pose=initial_pose,
        seed=seed,
    )  # fmt: skip
    poses, covariance = np.empty((n, 3)), np.empty((n, 3, 3))
    converged, numbers = np.zeros(n, dtype=np.bool_), np.empty((n, 3))
    counts, used = np.empty(n, dtype=np.int64), np.zeros(n, dtype=np.bool_)
    sure = np.zeros(n, dtype=np.bool_)
    sensors = sensor_of_scan(log).tolist()
    for i in range(n):
        if may_continue is not None and not may_continue():
            raise WorkCancelledError("localization.cancelled", "The localization was cancelled.")
        x, y, yaw = log.mount_of(i).tolist()
        update = robot.update_beams(odometry[i], scan_beams(log.scan(i), (x, y, yaw), config), sensors[i])
        poses[i], covariance[i], converged[i] = update.pose, update.covariance, update.is_converged
        numbers[i] = update.share, update.fit, update.entropy
        counts[i], used[i], sure[i] = update.n_particles, update.is_updated, update.is_sure
        if watch is not None:
            watch(i, robot)
        if progress is not None:
            progress((i + 1) / n)
    sure = confirmed(poses, odometry, converged, sure)
    carry_back(poses, odometry, covariance, converged)
    return Localized(
        poses, covariance, converged, numbers[:, 0], numbers[:, 1], counts, numbers[:, 2], used, name,
        time.process_time() - began, sure,
    )  # fmt: skip


def confirmed(
    poses: Float64Array, odometry: Float64Array, converged: NDArray[np.bool_], sure: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return at which scans (n,) the place is sure in hindsight; ``sure`` (n,) are those at which the filter was sure.

    While the estimates ``poses`` (n, 3) move like the ``odometry`` (n, 3), and the filter has ``converged`` (n,), they
    belong to one place, so a later confirmation also applies to the scans before. If the estimate jumps, the robot may
    have been elsewhere for some scans before.
    """
    out = np.zeros(len(poses), dtype=np.bool_)
    expected = compose(poses[:-1], compose(inverse(odometry[:-1]), odometry[1:]))
    ends = np.flatnonzero(is_jump(expected, poses[1:]) | (converged[1:] != converged[:-1])) + 1
    for first, stop in pairwise([0, *ends.tolist(), len(poses)]):
        if not converged[first]:
            continue
        last = stop if stop == len(poses) else max(stop - BEFORE_JUMP, first)
        confirmed_at = np.flatnonzero(sure[first:last])
        if len(confirmed_at):
            out[first : first + int(confirmed_at[-1]) + 1] = True
    return out


def carry_back(
    poses: Float64Array, odometry: Float64Array, covariance: Float64Array, converged: NDArray[np.bool_]
) -> None:
    """Replace the poses (n, 3) before convergence by the converged pose, propagated back along the odometry.

    The earlier estimates are averages of particles all over the map, where the robot never was. The starting pose is
    the most certain of the first :data:`SETTLED` scans after convergence. If the filter never converged, nothing
    changes.
    """
    converged_scans = np.flatnonzero(converged)
    if not len(converged_scans) or converged_scans[0] == 0:
        return
    first = int(converged_scans[0])
    stop = first + int(np.argmin(np.append(converged[first : first + SETTLED], False)))
    anchor = first + int(np.argmin(covariance[first:stop, 0, 0] + covariance[first:stop, 1, 1]))
    poses[:first] = compose(poses[anchor], compose(inverse(odometry[anchor]), odometry[:first]))


def covariance_lines(log: ScanLog, result: Localized) -> list[str]:
    """Return a table as comma-separated text, one line for each scan with the uncertainty of its pose."""
    lines = ["scan,stamp_ns,converged,sure,share,fit,particles,xx,xy,xyaw,yy,yyaw,yawyaw\n"]
    for i in range(log.n_scans):
        c = result.covariance[i]
        upper = ",".join(f"{value:.9g}" for value in (c[0, 0], c[0, 1], c[0, 2], c[1, 1], c[1, 2], c[2, 2]))
        lines.append(
            f"{i},{int(log.stamps_ns[i])},{int(result.is_converged[i])},{int(result.is_sure[i])},{result.share[i]:.6f},"
            f"{result.fit[i]:.6f},{result.n_particles[i]},{upper}\n"
        )
    return lines
