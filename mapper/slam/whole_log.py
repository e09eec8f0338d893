"""SLAM of a log as a whole: all its scans in turn, with and without recognized places, then the refinement."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import wrap_angle
from mapper.sensors.joint_log import sensor_of_scan
from mapper.sensors.motion import seconds
from mapper.sensors.pose_graph import ODOMETRY, PoseGraph
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig
from mapper.slam.map_agreement import map_score
from mapper.slam.odometry import carry, matched_scans, motions, odometry_name, sweep_velocities, velocities_along
from mapper.slam.place_recognition import refused
from mapper.slam.refinement import refine
from mapper.slam.result import LoopCandidates, SlamCancelled, SlamProgress, SlamResult
from mapper.slam.scan_store import ScanStore
from mapper.slam.slam import Slam

UNSEEN = 0.03  #: of the information of a step's position
LEAST_UNSEEN = 5.0  #: m of the way; shorter ones are not reported
EVERY = 25  #: scans between two reports
BEFORE_REFINEMENT = 0.8  #: of the work
WORSE = "the map agrees better with itself without the loops at recognized places"

Report = Callable[[float, str, int, Callable[[], Float64Array]], None]


class _Pass:
    """The matched scans of a log, added one after another to :class:`Slam`.

    ``odometry`` names the trajectory from which the motions between scans are taken, None for none.
    """

    def __init__(self, log: ScanLog, odometry: str | None, config: SlamConfig, check: Callable[[], None]) -> None:
        self.slam = Slam(log, config, check)
        self.matched: list[int] = []  # scans of the log
        self.nodes: list[int] = []  # which of those each node is
        self._track: list[Float64Array] = []  # poses of the matched scans by the front end
        self._log, self._times = log, seconds(log)
        self._odometry = None if odometry is None else log.trajectory(odometry).poses
        self._sensor = sensor_of_scan(log)
        self._wanted = matched_scans(self._sensor, self._odometry, config)
        self._sweeps = None if odometry is None or not self.slam.store.can_deskew else sweep_velocities(log, odometry)
        self._start = log.trajectory(odometry).poses[0]

    @property
    def n_wanted(self) -> int:
        """Number of scans that can be matched."""
        return len(self._wanted)

    def add_all(self, report: Report | None) -> None:
        """Add all scans; ``report`` gets the share of them that is done, the stage, and the poses so far."""
        log, times, wanted, slam = self._log, self._times, self._wanted, self.slam
        moved = None if self._odometry is None else motions(self._odometry[wanted])
        k = 0
        while k < len(wanted):
            scan = int(wanted[k])
            passed = float(times[scan] - times[self.matched[-1]]) if self.matched else 0.0
            # Scans of two sensors may be taken at once; of one sensor equal times say nothing.
            sensor = int(self._sensor[scan])
            is_other = bool(self.matched) and sensor != self._sensor[self.matched[-1]]
            is_known = passed > 0.0 or (passed == 0.0 and is_other)
            self.matched.append(scan)
            moved_poses = slam.add_scan(
                log.ranges[scan], None if moved is None or k == 0 else moved[k - 1], self._start, sensor=sensor,
                seconds=passed if is_known else None, velocity=None if self._sweeps is None else self._sweeps[scan],
                may_drop=moved is None and k + 1 < len(wanted), mount=log.mount_of(scan),
            )  # fmt: skip
            self._track.append(slam.front_end.last)
            if len(slam) > len(self.nodes):
                self.nodes.append(len(self.matched) - 1)
            if report is not None and (moved_poses or len(self.matched) % EVERY == 1):
                stage = "loop closure" if moved_poses else "front end"
                n = len(slam)
                report((k + 1) / len(wanted), stage, self.scans_with_poses(n), partial(self._poses_so_far, n))
            k = k + 1 if moved is not None else slam.following(k, times[wanted])
        if moved is None:
            velocities = velocities_along(times[self.matched], self._poses_of_matched(slam.poses))
            slam.store.deskew(velocities[self.nodes])

    def scans_with_poses(self, n_nodes: int) -> int:
        """Return how many scans of the log have poses by the first nodes."""
        return self.matched[self.nodes[n_nodes - 1]] + 1

    def poses(self, node_poses: Float64Array) -> Float64Array:
        """Return the poses of the log's scans, up to the last node's, from those of the first nodes (n, 3)."""
        poses = self._poses_of_matched(node_poses)
        known = np.array(self.matched[: len(poses)])
        return poses if len(known) == known[-1] + 1 else carry(known, poses, self._odometry, self._times)

    def _poses_so_far(self, n_nodes: int) -> Float64Array:
        return self.poses(self.slam.poses[:n_nodes])

    def _poses_of_matched(self, node_poses: Float64Array) -> Float64Array:
        n = self.nodes[len(node_poses) - 1] + 1
        if len(node_poses) == n:
            return node_poses.copy()
        known = np.array(self.nodes[: len(node_poses)])
        return carry(known, node_poses, np.array(self._track[:n]), self._times[self.matched[:n]])


class _Fractions:
    """The fraction 0 … 1 of the work that is done; it never falls, though a second pass is only known later."""

    def __init__(self, end: float) -> None:
        self._end = end  # the fraction after all passes
        self._passes = 1
        self._from, self._begin = 0.0, 0.0  # passes that were done, and the fraction, when the number was last known

    def after(self, done: float, passes: int) -> float:
        """Return the fraction when ``done`` of as many ``passes`` are done."""
        if passes != self._passes:
            self._from, self._begin, self._passes = done, self.after(done, self._passes), passes
        return self._begin + (self._end - self._begin) * (done - self._from) / (self._passes - self._from)


def slam_log(
    log: ScanLog,
    config: SlamConfig | None = None,
    *,
    trajectory: str | None = None,
    progress: Callable[[SlamProgress], bool | None] | None = None,
) -> SlamResult:
    """Return corrected poses of a log's scans.

    ``trajectory`` names the odometry to begin with; without it, it is the first trajectory in a frame ``odom``, else
    the log's first; a log without poses is matched by its scans alone. Where loops were accepted at recognized places,
    all scans are added a second time without place recognition, and the graph with the greater
    :func:`mapper.slam.map_agreement.map_score` is kept. ``progress`` is called as the work goes on; if it returns
    False, :class:`SlamCancelled` is raised. Raises :class:`ConfigError` for a log of sonars, without scans or without
    returns, and for a trajectory that the log lacks.
    """
    config = config or SlamConfig()
    began = time.process_time()
    if log.n_scans == 0:
        raise ConfigError("slam.no_scans", "The log has no scans.")
    name = odometry_name(log) if trajectory is None else trajectory
    if name is not None:
        log.trajectory(name)
    if not ((log.ranges >= max(log.range_min, 0.01)) & (log.ranges <= log.range_max)).any():
        raise ConfigError(
            "slam.no_returns", "There is nothing to align: no scan has a reading within the range limits."
        )
    reported: list[SlamProgress] = []  # the last one

    def check() -> None:
        if progress is not None and reported and progress(reported[0]) is False:
            raise SlamCancelled("slam.cancelled", "SLAM was cancelled.")

    chosen = _Pass(log, name, config, check)

    def report(fraction: float, stage: str, done: int, find_poses: Callable[[], Float64Array]) -> None:
        reported[:] = [SlamProgress(fraction, stage, done, chosen.slam.n_loops, find_poses)]
        check()

    fractions = _Fractions(BEFORE_REFINEMENT if config.refinement else 1.0)

    def of_first(share: float, stage: str, done: int, find_poses: Callable[[], Float64Array]) -> None:
        report(fractions.after(share, 2 if chosen.slam.recognized else 1), stage, done, find_poses)

    chosen.add_all(None if progress is None else of_first)
    graph = chosen.slam.optimised()
    notes = []
    if chosen.slam.recognized:
        first_poses = chosen.poses(graph.poses)

        def of_second(share: float, stage: str, done: int, find_poses: Callable[[], Float64Array]) -> None:
            del stage, done, find_poses
            report(fractions.after(1.0 + share, 2), "comparison", len(first_poses), first_poses.copy)

        other = _Pass(log, name, replace(config, place_recognition=False), check)
        other.add_all(None if progress is None else of_second)
        other_graph = other.slam.optimised()
        if _score(other, other_graph, config) > _score(chosen, graph, config):
            notes.append(_note_on_recognized(chosen.slam))
            if other.nodes == chosen.nodes:
                other.slam.tried += [refused(loop, WORSE) for loop in chosen.slam.recognized]
            chosen, graph = other, other_graph
    done = chosen.scans_with_poses(len(chosen.slam))
    if config.refinement and progress is not None:
        report(BEFORE_REFINEMENT, "refinement", done, partial(chosen.poses, graph.poses))

    def refined(fraction: float, poses: Float64Array) -> None:
        if progress is not None:
            whole = BEFORE_REFINEMENT + (1.0 - BEFORE_REFINEMENT) * fraction if config.refinement else 1.0
            report(whole, "refinement", log.n_scans, lambda: chosen.poses(poses))

    poses = refine(graph, chosen.slam.store, config, refined, check)
    poses[:, 2] = wrap_angle(poses[:, 2])
    graph = replace(graph, nodes=np.array(chosen.matched)[chosen.nodes], poses=poses)
    return SlamResult(
        chosen.poses(poses),
        graph,
        LoopCandidates.of(chosen.slam.tried),
        name,
        time.process_time() - began,
        (*notes, *_notes(log, name, chosen, graph)),
    )


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


def _score(one: _Pass, graph: PoseGraph, config: SlamConfig) -> float:
    return map_score(one.slam.store, graph.poses, config.loop_contradicted)


def _note_on_recognized(slam: Slam) -> str:
    return (
        f"{len(slam.recognized)} loops at recognized places are left out: with them more points lie where other scans "
        "saw free space."
    )


def _notes(log: ScanLog, odometry: str | None, one: _Pass, graph: PoseGraph) -> list[str]:
    """Return a sentence on each thing that could not be used or determined."""
    notes = []
    if one.n_wanted < log.n_scans and odometry is None:
        notes.append(f"Of {log.n_scans} scans {len(one.matched)} were matched; the poses of the others lie between.")
    if blind := _unseen_way(graph):
        notes.append(
            f"Along {blind:.0f} m of the path the scans do not determine how far the robot moved, as in a corridor; "
            f"there {'the motion before' if odometry is None else 'the odometry'} is used."
        )
    if unaligned := one.slam.n_unaligned:
        scans = "1 scan fits" if unaligned == 1 else f"{unaligned} scans fit"
        notes.append(
            f"{scans} none of the scans before and only follow the {'motion' if odometry is None else 'odometry'}."
        )
    return notes


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
