"""Incremental simultaneous localization and mapping: front end, loops and graph."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, compose_one, inverse
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph
from mapper.sensors.scan import ScanLog
from mapper.slam.config import SlamConfig
from mapper.slam.front_end import FrontEnd
from mapper.slam.loop_closure import LoopCloser
from mapper.slam.loop_test import Loop
from mapper.slam.odometry import next_scan
from mapper.slam.optimise import MAX_ITERATIONS, optimise, optimise_newest
from mapper.slam.place_recognition import PlaceRecognizer, reason_against_group
from mapper.slam.scan_store import ScanStore

MOVED, TURNED = 0.15, 0.03  #: metres, radians: a loop with a larger error triggers immediate optimisation
MOST_WAITING = 20  #: consistent loops after which the graph is optimised anyway
LARGE = 4_000  #: nodes: larger graphs are optimised less often, so that the total time grows with n log n:
RARELY = 50  #: after each 1 / RARELY of the nodes
FAR_OFF, FAR_TURNED = 0.5, 0.1  #: metres, radians: for a loop with a larger error the newest poses are optimised
NEWEST = 500  #: nodes before the last optimisation that then also move, so that the error is spread over them
SETTLING = 6  #: iterations after a loop


class Slam:
    """Incremental SLAM.

    ``log`` defines the sensors: beams, ranges and mounts; its scans are not used. ``add_scan`` adds a scan, and
    ``poses`` are all corrected poses so far. ``check`` is called while the graph is optimised and may raise to cancel
    the work. Not thread-safe.
    """

    def __init__(self, log: ScanLog, config: SlamConfig | None = None, check: Callable[[], None] | None = None) -> None:
        self.config = config or SlamConfig()
        self.store = ScanStore(sensors_of(log), self.config.range_max, int(self.config.n_beams))
        self.front_end = FrontEnd(self.store, self.config)
        self.tried: list[Loop] = []
        self.recognized: list[Loop] = []  #: loops at recognised places, a subset of the accepted ones
        self._closer = LoopCloser(self.store, self.front_end, self.config)
        self._recognizer = PlaceRecognizer(self.store, self.front_end, self.config)
        self._loops: list[Loop] = []
        self._poses = np.zeros((512, 3))
        self._way = np.zeros(512)
        self._relative = np.zeros((512, 3))
        self._information = np.zeros((512, 3, 3))
        self._waiting = 0
        self._check = check
        self._settled = 0  # number of nodes when the graph was last optimised
        self.n_unaligned = 0  #: number of scans that could not be aligned with those before them

    def __len__(self) -> int:
        return len(self.front_end)

    @property
    def poses(self) -> Float64Array:
        """The poses so far (n, 3), ``T_map_base``, starting at the first scan's start pose."""
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

        ``motion`` (3,) is the odometry's since the previous scan, None without odometry, and ``seconds`` the time since
        then, None if unknown; ``start`` (3,) is the pose of the first scan. ``velocity`` (3,) is the base's during the
        scan, in its own frame, metres and radians per second; None: as before. It is used if the log states the time
        between beams. With ``may_drop``, a scan taken close to its sensor's previous one gets no node, but
        ``front_end.last`` is still its pose. ``mount`` (3,) is ``T_base_laser`` of a sensor that moves on the robot.
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
        """Return which of the scans at ``times`` (n,), seconds, to add after the last scan k, without odometry."""
        velocity = self.front_end.velocity
        return k + 1 if velocity is None else next_scan(k, times, velocity)

    def _settle(self, loop: Loop) -> bool:
        """Optimise the graph if the new loop does not fit it, or if many fitting loops are pending."""
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
        """Accept a group of loops at recognised places if the graph is consistent with it; return whether it was
        accepted.
        """
        if not self.config.place_recognition:
            return False
        group = self._recognizer.try_at(n, self._poses[: n + 1], self._way[: n + 1], self._loops, self.tried)
        if not group:
            return False
        # The weights of the loops at the current poses, because optimising a large graph takes seconds.
        before, n_before = self.optimised(0), len(self._loops)
        loops = self._recognizer.candidates(group)
        self._loops += loops
        after = self.optimised()
        reason = reason_against_group(before, after)
        if reason:
            del self._loops[n_before:]
            self._recognizer.refuse(group, self.tried, reason)
            return False
        self._recognizer.accept(group, self.tried)
        self.recognized += loops
        self._poses[: len(self)] = after.poses
        return True

    def graph(self) -> PoseGraph:
        """Return the graph so far, with nodes in insertion order."""
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
