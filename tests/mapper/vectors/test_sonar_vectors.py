"""Vectors that compare the lecture's sonar maps with the textbook: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_sonar_vectors.py --write`` rewrites them after a change of the models.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping import textbook
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import SonarScan

VECTORS = Path(__file__).parents[3] / "static" / "src" / "lessons" / "sonar" / "sonar.vectors.json"
GEOMETRY: dict[str, Any] = {"resolution": 0.2, "rows": 13, "cols": 15, "origin": (-0.5, -0.6, 0.0)}
POSES = ((0.513, 0.671, 0.413), (0.877, 0.589, -1.101), (1.013, 0.823, 2.031))
BEARINGS = [-1.57, -0.61, 0.0, 0.43, 1.1, 2.7]
RANGES = (
    (0.7, 1.13, np.inf, 0.02, 0.93, 0.51),
    (0.47, 0.86, 1.31, 1.02, np.inf, 1.22),
    (1.07, 0.95, 0.63, 1.44, 0.71, np.nan),
)
SETTINGS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("sonar_cone", {"opening": 0.5236, "window": 0.3, "profile": "flat", "no_return": "ignore"}),
    ("sonar_cone", {"opening": 0.71, "window": 0.1, "profile": "gaussian", "no_return": "free"}),
    ("moravec_elfes", {"opening": 0.5236, "window": 0.3, "profile": "flat", "no_return": "ignore"}),
    ("moravec_elfes", {"opening": 0.71, "window": 0.1, "profile": "flat", "no_return": "free"}),
)


def mapped(model: str, settings: dict[str, Any]) -> tuple[list[list[float]], list[list[float]]]:
    """Return [index, log-odds] of every observed cell, and its two statistics where the model keeps some."""
    changes = {"cone_profile" if name == "profile" else name: value for name, value in settings.items()}
    config = MappingConfig(model=model, resolution=GEOMETRY["resolution"], **changes)
    grid = OccupancyGrid(GridGeometry(**GEOMETRY))
    for pose, ranges in zip(POSES, RANGES, strict=True):
        scan = SonarScan(np.array(ranges, np.float32), np.array(BEARINGS), settings["opening"], 0.05, 2.5)
        textbook.occupancy_grid_mapping(grid, scan, pose, config)
    flat, seen = grid.log_odds.ravel(), np.flatnonzero(grid.observed.ravel())
    cell_statistics = (
        [] if grid.cell_statistics is None else grid.cell_statistics.reshape(2, -1)[:, seen].T.astype(float).tolist()
    )
    return [[int(i), float(flat[i])] for i in seen], cell_statistics


def vectors() -> dict[str, Any]:
    """Return the scans, and the map that each model makes of them."""
    maps = []
    for model, settings in SETTINGS:
        cells, cell_statistics = mapped(model, settings)
        maps.append({"model": model, "settings": settings, "cells": cells, "statistics": cell_statistics})
    scans = [[value if np.isfinite(value) else str(value) for value in ranges] for ranges in RANGES]
    return {"geometry": GEOMETRY, "poses": POSES, "bearings": BEARINGS, "scans": scans, "maps": maps}


def text() -> str:
    return json.dumps(vectors(), separators=(",", ":")).replace('{"model"', '\n{"model"') + "\n"


def test_the_vectors_of_the_sonar_maps_are_those_of_the_textbook():
    stored, fresh = json.loads(VECTORS.read_text()), json.loads(text())
    hint = "run: python tests/mapper/vectors/test_sonar_vectors.py --write"
    assert {key: stored[key] for key in ("geometry", "poses", "bearings", "scans")} == {
        key: fresh[key] for key in ("geometry", "poses", "bearings", "scans")
    }, hint
    for old, new in zip(stored["maps"], fresh["maps"], strict=True):
        assert (old["model"], old["settings"]) == (new["model"], new["settings"]), hint
        np.testing.assert_allclose(old["cells"], new["cells"], atol=1e-5, err_msg=hint)
        np.testing.assert_allclose(old["statistics"], new["statistics"], atol=1e-6, err_msg=hint)


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(text())
