"""Merging of two logs of one place: their maps are aligned, then their scans are joined and refined together.

Map to map: the walls of the second log's map are searched for everywhere in the first map, in all directions. Joint:
loops between the scans of the two logs, a robust pose graph of both, and the refinement of
:mod:`mapper.slam.refinement` over all scans.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.se2 import compose, wrap_angle
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import bounds_of_log, grid_for, integrate_log
from mapper.mapping.parameters import RECORDED, MappingConfig
from mapper.matching.maps import place_map
from mapper.sensors.joint_log import sensor_numbers, sensors_of
from mapper.sensors.motion import seconds
from mapper.sensors.pose_graph import LOOP, PoseGraph
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.slam.config import SlamConfig
from mapper.slam.loop_closure import SIGHT, TURN_WINDOW, WINDOW
from mapper.slam.loop_test import Loop, Place, try_loop
from mapper.slam.matching_rules import pair_rule
from mapper.slam.merged_log import MERGED
from mapper.slam.odometry import carry
from mapper.slam.optimise import optimise
from mapper.slam.refinement import refine
from mapper.slam.result import LoopCandidates, SlamProgress, SlamResult
from mapper.slam.scan_store import ScanStore
from mapper.slam.whole_log import slam_log, stored_scans

FEWEST = 3  #: minimum number of loops between logs of one place
LEAST_SHARE = 0.3  #: fraction of the loops tried near scans of the first log
SHARES = (0.35, 0.35, 0.1, 0.1, 0.1)  #: fractions of the work: SLAM of each log, maps, loops, refinement


@dataclass(frozen=True, slots=True)
class MergeProgress:
    """Progress of a merge: ``fraction`` 0 to 1, and the ``stage``.

    Stages are "first log", "second log", "maps", "loops" and "refinement".
    """

    fraction: float
    stage: str


class MergeCancelled(WorkCancelledError):  # noqa: N818 - a cancelled job is no failure
    """The callback of :func:`merge_logs` returned False."""


@dataclass(frozen=True, slots=True)
class MergedLogs:
    """Two logs in one map frame, that of the first log's poses.

    ``poses`` are those of all scans of the two logs, (n_scans, 3) each, ``T_map_base``. ``placed`` (3,) is the pose of
    the second log's map in the first one's, ``T_first_second``, from map-to-map matching, with its ``score``, 0 to 1.
    ``graph`` has the nodes of the first log, ``split`` of them, and then those of the second, numbered after the first
    log's scans; ``loops`` (l,) are its edges between the logs, of those ``tried``. ``results`` are those of SLAM of
    each log alone.
    """

    poses: tuple[Float64Array, Float64Array]
    placed: Float64Array
    score: float
    graph: PoseGraph
    split: int
    loops: Int64Array
    tried: LoopCandidates
    results: tuple[SlamResult, SlamResult]
    cpu_seconds: float


def merge_logs(
    first: ScanLog,
    second: ScanLog,
    config: SlamConfig | None = None,
    *,
    trajectories: tuple[str | None, str | None] = (None, None),
    guess: Float64Array | None = None,
    results: tuple[SlamResult | None, SlamResult | None] = (None, None),
    progress: Callable[[MergeProgress], bool | None] | None = None,
) -> MergedLogs:
    """Return the poses of two logs of one place in one frame.

    Each log is corrected by SLAM from the named trajectory, like :func:`mapper.slam.slam_log`, unless its result is
    passed. ``guess`` (3,) is the approximate pose of the second map in the first one's, within 5 m, in any direction;
    without it the second map is searched for everywhere. ``progress`` is called during the work; if it returns False,
    :class:`MergeCancelled` is raised. Raises the errors of :func:`slam_log`, and :class:`ConfigError` if the logs do
    not show one place.
    """
    config = config or SlamConfig()
    began = time.process_time()

    def report(stage: int, fraction: float) -> bool:
        if progress is not None:
            names = ("first log", "second log", "maps", "loops", "refinement")
            done = sum(SHARES[:stage]) + SHARES[stage] * fraction
            if progress(MergeProgress(min(done, 1.0), names[stage])) is False:
                raise MergeCancelled("merge.cancelled", "Merging the logs was cancelled.")
        return True

    logs, solved = (first, second), list[SlamResult]()
    for number, log in enumerate(logs):
        known = results[number]

        def of_one(done: SlamProgress, stage: int = number) -> bool:
            return report(stage, done.fraction)

        solved.append(known or slam_log(log, config, trajectory=trajectories[number], progress=of_one))
    report(2, 0.0)
    grids = [map_along([(log, result.poses)]) for log, result in zip(logs, solved, strict=True)]
    try:
        matches = place_map(grids[0], grids[1], guess)
    except ConfigError as error:
        if error.code != "matching.apart":
            raise
        raise ConfigError(
            "merge.apart", "The two logs do not show the same place: their maps have no walls in common near the guess."
        ) from None
    report(3, 0.0)
    joint = _Joint(logs, (solved[0], solved[1]), config)
    best: list[Loop] = []
    placed, score = matches.candidates[0], 0.0
    for k, (pose, its_score) in enumerate(zip(matches.candidates, matches.scores, strict=True)):
        tried = joint.loops_at(pose)
        if _accepted(tried) > _accepted(best) or not best:
            best, placed, score = tried, pose, float(its_score)
        report(3, (k + 1) / len(matches.scores))
    if _accepted(best) < max(FEWEST, LEAST_SHARE * len(best)):
        raise ConfigError(
            "merge.apart",
            f"The two logs do not show the same place: where their maps fit best, {_accepted(best)} of {len(best)} "
            "scans of the second log fit scans of the first.",
        )

    def of_refinement(fraction: float, _: Float64Array) -> None:
        report(4, fraction)

    graph, poses = joint.solved(placed, best, of_refinement)
    return MergedLogs(
        poses,
        placed,
        score,
        graph,
        joint.split,
        np.flatnonzero((graph.i < joint.split) & (graph.j >= joint.split)),
        LoopCandidates.of(best),
        (solved[0], solved[1]),
        time.process_time() - began,
    )


def map_along(parts: list[tuple[ScanLog, Float64Array]]) -> OccupancyGrid:
    """Map logs along poses (n_scans, 3) in one frame, all scans of the first log before the next log's."""
    config = MappingConfig().with_values(RECORDED)
    logs = [replace(log, trajectories={MERGED: Trajectory(poses, "poses corrected by SLAM")}) for log, poses in parts]
    grid = grid_for(logs[0], config, MERGED)
    for log in logs[1:]:
        grid.grow_to_include(*bounds_of_log(log, config, MERGED))
    for log in logs:
        integrate_log(grid, log, config, MERGED)
    return grid


def _accepted(loops: list[Loop]) -> int:
    return sum(loop.accepted for loop in loops)


class _Joint:
    """The scans of both logs in one store, first log first."""

    def __init__(
        self, logs: tuple[ScanLog, ScanLog], results: tuple[SlamResult, SlamResult], config: SlamConfig
    ) -> None:
        self._logs, self._results, self._config = logs, results, config
        self._graphs = tuple(result.graph for result in results)
        self.split = len(self._graphs[0].nodes)
        sensors = [sensors_of(log) for log in logs]
        first, second = (sensor_numbers(parts).tolist() for parts in sensors)
        numbers = [*first, *(number + max(first) + 1 for number in second)]
        self._store = ScanStore([*sensors[0], *sensors[1]], config.range_max, int(config.n_beams), numbers)
        offsets = (0, len(sensors[0]))
        for log, part, offset in zip(logs, results, offsets, strict=True):
            stored_scans(self._store, log, part, offset)
        self._rule = pair_rule(self._store.least_step)
        self._places: dict[int, Place] = {}

    def loops_at(self, placed: Float64Array) -> list[Loop]:
        """Try loops from scans of the second log, with its frame at ``placed`` (3,)."""
        poses = self._poses_at(placed)
        here, there = poses[: self.split], poses[self.split :]
        size = 2 * int(self._config.submap_scans)
        tried, driven = list[Loop](), np.inf
        for k, pose in enumerate(there):
            if k:
                driven += float(np.hypot(*(pose - there[k - 1])[:2]))
            if driven < self._config.loop_distance:
                continue
            away = np.hypot(*(here[:, :2] - pose[:2]).T)
            nearest = int(np.argmin(away))
            if away[nearest] > SIGHT:
                continue
            driven = 0.0
            chunk = nearest // size
            if chunk not in self._places:
                members = np.arange(chunk * size, min((chunk + 1) * size, self.split))
                self._places[chunk] = Place.of(self._store, members, here, self._config.range_max)
            tried.append(
                try_loop(
                    self._store, self._config, self._rule, self._places[chunk], nearest, self.split + k, pose,
                    WINDOW, TURN_WINDOW,
                )
            )  # fmt: skip
        return tried

    def _poses_at(self, placed: Float64Array) -> Float64Array:
        first, second = self._graphs
        return np.concatenate([first.poses, compose(placed, second.poses)])

    def solved(
        self, placed: Float64Array, tried: list[Loop], progress: Callable[[float, Float64Array], None]
    ) -> tuple[PoseGraph, tuple[Float64Array, Float64Array]]:
        """Return the graph of both logs with these loops, solved and refined, and the poses of all scans of each."""
        first, second = self._graphs
        loops = [loop for loop in tried if loop.accepted]
        n = len(loops)
        graph = PoseGraph(
            np.r_[first.nodes, self._logs[0].n_scans + second.nodes],
            self._poses_at(placed),
            np.r_[first.i, second.i + self.split, np.array([loop.i for loop in loops], dtype=np.int64)],
            np.r_[first.j, second.j + self.split, np.array([loop.j for loop in loops], dtype=np.int64)],
            np.concatenate([first.relative, second.relative, [loop.relative for loop in loops]]),
            np.concatenate([first.information, second.information, [loop.information for loop in loops]]),
            np.r_[first.kind, second.kind, np.full(n, LOOP)],
            np.r_[first.locked, second.locked, np.zeros(n, dtype=np.bool_)],
            np.zeros(len(first.i) + len(second.i) + n),
            np.ones(len(first.i) + len(second.i) + n),
        )
        config = self._config
        graph = optimise(graph, robust=config.robust, robust_scale=config.robust_scale)
        poses = refine(graph, self._store, config, progress)
        poses[:, 2] = wrap_angle(poses[:, 2])
        parts = []
        for log, result, own in zip(self._logs, self._results, (poses[: self.split], poses[self.split :]), strict=True):
            # Scans between the nodes move with them, as in SLAM of the log alone.
            parts.append(carry(result.graph.nodes, own, result.poses, seconds(log)))
        # The frame is that of the first log's first pose, which does not move.
        return replace(graph, poses=poses), (parts[0], parts[1])


def merged_graph(logs: tuple[ScanLog, ScanLog], merged: MergedLogs) -> tuple[PoseGraph, LoopCandidates]:
    """Return the graph of both logs, numbered as in :func:`mapper.slam.merged_log`, and all loops tried.

    These are the loops tried within each log, and those from scans of the second log to the first.
    """
    graph, split = merged.graph, merged.split
    n = len(graph.nodes)
    own = [
        replace(result.candidates, i=result.candidates.i + shift, j=result.candidates.j + shift)
        for result, shift in zip(merged.results, (0, split), strict=True)
    ]
    parts = [*own, merged.tried]
    i, j, score, inliers, accepted = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("i", "j", "score", "inliers", "accepted")
    )
    nodes, rows = graph.nodes, np.arange(n)
    if int(logs[1].stamps_ns.max()) < int(logs[0].stamps_ns.min()):  # the second log comes first in the merged log
        rows = (rows + n - split) % n
        is_second = nodes >= logs[0].n_scans
        nodes = np.where(is_second, nodes - logs[0].n_scans, nodes + logs[1].n_scans)
    order = np.argsort(rows)
    return (
        replace(graph, nodes=nodes[order], poses=graph.poses[order], i=rows[graph.i], j=rows[graph.j]),
        LoopCandidates(
            rows[i], rows[j], score, inliers, accepted, tuple(reason for part in parts for reason in part.reason)
        ),
    )
