"""Vectors that compare the lecture's pose graph with the library's: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_graph_vectors.py --write`` rewrites them after a change of the optimiser.
"""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mapper.core.se2 import compose, inverse
from mapper.slam import LOOP, ODOMETRY, PoseGraph
from mapper.slam.optimise import optimise
from mapper.slam.sparse_system import SparseSystem
from mapper.slam.textbook import optimise_dense

VECTORS = Path(__file__).parents[3] / "static" / "src" / "lessons" / "graph" / "graph.vectors.json"
NODES = 9  #: the last one is at the place of the first
SCALE = 3.0
KERNELS = ("geman_mcclure", "cauchy", "huber", "none")
HELD, HELD_AT = 4, (1.2, 3.1, 2.4)


def graph() -> PoseGraph:
    """Return an octagon whose odometry drifts, with a loop that closes it and one that contradicts the rest."""
    rng = np.random.default_rng(14)
    turn = 2.0 * math.pi / (NODES - 1)
    true = [np.zeros(3)]
    for _ in range(NODES - 1):
        true.append(compose(true[-1], [1.0, 0.0, turn]))
    odometry = np.array([1.03, 0.02, turn - 0.03]) + rng.normal(0.0, [0.02, 0.01, 0.01], (NODES - 1, 3))
    poses = [np.zeros(3)]
    for motion in odometry:
        poses.append(compose(poses[-1], motion))
    ends = [*((k, k + 1) for k in range(NODES - 1)), (0, 8), (1, 7), (2, 6)]
    loops = [compose(inverse(true[0]), true[8]), compose(inverse(true[1]), true[7]), np.array([0.4, -0.5, 0.3])]
    skewed = np.array([[60.0, 12.0, 5.0], [12.0, 90.0, -8.0], [5.0, -8.0, 400.0]])
    i, j = np.array(ends).T
    e = len(ends)
    return PoseGraph(
        np.arange(NODES), np.array(poses).round(6), i, j, np.array([*odometry, *loops]).round(6),
        np.repeat(skewed[np.newaxis], e, axis=0), np.r_[np.full(NODES - 1, ODOMETRY), np.full(3, LOOP)],
        np.zeros(e, np.bool_), np.zeros(e), np.ones(e),
    )  # fmt: skip


def held() -> PoseGraph:
    """Return the graph's solution while two nodes are held, the second at another place."""
    start = graph()
    poses = start.poses.copy()
    poses[HELD] = HELD_AT
    system = SparseSystem(NODES, np.column_stack([start.i, start.j]), np.array([0, HELD]))
    return optimise(replace(start, poses=poses), robust="cauchy", robust_scale=SCALE, system=system)


def written(found: PoseGraph) -> dict[str, Any]:
    return {"poses": found.poses.tolist(), "residuals": found.residual.tolist(), "weights": found.weight.tolist()}


def vectors() -> dict[str, Any]:
    """Return the graph, and what the optimiser makes of it with each kernel."""
    start = graph()
    edges = [
        {"i": i, "j": j, "relative": relative, "information": omega, "isLoop": kind == LOOP}
        for i, j, relative, omega, kind in zip(
            start.i.tolist(), start.j.tolist(), start.relative.tolist(),
            [[o[0][0], o[0][1], o[0][2], o[1][1], o[1][2], o[2][2]] for o in start.information.tolist()],
            start.kind.tolist(), strict=True,
        )
    ]  # fmt: skip
    solved = {kernel: written(optimise(start, robust=kernel, robust_scale=SCALE)) for kernel in KERNELS}
    return {
        "poses": start.poses.tolist(), "edges": edges, "scale": SCALE, "solved": solved,
        "held": {"node": HELD, "pose": HELD_AT, **written(held())},
    }  # fmt: skip


def text() -> str:
    return json.dumps(vectors(), separators=(",", ":")).replace(',"', ',\n"') + "\n"


def assert_alike(old: Any, new: Any, where: str) -> None:
    if isinstance(new, dict):
        assert old.keys() == new.keys(), where
        for key in new:
            assert_alike(old[key], new[key], f"{where} {key}")
    elif isinstance(new, list) and new and isinstance(new[0], dict):
        for one, other in zip(old, new, strict=True):
            assert_alike(one, other, where)
    else:
        np.testing.assert_allclose(old, new, atol=1e-6, err_msg=where)


def test_the_vectors_of_the_pose_graph_are_those_of_the_optimiser():
    hint = "run: python tests/mapper/vectors/test_graph_vectors.py --write"
    assert_alike(json.loads(VECTORS.read_text()), json.loads(text()), hint)


def test_the_vectors_show_what_a_kernel_does():
    """Least squares give way to the wrong loop; the kernel refuses it, and the poses are as if it were not there."""
    solved = vectors()["solved"]
    assert solved["none"]["weights"] == [1.0] * (NODES + 2)
    assert solved["geman_mcclure"]["weights"][-1] < 0.001
    assert min(solved["geman_mcclure"]["weights"][:-1]) > 0.3
    start = graph()
    np.testing.assert_allclose(solved["none"]["poses"], optimise_dense(start), atol=1e-4)
    without = optimise_dense(start.without_edge(len(start.i) - 1))
    kept = np.array(solved["geman_mcclure"]["poses"])
    assert np.abs(kept - without).max() < 0.1 < np.abs(np.array(solved["none"]["poses"]) - without).max()


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(text())
