"""Residuals of a pose graph, against a loop over its edges with homogeneous matrices."""

from __future__ import annotations

import math

import numpy as np

from mapper.sensors.pose_graph import LOOP, ODOMETRY, PoseGraph
from mapper.slam.residuals import residual_series


def matrix(pose: np.ndarray) -> np.ndarray:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array([[c, -s, pose[0]], [s, c, pose[1]], [0.0, 0.0, 1.0]])


def test_each_edge_at_the_later_node_and_of_several_loops_the_greatest() -> None:
    rng = np.random.default_rng(4)
    poses = rng.uniform(-3.0, 3.0, (5, 3))
    i, j = np.array([0, 1, 2, 3, 0, 4, 1]), np.array([1, 2, 3, 4, 4, 2, 3])
    kind = np.array([ODOMETRY] * 4 + [LOOP] * 3)
    relative = rng.uniform(-3.0, 3.0, (7, 3))
    graph = PoseGraph(
        nodes=np.array([0, 3, 6, 9, 12]),
        poses=np.zeros((5, 3)),
        i=i,
        j=j,
        relative=relative,
        information=np.tile(np.eye(3), (7, 1, 1)),
        kind=kind,
        locked=np.zeros(7, dtype=bool),
        residual=np.zeros(7),
        weight=np.ones(7),
    )
    expected = np.full((5, 4), np.nan)
    for edge in range(7):
        error = np.linalg.inv(matrix(relative[edge])) @ np.linalg.inv(matrix(poses[i[edge]])) @ matrix(poses[j[edge]])
        sizes = math.hypot(error[0, 2], error[1, 2]), abs(math.atan2(error[1, 0], error[0, 0]))
        row, first = max(i[edge], j[edge]), 0 if kind[edge] == ODOMETRY else 2
        expected[row, first : first + 2] = np.fmax(expected[row, first : first + 2], sizes)
    stamps = np.array([5, 1, 2, 3, 4])
    series = residual_series(graph, poses, stamps)
    assert series.stamps_ns.tolist() == [1, 2, 3, 4, 5]
    np.testing.assert_allclose(series.values, expected[[1, 2, 3, 4, 0]], rtol=1e-9)
    assert [column.unit for column in series.columns] == ["m", "rad", "m", "rad"]
