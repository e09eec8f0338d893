"""SLAM of a whole log: all scans in order, repeated with other rules if the map contradicts itself, then refinement."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import wrap_angle
from mapper.sensors.joint_log import part_of_scan, sensor_of_scan
from mapper.sensors.motion import seconds
from mapper.sensors.pose_graph import ODOMETRY, PoseGraph
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig
from mapper.slam.map_agreement import APART, MapAgreement, map_agreement
from mapper.slam.odometry import carry, matched_scans, motions, odometry_name, sweep_velocities, velocities_along
from mapper.slam.place_recognition import refused
from mapper.slam.refinement import refine
from mapper.slam.result import LoopCandidates, SlamCancelled, SlamProgress, SlamResult
from mapper.slam.scan_store import ScanStore
from mapper.slam.slam import Slam

UNSEEN = 0.03  #: fraction of a step's position information, below which it counts as unobserved
LEAST_UNSEEN = 5.0  #: m of path; shorter ones are not reported
EVERY = 25  #: scans between two reports
BEFORE_REFINEMENT, COMPARISON = 0.8, 0.1  #: fractions: work before refinement, and passes with other rules therein
#: parameters, tried in order, that gave the best maps of logs for which wrong loops had been accepted
STRICTER: Mapping[str, float] = MappingProxyType(
    {"loop_window": 2.0, "loop_inliers": 0.75, "loop_score": 0.7, "loop_contradicted": 0.05}
)
SMALLER_IS_STRICTER = ("loop_window", "loop_contradicted")
LARGE = 10_000  #: nodes, above which stricter rules are not tried because each pass takes minutes
WORSE = "the map agrees better with itself without the loops at recognized places"

Report = Callable[[float, str, int, Callable[[], Float64Array]], None]


class _Pass:
    """The matched scans of a log, added one after another to :class:`Slam`.

    ``odometry`` is the trajectory that provides the motions between scans, None for none.
    """

    def __init__(self, log: ScanLog, odometry: str | None, config: SlamConfig, check: Callable[[], None]) -> None:
        self.slam = Slam(log, config, check)
        self.matched: list[int] = []  # indices in the log
        self.nodes: list[int] = []  # index in ``matched`` of each node
        self._track: list[Float64Array] = []  # front end poses of the matched scans
        self._log, self._times = log, seconds(log)
        self._odometry = None if odometry is None else log.trajectory(odometry).poses
        self._part, self._sensor = part_of_scan(log), sensor_of_scan(log)
        self._wanted = matched_scans(self._sensor, self._odometry, config)
        self._sweeps = None if odometry is None or not self.slam.store.can_deskew else sweep_velocities(log, odometry)
        self._start = log.trajectory(odometry).poses[0]

    @property
    def n_wanted(self) -> int:
        """Number of scans that can be matched."""
        return len(self._wanted)

    def add_all(self, report: Report | None) -> None:
        """Add all scans; ``report`` receives the fraction done, the stage, and the poses so far."""
        log, times, wanted, slam = self._log, self._times, self._wanted, self.slam
        moved = None if self._odometry is None else motions(self._odometry[wanted])
        k = 0
        while k < len(wanted):
            scan = int(wanted[k])
            passed = float(times[scan] - times[self.matched[-1]]) if self.matched else 0.0
            # Scans of two sensors may be simultaneous; equal times of one sensor are not usable.
            is_other = bool(self.matched) and self._sensor[scan] != self._sensor[self.matched[-1]]
            is_known = passed > 0.0 or (passed == 0.0 and is_other)
            self.matched.append(scan)
            moved_poses = slam.add_scan(
                log.ranges[scan], None if moved is None or k == 0 else moved[k - 1], self._start,
                sensor=int(self._part[scan]),
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
        """Return the number of scans of the log that have poses from the first nodes."""
        return self.matched[self.nodes[n_nodes - 1]] + 1

    def poses(self, node_poses: Float64Array) -> Float64Array:
        """Return the poses of the log's scans up to the last node, from those of the first nodes (n, 3)."""
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


@dataclass(frozen=True, slots=True, eq=False)
class _Outcome:
    """A pass with its optimised graph, the agreement of its map, and the parameters changed for it."""

    run: _Pass
    graph: PoseGraph
    agreement: MapAgreement
    changed: Mapping[str, Any]

    def poses(self) -> Float64Array:
        """Return the poses of the log's scans from the graph."""
        return self.run.poses(self.graph.poses)


class _Work:
    """Passes over one log, and their joint progress."""

    def __init__(
        self,
        log: ScanLog,
        odometry: str | None,
        config: SlamConfig,
        progress: Callable[[SlamProgress], bool | None] | None,
    ) -> None:
        self._log, self._odometry, self._config, self._progress = log, odometry, config, progress
        self._reported: list[SlamProgress] = []  # the last one

    def check(self) -> None:
        """Check for cancellation. Raises :class:`SlamCancelled`."""
        if self._progress is not None and self._reported and self._progress(self._reported[0]) is False:
            raise SlamCancelled("slam.cancelled", "SLAM was cancelled.")

    def report(
        self, fraction: float, stage: str, done: int, n_loops: int, find_poses: Callable[[], Float64Array]
    ) -> None:
        """Report progress to the caller. Raises :class:`SlamCancelled`."""
        self._reported[:] = [SlamProgress(fraction, stage, done, n_loops, find_poses)]
        self.check()

    def run(
        self, begin: float, end: float, changed: Mapping[str, Any] | None = None, shown: _Outcome | None = None
    ) -> _Outcome:
        """Add all scans with some parameters changed, while the fraction goes from ``begin`` to ``end``.

        The reported poses are those of ``shown``, if passed.
        """
        changed = changed or {}
        self._reported.clear()  # releases the pass that the last report refers to
        run = _Pass(self._log, self._odometry, replace(self._config, **changed), self.check)

        def report(share: float, stage: str, done: int, find_poses: Callable[[], Float64Array]) -> None:
            fraction = begin + (end - begin) * share
            if shown is None:
                self.report(fraction, stage, done, run.slam.n_loops, find_poses)
            else:
                nodes = len(shown.run.slam)
                n_loops = shown.run.slam.n_loops
                self.report(fraction, "comparison", shown.run.scans_with_poses(nodes), n_loops, shown.poses)

        run.add_all(None if self._progress is None else report)
        graph = run.slam.optimised()
        return _Outcome(run, graph, map_agreement(run.slam.store, graph.poses), changed)

    def best(self, end: float) -> tuple[_Outcome, list[str]]:
        """Return the outcome with the best agreement, of a first pass and those with other rules, and notes on it.

        Another pass without place recognition is made if it closed loops, and passes with stricter rules while the map
        is not consistent. Two passes are in memory at once: the best so far and the current one. The fraction ends at
        ``end``.
        """
        begin = end - COMPARISON
        best, notes = self.run(0.0, begin), list[str]()
        stricter = STRICTER if best.run.slam.n_loops else {}  # without loops their rules have no effect
        part = (end - begin) / (1 + len(STRICTER))
        recognized = best.run.slam.recognized
        if recognized:
            other = self.run(begin, begin + part, {"place_recognition": False}, best)
            if self._score(other) > self._score(best):
                if other.run.nodes == best.run.nodes:
                    other.run.slam.tried += [refused(loop, WORSE) for loop in recognized]
                best = other
                notes.append(
                    f"{len(recognized)} loops at recognized places are left out: with them more points lie where other "
                    "scans saw free space."
                )
        changed = best.changed
        for number, (name, value) in enumerate(stricter.items(), 1):
            if best.agreement.is_consistent or len(best.run.slam) > LARGE:
                break
            now = getattr(self._config, name)
            if now < value if name in SMALLER_IS_STRICTER else now > value:
                continue
            at = begin + part * number
            other = best  # releases the previous pass
            other = self.run(at, at + part, {**changed, name: value}, best)
            if self._score(other) > self._score(best):
                best = other
        rules = [f"{name} {value:g}" for name, value in best.changed.items() if name in STRICTER]
        if rules:
            notes.append(
                f"A stricter rule for loops was used ({', '.join(rules)}): without it more points lie where other "
                "scans saw free space."
            )
        return best, notes

    def _score(self, outcome: _Outcome) -> float:
        return outcome.agreement.score(self._config.loop_contradicted)


def slam_log(
    log: ScanLog,
    config: SlamConfig | None = None,
    *,
    trajectory: str | None = None,
    progress: Callable[[SlamProgress], bool | None] | None = None,
) -> SlamResult:
    """Return corrected poses of a log's scans.

    ``trajectory`` is the initial odometry; by default the first trajectory in a frame ``odom``, else the log's first. A
    log without poses is matched by its scans alone. If loops were accepted at recognised places, all scans are added
    again without place recognition; if the map is not consistent (:class:`mapper.slam.map_agreement.MapAgreement`),
    with stricter rules for loops. The graph whose map has the highest score is kept. ``progress`` is called during the
    work; if it returns False, :class:`SlamCancelled` is raised. Raises :class:`ConfigError` for a log of sonars,
    without scans or without returns, and for a trajectory that the log lacks.
    """
    config = config or SlamConfig()
    began = time.process_time()
    if log.n_scans == 0:
        raise ConfigError("slam.no_scans", "The log has no scans.")
    name = odometry_name(log) if trajectory is None else trajectory
    if name is not None:
        log.trajectory(name)
    if not ((log.ranges >= max(log.range_min, 0.01)) & (log.ranges <= log.range_max) & np.isfinite(log.ranges)).any():
        raise ConfigError(
            "slam.no_returns", "There is nothing to align: no scan has a reading within the range limits."
        )
    work = _Work(log, name, config, progress)
    share = BEFORE_REFINEMENT if config.refinement else 1.0
    chosen, notes = work.best(share)
    run, n_loops = chosen.run, chosen.run.slam.n_loops
    if config.refinement and progress is not None:
        work.report(share, "refinement", run.scans_with_poses(len(run.slam)), n_loops, chosen.poses)

    def refined(fraction: float, poses: Float64Array) -> None:
        if progress is not None:
            whole = share + (1.0 - share) * fraction
            work.report(whole, "refinement", log.n_scans, n_loops, lambda: run.poses(poses))

    poses = refine(chosen.graph, run.slam.store, config, refined, work.check)
    poses[:, 2] = wrap_angle(poses[:, 2])
    if not chosen.agreement.is_consistent:  # the refinement may have made it consistent
        notes += _contradiction(map_agreement(run.slam.store, poses), n_loops)
    graph = replace(chosen.graph, nodes=np.array(run.matched)[run.nodes], poses=poses)
    return SlamResult(
        run.poses(poses),
        graph,
        LoopCandidates.of(run.slam.tried),
        name,
        time.process_time() - began,
        (*notes, *_notes(log, name, run, graph)),
    )


def stored_scans(store: ScanStore, log: ScanLog, result: SlamResult, first_sensor: int = 0) -> None:
    """Append the matched scans of a log to a store, deskewed along the result's poses.

    ``first_sensor`` is the index of the log's first sensor in the store.
    """
    nodes, sensor = result.graph.nodes, part_of_scan(log)
    velocities = velocities_along(seconds(log)[nodes], result.graph.poses)
    if result.odometry is not None and store.can_deskew:
        velocities = sweep_velocities(log, result.odometry)[nodes]
    for scan, velocity in zip(nodes.tolist(), velocities, strict=True):
        store.append(log.ranges[scan], first_sensor + int(sensor[scan]), velocity, log.mount_of(scan))


def _contradiction(agreement: MapAgreement, n_loops: int) -> list[str]:
    """Return a sentence on a map that contradicts itself, none if it is consistent."""
    if agreement.is_consistent:
        return []
    far, near = 100.0 * agreement.contradicted, 100.0 * agreement.contradicted_near
    suspect = "loops" if n_loops else "poses"
    sentence = (
        f"Of the points in sight of scans from more than {APART:.0f} m of the way before or after {far:.1f} % "
        f"lie in free space of these, with nearer ones {near:.1f} %: {suspect} may be wrong, or the place has changed."
    )
    return [sentence]


def _notes(log: ScanLog, odometry: str | None, run: _Pass, graph: PoseGraph) -> list[str]:
    """Return a sentence on each thing that could not be used or determined."""
    notes = []
    if run.n_wanted < log.n_scans and odometry is None:
        notes.append(f"Of {log.n_scans} scans {len(run.matched)} were matched; the poses of the others lie between.")
    if blind := _unseen_way(graph):
        notes.append(
            f"Along {blind:.0f} m of the path the scans do not determine how far the robot moved, as in a corridor; "
            f"there {'the motion before' if odometry is None else 'the odometry'} is used."
        )
    if unaligned := run.slam.n_unaligned:
        scans = "1 scan fits" if unaligned == 1 else f"{unaligned} scans fit"
        notes.append(
            f"{scans} none of the scans before and only follow the {'motion' if odometry is None else 'odometry'}."
        )
    return notes


def _unseen_way(graph: PoseGraph) -> float:
    """Return the length, metres, of the steps along which the scans have almost no information compared with across."""
    steps = graph.kind == ODOMETRY
    if not steps.any():
        return 0.0
    motion, information = graph.relative[steps], graph.information[steps]
    length = np.hypot(motion[:, 0], motion[:, 1])
    ahead = motion[:, :2] / np.maximum(length, 1e-9)[:, np.newaxis]
    along = np.einsum("ka,kab,kb->k", ahead, information[:, :2, :2], ahead)
    unseen = along < UNSEEN * np.trace(information[:, :2, :2], axis1=1, axis2=2)
    return float(length[unseen].sum()) if length[unseen].sum() > LEAST_UNSEEN else 0.0
