"""Simultaneous localization and mapping: the front end, loops and the graph, one scan at a time; a log as a whole."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, compose_one, inverse, wrap_angle
from mapper.sensors.joint_log import sensor_of_scan, sensors_of
from mapper.sensors.motion import seconds
from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig
from mapper.slam.front_end import FrontEnd
from mapper.slam.loop_closure import LoopCloser
from mapper.slam.loop_test import Loop
from mapper.slam.odometry import (
    carry,
    matched_scans,
    motions,
    next_scan,
    odometry_name,
    sweep_velocities,
    velocities_along,
)
from mapper.slam.optimise import MAX_ITERATIONS, optimise, optimise_newest
from mapper.slam.place_recognition import PlaceRecognizer, reason_against_group
from mapper.slam.refinement import refine
from mapper.slam.result import LoopCandidates, SlamCancelled, SlamProgress, SlamResult
from mapper.slam.scan_store import ScanStore

Float64Array = NDArray[np.float64]

MOVED, TURNED = 0.15, 0.03  #: metres, radians: a loop off by more than this makes the graph be optimised at once
MOST_WAITING = 20  #: loops that fit, until it is optimised all the same
LARGE = 4_000  #: nodes: a graph with more of them is optimised more rarely, so that the time for it grows with n log n:
RARELY = 50  #: after a share of one in so many of those above
FAR_OFF, FAR_TURNED = 0.5, 0.1  #: metres, radians: a loop off by more has at once the newest poses optimised
NEWEST = 500  #: nodes before the last time that move then: the loop's error is distributed over them and those since
SETTLING = 6  #: iterations after a loop
UNSEEN = 0.03  #: of the information of a step's position
LEAST_UNSEEN = 5.0  #: m of the way; shorter ones are not reported
EVERY = 25  #: scans between two reports


class Slam:
    """SLAM of scans that come one after another.

    ``log`` states the sensors: their beams, ranges and mounts; its scans are not used. ``add_scan`` takes a scan,
    ``poses`` are all so far, corrected. ``check`` is called while the graph is optimised; what it raises ends the work.
    Not for use from two threads at once.
    """

    def __init__(self, log: ScanLog, config: SlamConfig | None = None, check: Callable[[], None] | None = None) -> None:
        self.config = config or SlamConfig()
        self.store = ScanStore(sensors_of(log), self.config.range_max, int(self.config.n_beams))
        self.front_end = FrontEnd(self.store, self.config)
        self.tried: list[Loop] = []
        self._closer = LoopCloser(self.store, self.front_end, self.config)
        self._recognizer = PlaceRecognizer(self.store, self.front_end, self.config)
        self._loops: list[Loop] = []
        self._poses = np.zeros((512, 3))
        self._way = np.zeros(512)
        self._relative = np.zeros((512, 3))
        self._information = np.zeros((512, 3, 3))
        self._waiting = 0
        self._check = check
        self._settled = 0  # nodes, when the graph was last optimised
        self.n_unaligned = 0  #: scans that could not be aligned with those before them

    def __len__(self) -> int:
        return len(self.front_end)

    @property
    def poses(self) -> Float64Array:
        """Return the poses so far (n, 3), ``T_map_base``; the first scan's is the start's."""
        return self._poses[: len(self)]

    @property
    def n_loops(self) -> int:
        """Number of loops."""
        return len(self._loops)

    def add_scan(
        self,
        ranges: NDArray[np.float32],
        motion: Float64Array | None,
        start: Float64Array | None = None,
        *,
        sensor: int = 0,
        seconds: float | None = None,
        velocity: Float64Array | None = None,
        may_drop: bool = False,
        mount: Float64Array | None = None,
    ) -> bool:
        """Add a scan (n_beams,) of a sensor of the log; return whether a loop closed and moved earlier poses.

        ``motion`` (3,) is the odometry's since the scan before, None without odometry, and ``seconds`` the time since
        then, None where it is not known; ``start`` (3,) is the pose of the first scan. ``velocity`` (3,) is the base's
        while the scan is taken, in its own frame, metres and radians a second; None: as before. It matters where the
        log states the time between beams. With ``may_drop`` a scan from almost where the one before of its sensor was
        taken gets no node; ``front_end.last`` is its pose all the same. ``mount`` (3,) is ``T_base_laser`` of a sensor
        that moves on it.
        """
        n = len(self)
        if n == len(self._poses):
            for name in ("_poses", "_way", "_relative", "_information"):
                old = getattr(self, name)
                setattr(self, name, np.concatenate([old, np.zeros_like(old)]))
        step = self.front_end.add(
            ranges, motion, sensor=sensor, seconds=seconds, velocity=velocity, may_drop=may_drop, mount=mount
        )
        self.n_unaligned += not step.is_aligned
        if not step.is_kept:
            return False
        if n == 0:
            if start is not None:
                self._poses[0] = start
            return False
        self._relative[n], self._information[n] = step.relative, step.information
        self._poses[n] = compose_one(self._poses[n - 1].tolist(), step.relative.tolist())
        self._way[n] = self._way[n - 1] + math.hypot(step.relative[0], step.relative[1])
        if not self.config.loop_closure:
            return False
        tried = self._closer.try_at(n, self._poses[: n + 1], self._way[: n + 1], self._loops)
        self.tried += tried
        closed = [loop for loop in tried if loop.accepted]
        self._loops += closed
        moved = bool(closed) and self._settle(closed[0])
        return self._recognize(n) or moved

    def following(self, k: int, times: Float64Array) -> int:
        """Return which of the scans at ``times`` (n,), seconds, to add after scan k, the last one, without odometry."""
        velocity = self.front_end.velocity
        return k + 1 if velocity is None else next_scan(k, times, velocity)

    def _settle(self, loop: Loop) -> bool:
        """Optimise the graph if the new loop does not fit it, or if many that fit wait."""
        off = compose(inverse(loop.relative), compose(inverse(self._poses[loop.i]), self._poses[loop.j]))
        self._waiting += 1
        length, turn = float(np.hypot(off[0], off[1])), abs(float(off[2]))
        if length < MOVED and turn < TURNED and self._waiting < MOST_WAITING:
            return False
        if RARELY * (len(self) - self._settled) < len(self) - LARGE:
            if length < FAR_OFF and turn < FAR_TURNED:
                return False
            first = max(self._settled - NEWEST, 1)
            self._poses[first : len(self)] = optimise_newest(
                self.graph(), first, self.config.robust, self.config.robust_scale, SETTLING
            )
            return True
        self._waiting, self._settled = 0, len(self)
        self._poses[: len(self)] = self.optimised(SETTLING).poses
        return True

    def _recognize(self, n: int) -> bool:
        """Accept a group of loops at recognized places if the graph is consistent with it; return whether one was."""
        if not self.config.place_recognition:
            return False
        group = self._recognizer.try_at(n, self._poses[: n + 1], self._way[: n + 1], self._loops, self.tried)
        if not group:
            return False
        # The weights of the loops at the poses so far: optimising a large graph takes seconds.
        before, n_before = self.optimised(0), len(self._loops)
        self._loops += self._recognizer.candidates(group)
        after = self.optimised()
        reason = reason_against_group(before, after)
        if reason:
            del self._loops[n_before:]
            self._recognizer.refuse(group, self.tried, reason)
            return False
        self._recognizer.accept(group, self.tried)
        self._poses[: len(self)] = after.poses
        return True

    def graph(self) -> PoseGraph:
        """Return the graph so far; its nodes are numbered as they were added."""
        n, loops = len(self), self._loops
        every = np.arange(n)
        e = max(n - 1, 0) + len(loops)
        return PoseGraph(
            every,
            self.poses.copy(),
            np.r_[every[:-1], np.array([loop.i for loop in loops], dtype=np.int64)],
            np.r_[every[1:], np.array([loop.j for loop in loops], dtype=np.int64)],
            np.concatenate([self._relative[1:n], np.reshape([loop.relative for loop in loops], (-1, 3))]),
            np.concatenate([self._information[1:n], np.reshape([loop.information for loop in loops], (-1, 3, 3))]),
            np.r_[np.full(max(n - 1, 0), ODOMETRY), np.full(len(loops), LOOP)],
            np.zeros(e, dtype=np.bool_),
            np.zeros(e),
            np.ones(e),
        )

    def optimised(self, max_iterations: int = MAX_ITERATIONS) -> PoseGraph:
        """Return the graph so far, optimised."""
        return optimise(
            self.graph(),
            robust=self.config.robust,
            robust_scale=self.config.robust_scale,
            max_iterations=max_iterations,
            check=self._check,
        )


def _unseen_way(graph: PoseGraph) -> float:
    """Return the length, metres, of the steps along which the scans say least: all but nothing, beside across."""
    steps = graph.kind == ODOMETRY
    if not steps.any():
        return 0.0
    motion, information = graph.relative[steps], graph.information[steps]
    length = np.hypot(motion[:, 0], motion[:, 1])
    ahead = motion[:, :2] / np.maximum(length, 1e-9)[:, np.newaxis]
    along = np.einsum("ka,kab,kb->k", ahead, information[:, :2, :2], ahead)
    unseen = along < UNSEEN * np.trace(information[:, :2, :2], axis1=1, axis2=2)
    return float(length[unseen].sum()) if length[unseen].sum() > LEAST_UNSEEN else 0.0


def stored_scans(store: ScanStore, log: ScanLog, result: SlamResult, first_sensor: int = 0) -> None:
    """Append the matched scans of a log to a store, deskewed along the result's poses.

    ``first_sensor`` is the number of the log's first sensor in the store.
    """
    nodes, sensor = result.graph.nodes, sensor_of_scan(log)
    velocities = velocities_along(seconds(log)[nodes], result.graph.poses)
    if result.odometry is not None and store.can_deskew:
        velocities = sweep_velocities(log, result.odometry)[nodes]
    for scan, velocity in zip(nodes.tolist(), velocities, strict=True):
        store.append(log.ranges[scan], first_sensor + int(sensor[scan]), velocity, log.mount_of(scan))


def slam_log(
    log: ScanLog,
    config: SlamConfig | None = None,
    *,
    trajectory: str | None = None,
    progress: Callable[[SlamProgress], bool | None] | None = None,
) -> SlamResult:
    """Return corrected poses of a log's scans.

    ``trajectory`` names the odometry to begin with; without it, it is the first trajectory in a frame ``odom``, else
    the log's first; a log without poses is matched by its scans alone. ``progress`` is called as the work goes on; if
    it returns False, :class:`SlamCancelled` is raised. Raises :class:`ConfigError` for a log of sonars, without scans
    or without returns, and for a trajectory that the log lacks.
    """
    config = config or SlamConfig()
    began = time.process_time()
    if log.n_scans == 0:
        raise ConfigError("slam.no_scans", "The log has no scans.")
    name = odometry_name(log) if trajectory is None else trajectory
    odometry = None if name is None else log.trajectory(name).poses
    if not ((log.ranges >= max(log.range_min, 0.01)) & (log.ranges <= log.range_max)).any():
        raise ConfigError(
            "slam.no_returns", "There is nothing to align: no scan has a reading within the range limits."
        )
    sensor, times = sensor_of_scan(log), seconds(log)
    wanted = matched_scans(sensor, odometry, config)
    moved = None if odometry is None else motions(odometry[wanted])
    start = log.trajectory(name).poses[0]
    reported: list[SlamProgress] = []  # the last one

    def check() -> None:
        if progress is not None and reported and progress(reported[0]) is False:
            raise SlamCancelled("slam.cancelled", "SLAM was cancelled.")

    slam = Slam(log, config, check)
    sweeps = None if name is None or not slam.store.can_deskew else sweep_velocities(log, name)
    share = 0.8 if config.refinement else 1.0
    matched: list[int] = []
    node_of: list[int] = []  # which of those each node is
    track: list[Float64Array] = []  # their poses by the front end

    def report(fraction: float, stage: str, done: int, find_poses: Callable[[], Float64Array]) -> None:
        reported[:] = [SlamProgress(fraction, stage, done, slam.n_loops, find_poses)]
        check()

    def of_matched(node_poses: Float64Array) -> Float64Array:
        n = node_of[len(node_poses) - 1] + 1
        if len(node_poses) == n:
            return node_poses.copy()
        return carry(np.array(node_of[: len(node_poses)]), node_poses, np.array(track[:n]), times[matched[:n]])

    def all_poses(node_poses: Float64Array) -> Float64Array:
        poses = of_matched(node_poses)
        known = np.array(matched[: len(poses)])
        return poses if len(known) == known[-1] + 1 else carry(known, poses, odometry, times)

    def poses_of(n_nodes: int) -> Float64Array:
        return all_poses(slam.poses[:n_nodes])

    k = 0
    while k < len(wanted):
        scan = int(wanted[k])
        passed = float(times[scan] - times[matched[-1]]) if matched else 0.0
        # Scans of two sensors may be taken at once; of one sensor equal times say nothing.
        is_known = passed > 0.0 or (passed == 0.0 and bool(matched) and sensor[scan] != sensor[matched[-1]])
        motion = None if moved is None or k == 0 else moved[k - 1]
        velocity = None if sweeps is None else sweeps[scan]
        matched.append(scan)
        moved_poses = slam.add_scan(
            log.ranges[scan], motion, start, sensor=int(sensor[scan]), seconds=passed if is_known else None,
            velocity=velocity, may_drop=odometry is None and k + 1 < len(wanted), mount=log.mount_of(scan),
        )  # fmt: skip
        track.append(slam.front_end.last)
        if len(slam) > len(node_of):
            node_of.append(len(matched) - 1)
        if progress is not None and (moved_poses or len(matched) % EVERY == 1):
            stage = "loop closure" if moved_poses else "front end"
            n = len(slam)
            done = matched[node_of[n - 1]] + 1
            report(share * (k + 1) / len(wanted), stage, done, partial(poses_of, n))
        k = k + 1 if odometry is not None else slam.following(k, times[wanted])
    nodes = np.array(matched)[node_of]
    if odometry is None:
        slam.store.deskew(velocities_along(times[matched], of_matched(slam.poses))[node_of])
    if config.refinement and progress is not None:
        report(share, "refinement", matched[node_of[-1]] + 1, partial(poses_of, len(slam)))
    graph = slam.optimised()

    def refined(fraction: float, poses: Float64Array) -> None:
        if progress is not None:
            report(share + (1.0 - share) * fraction, "refinement", log.n_scans, lambda: all_poses(poses))

    poses = refine(graph, slam.store, config, refined, check)
    poses[:, 2] = wrap_angle(poses[:, 2])
    graph = replace(graph, nodes=nodes, poses=poses)
    notes = []
    if len(wanted) < log.n_scans and odometry is None:
        notes.append(f"Of {log.n_scans} scans {len(matched)} were matched; the poses of the others lie between.")
    if blind := _unseen_way(graph):
        notes.append(
            f"Along {blind:.0f} m of the path the scans do not determine how far the robot moved, as in a corridor; "
            f"there {'the motion before' if name is None else 'the odometry'} is used."
        )
    unaligned = slam.n_unaligned
    if unaligned:
        scans = "1 scan fits" if unaligned == 1 else f"{unaligned} scans fit"
        notes.append(
            f"{scans} none of the scans before and only follow the {'motion' if name is None else 'odometry'}."
        )
    return SlamResult(
        all_poses(poses),
        graph,
        LoopCandidates.of(slam.tried),
        name,
        time.process_time() - began,
        tuple(notes),
    )
