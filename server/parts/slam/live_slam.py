"""SLAM of a simulated robot while it drives: the poses of its scans, and the graph from which they come."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.se2 import compose, compose_one
from mapper.sensors.pose_graph import LOOP
from mapper.sensors.scan import ScanLog
from mapper.simulation.robot import PoseTuple
from mapper.slam import Slam, SlamConfig
from server.stream.layers import GraphLayer

N_BEAMS = 180  #: matched beams of a scan: 1 to 3 ms each, fast enough at eight times real time too
DISTANCE, TURN = 0.1, 0.1  #: metres, radians: a scan is matched once the odometry moved this far
MOST_NODES = 3000  #: about 25 MB; later scans follow the odometry


class LiveSlam:
    """The poses of a sensor's scans. A scan is matched if it was taken far enough from the last matched one.

    ``log`` describes the sensor, whose first scan is taken at ``start``. This is a
    :class:`mapper.simulation.pose_correction.Corrector`. Raises :class:`mapper.core.errors.ConfigError` for a sonar.
    """

    def __init__(self, log: ScanLog, start: PoseTuple) -> None:
        config = SlamConfig(n_beams=N_BEAMS, node_distance=DISTANCE, node_turn=TURN)
        self._slam = Slam(log, config)
        self._start = np.array(start)
        self._node = np.empty(512, dtype=np.int64)  # for each scan, the newest node
        self._since = np.empty((512, 3))  # and the motion since that node
        self._n = 0
        self._distance, self._angle = 0.0, 0.0  # since the newest node
        self._drawn = (0, 0)

    @property
    def poses(self) -> Float64Array:
        """All poses so far (n, 3), ``T_map_base``."""
        return compose(self._slam.poses[self._node[: self._n]], self._since[: self._n])

    @property
    def newest(self) -> PoseTuple:
        """The last pose."""
        node = self._slam.poses[self._node[self._n - 1]]
        return compose_one(node.tolist(), self._since[self._n - 1].tolist())

    def add(self, ranges: NDArray[np.float32], motion: PoseTuple) -> bool:
        """Add a scan (n_beams,), ``motion`` (3,) after the previous one; return whether earlier poses have moved."""
        if self._n == len(self._node):
            self._node = np.concatenate([self._node, np.empty_like(self._node)])
            self._since = np.concatenate([self._since, np.empty_like(self._since)])
        n, self._n = self._n, self._n + 1
        since = compose_one(self._since[n - 1].tolist(), motion) if n else (0.0, 0.0, 0.0)
        self._distance += math.hypot(motion[0], motion[1])
        self._angle += abs(motion[2])
        is_far = self._distance >= DISTANCE or self._angle >= TURN
        if n and (not is_far or len(self._slam) == MOST_NODES):
            self._node[n], self._since[n] = len(self._slam) - 1, since
            return False
        moved = self._slam.add_scan(ranges, np.array(since) if n else None, self._start)
        self._node[n], self._since[n] = len(self._slam) - 1, 0.0
        self._distance = self._angle = 0.0
        return moved

    def draw(self, layer: GraphLayer) -> None:
        """Write the nodes and edges if they have changed. An edge's value is 0 for a loop, NaN for odometry."""
        now = len(self._slam), self._slam.n_loops
        if now == self._drawn:
            return
        self._drawn = now
        graph = self._slam.graph()
        nodes = np.stack([*graph.poses.T, graph.nodes.astype(np.float64)])
        layer.set(nodes, np.stack([graph.i, graph.j], axis=1), np.where(graph.kind == LOOP, 0.0, np.nan))


def live_slam(log: ScanLog, start: PoseTuple) -> LiveSlam | None:
    """Return SLAM for a log's sensor; None for a sonar, whose beams are too wide for matching."""
    return None if log.beam_width > 0.0 else LiveSlam(log, start)
