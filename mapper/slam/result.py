"""Progress and result of SLAM."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import WorkCancelledError
from mapper.sensors.pose_graph import PoseGraph
from mapper.slam.loop_test import Loop


class SlamCancelled(WorkCancelledError):  # noqa: N818 - a cancelled job is no failure
    """The callback of :func:`mapper.slam.slam_log` returned False."""


@dataclass(frozen=True, slots=True)
class SlamProgress:
    """Progress of SLAM: ``fraction`` of the work, 0 to 1.

    ``stage`` is "front end"; "loop closure", just after a loop moved the poses; "comparison", while all scans are added
    again without recognised places and ``poses`` are the previous ones; or "refinement". ``scans_done`` is the number k
    of scans so far, and ``find_poses`` returns their poses; see :attr:`poses`.
    """

    fraction: float
    stage: str
    scans_done: int
    n_loops: int
    find_poses: Callable[[], NDArray[np.float64]]

    @property
    def poses(self) -> NDArray[np.float64]:
        """Return the poses (k, 3), ``T_map_base``, of the scans so far.

        They are computed on access from the current state of SLAM, which takes longer with more scans, because most
        reports only use the counts.
        """
        return self.find_poses()


@dataclass(frozen=True, slots=True)
class LoopCandidates:
    """The loops tried, from node row ``i`` (c,) to node row ``j`` (c,) of the graph, the later one.

    ``score`` (c,) is the correlation's, 0 to 1 (0 if no pose reached the minimum score), ``inliers`` (c,) the fraction
    of visible points on walls of the earlier scans; ``reason`` is why each was refused, "" if ``accepted`` (c,).
    """

    i: NDArray[np.int64]
    j: NDArray[np.int64]
    score: NDArray[np.float64]
    inliers: NDArray[np.float64]
    accepted: NDArray[np.bool_]
    reason: tuple[str, ...]

    @classmethod
    def of(cls, tried: Sequence[Loop]) -> LoopCandidates:
        """Return the table of the loops tried."""
        return cls(
            np.array([loop.i for loop in tried], dtype=np.int64),
            np.array([loop.j for loop in tried], dtype=np.int64),
            np.array([loop.score for loop in tried]),
            np.array([loop.inliers for loop in tried]),
            np.array([loop.accepted for loop in tried], dtype=np.bool_),
            tuple(loop.reason for loop in tried),
        )

    def __len__(self) -> int:
        return len(self.i)


@dataclass(frozen=True, slots=True)
class SlamResult:
    """The poses (n_scans, 3), ``T_map_base``, of all scans in log order, and their origin.

    ``odometry`` is the trajectory that provided the motions between scans, None for none; ``cpu_seconds`` is the
    processor time; ``notes`` are one sentence each on data that could not be used.
    """

    poses: NDArray[np.float64]
    graph: PoseGraph
    candidates: LoopCandidates
    odometry: str | None
    cpu_seconds: float
    notes: tuple[str, ...] = ()
