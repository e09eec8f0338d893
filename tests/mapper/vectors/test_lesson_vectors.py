"""Vectors that compare the lecture's figures with the textbook: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_lesson_vectors.py --write`` rewrites them after a change of the algorithms.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping import textbook
from mapper.mapping import textbook_traversal as traversal
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.sensors.scan import LaserScan

VECTORS = Path(__file__).parents[3] / "static" / "src" / "grid" / "textbook.vectors.json"

NAMES = (
    "range_max", "window", "log_odds_hit", "log_odds_miss", "update", "traversal", "no_return", "clamp",
    "log_odds_min", "log_odds_max", "log_odds_prior",
)  # fmt: skip

CONFIGS: tuple[dict[str, Any], ...] = (
    {},
    {"window": 0.45},
    {"window": 0.1, "traversal": "amanatides_woo"},
    {"traversal": "amanatides_woo", "no_return": "free", "range_max": 1.9},
    {"no_return": "free", "range_max": 1.9},
    {"range_max": 1.9},
    {"no_return": "hit", "range_max": 1.9},
    {"no_return": "hit", "range_max": 1.7},  # which float32 rounds up
    {"no_return": "hit", "range_max": 1.9, "update": "per_scan"},
    {"clamp": False, "log_odds_hit": 1.3, "log_odds_miss": -0.15, "log_odds_prior": -0.3},
    {"log_odds_min": -1.0, "log_odds_max": 1.2},
    {"update": "per_scan"},
    {"update": "per_scan", "window": 0.45},
    {"update": "per_scan", "no_return": "free", "range_max": 1.9, "window": 0.3},
    {"model": "hit_counting", "prior_weight": 3.0, "window": 0.3},
    {"model": "hit_counting", "prior_weight": 2.0, "update": "per_scan", "no_return": "free", "range_max": 1.9},
    {"model": "hit_counting", "prior_weight": 0.7, "log_odds_prior": -0.3, "clamp": False},
)
GEOMETRY: dict[str, Any] = {"resolution": 0.25, "rows": 12, "cols": 16, "origin": (-1.0, -0.5, 0.0)}
POSES = ((0.913, 0.871, 0.613), (1.377, 0.789, -2.101), (1.377, 0.789, -2.031))
BEAMS = 24


def ranges(scan: int) -> list[float]:
    """Return readings that no grid is fitted to: most within the grid, some beyond it, and each special value."""
    values = 0.37 + 1.1 * np.abs(np.sin(1.7 * np.arange(BEAMS) + scan)) + 0.06 * np.arange(BEAMS)
    values[5], values[11], values[17] = np.inf, np.nan, 0.01
    return [float(value) for value in values.astype(np.float32)]


def mapped(changes: dict[str, Any]) -> list[list[float]]:
    """Return [index, log-odds] of every observed cell after three scans; the textbook's own updates."""
    config = MappingConfig(resolution=GEOMETRY["resolution"], **changes)
    grid = OccupancyGrid(GridGeometry(**GEOMETRY), config.log_odds_prior)
    for i, pose in enumerate(POSES):
        scan = LaserScan(np.array(ranges(i), np.float32), 0.05, 2.0 * np.pi / BEAMS, 0.05, 5.0)
        textbook.occupancy_grid_mapping(grid, scan, pose, config)
    flat, seen = grid.log_odds.ravel(), np.flatnonzero(grid.observed.ravel())
    return [[int(i), float(flat[i])] for i in seen]


def lines() -> list[dict[str, Any]]:
    """Return lines in every octant with both traversals' cells."""
    ends = [(c, r) for c in (-7.3, -2.4, 0.6, 3.2, 8.7) for r in (-6.6, -1.7, 0.4, 2.9, 7.1)]
    cells = [(int(np.floor(v)), int(np.floor(u))) for u, v in ends]
    return [
        {
            "end": end,
            "bresenham": traversal.bresenham((0, 0), cell),
            "amanatides_woo": traversal.amanatides_woo((0.3, 0.6), end),
        }
        for end, cell in zip(ends, cells, strict=True)
    ]


def vectors() -> dict[str, Any]:
    """Return the table's first values, lines, and maps of three scans with each configuration."""
    return {
        "initial": {name: BY_NAME[name].initial for name in NAMES},
        "geometry": GEOMETRY,
        "poses": POSES,
        "scans": [[str(value) if not np.isfinite(value) else value for value in ranges(i)] for i in range(len(POSES))],
        "lines": lines(),
        "maps": [{"config": changes, "cells": mapped(changes)} for changes in CONFIGS],
    }


def text() -> str:
    return json.dumps(vectors(), separators=(",", ":")).replace('{"config"', '\n{"config"') + "\n"


def test_the_vectors_of_the_lecture_are_those_of_the_textbook():
    stored, fresh = json.loads(VECTORS.read_text()), json.loads(text())
    hint = "run: python tests/mapper/vectors/test_lesson_vectors.py --write"
    assert {key: stored[key] for key in ("initial", "geometry", "poses", "scans", "lines")} == {
        key: fresh[key] for key in ("initial", "geometry", "poses", "scans", "lines")
    }, hint
    for old, new in zip(stored["maps"], fresh["maps"], strict=True):
        assert old["config"] == new["config"], hint
        np.testing.assert_allclose(old["cells"], new["cells"], atol=1e-6, err_msg=hint)


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(text())
