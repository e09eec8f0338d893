"""Vectors that compare the lecture's costmaps and paths with the textbook; the tests of the pages read them.

``python tests/mapper/vectors/test_navigation_vectors.py --write`` rewrites them after a change of the textbook.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mapper.costmap import textbook as costmap
from mapper.planning import PlannerConfig, textbook
from mapper.planning.plan import step_costs

VECTORS = Path(__file__).parents[3] / "static" / "src" / "lessons" / "navigation" / "navigation.vectors.json"
ROWS, COLS, RESOLUTION = 14, 18, 0.1


def grid(seed: int) -> np.ndarray:
    """Return costs with obstacles, a wall with a gap, unknown cells and some costs between."""
    rng = np.random.default_rng(seed)
    costs = rng.choice(np.array([0, 0, 0, 0, 60, 200, 255, 254], np.uint8), (ROWS, COLS))
    costs[:, 9] = 254
    costs[5:7, 8:11] = 0
    costs[1, 1] = costs[12, 16] = 0
    return costs


def inflations() -> list[dict[str, Any]]:
    """Return costs before and after inflation."""
    found = []
    for seed, (inscribed, radius, factor) in enumerate(((0.1, 0.35, 3.0), (0.22, 0.5, 10.0), (0.0, 0.2, 1.0))):
        costs = np.where(np.random.default_rng(seed).random((ROWS, COLS)) < 0.03, 254, grid(seed))
        costs = np.where((costs == 254) & (np.random.default_rng(seed + 9).random(costs.shape) < 0.8), 0, costs)
        cells = int(np.ceil(radius / RESOLUTION - 1e-9))
        out = costmap.inflate(costs.astype(np.uint8), RESOLUTION, cells, inscribed, factor, False, False)
        found.append(
            {
                "costs": costs.ravel().tolist(),
                "inscribed": inscribed,
                "radius": radius,
                "factor": factor,
                "inflated": out.ravel().tolist(),
            }
        )
    return found


def combinations() -> dict[str, Any]:
    """Return two layers and their combination by the greater cost."""
    master, layer = grid(4), grid(5)
    out = costmap.combine(master, layer, "max")
    return {"master": master.ravel().tolist(), "layer": layer.ravel().tolist(), "combined": out.ravel().tolist()}


def flat(cell: tuple[int, int]) -> int:
    return cell[0] * COLS + cell[1]


def searches() -> list[dict[str, Any]]:
    """Return the potentials and paths of both algorithms, -1 for infinity."""
    found = []
    start, goal = (1, 1), (12, 16)
    for seed in range(3):
        for unknown in (True, False):
            costs, table = grid(seed), step_costs(PlannerConfig(allow_unknown=unknown))
            for method in (textbook.dijkstra, textbook.a_star):
                potential = method(costs, table, start, goal)
                reached = bool(np.isfinite(potential[goal]))
                path = textbook.path_back(costs, table, potential, start, goal) if reached else np.zeros((0, 2), int)
                found.append(
                    {
                        "costs": costs.ravel().tolist(),
                        "unknown": unknown,
                        "a_star": method is textbook.a_star,
                        "start": flat(start),
                        "goal": flat(goal),
                        "potential": [round(p, 6) if np.isfinite(p) else -1 for p in potential.ravel().tolist()],
                        "path": [flat((int(r), int(c))) for r, c in path],
                    }
                )
    return found


def vectors() -> dict[str, Any]:
    return {
        "rows": ROWS,
        "cols": COLS,
        "resolution": RESOLUTION,
        "inflations": inflations(),
        "combination": combinations(),
        "searches": searches(),
    }


def test_the_vectors_are_those_of_the_textbook() -> None:
    fresh = json.loads(json.dumps(vectors()))
    assert json.loads(VECTORS.read_text()) == fresh
    reached = [bool(one["path"]) for one in fresh["searches"]]
    assert any(reached)
    assert not all(reached)


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(json.dumps(vectors(), separators=(",", ":")) + "\n")
