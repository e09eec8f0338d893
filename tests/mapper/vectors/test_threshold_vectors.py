"""Vectors that compare the lecture's map file with the mapper: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_threshold_vectors.py --write`` rewrites them after a change of the file's text.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.io.maps.pixels import GREY_FREE, GREY_OCCUPIED, GREY_UNKNOWN
from mapper.io.maps.reading import load_map
from mapper.io.maps.writing import pgm_bytes, yaml_text

VECTORS = Path(__file__).parents[3] / "static" / "src" / "lessons" / "thresholds" / "thresholds.vectors.json"
GEOMETRY = GridGeometry(0.05, 3, 7, (-2.0, 1.25, 0.0))
LOG_ODDS = np.linspace(-2.0, 3.5, 21, dtype=np.float32).reshape(3, 7)
PAIRS = ((0.65, 0.25), (0.65, 0.196), (0.6, 0.5), (0.9, 0.2), (0.97, 0.13))


def values_of(occupied: float, free: float) -> list[int]:
    """Return what the mapper's reader makes of the three greys with these thresholds in the yaml."""
    with tempfile.TemporaryDirectory() as folder:
        image = bytes([GREY_OCCUPIED, GREY_UNKNOWN, GREY_FREE])
        Path(folder, "map.pgm").write_bytes(b"P5\n3 1\n255\n" + image)
        text = yaml_text(GridGeometry(0.05, 1, 3), "map.pgm", occupied_thresh=occupied, free_thresh=free)
        Path(folder, "map.yaml").write_text(text)
        return [int(value) for value in load_map(Path(folder, "map.yaml")).values[0]]


def vectors() -> dict[str, Any]:
    """Return a small grid, its image at several thresholds, its yaml, and how greys are read."""
    grid = OccupancyGrid(GEOMETRY)
    grid.log_odds[:] = LOG_ODDS
    grid.observed[:] = True
    grid.observed[1, 3] = grid.observed[2, 6] = False
    return {
        "geometry": {"resolution": 0.05, "rows": 3, "cols": 7, "origin": GEOMETRY.origin},
        "log_odds": [float(value) for value in LOG_ODDS.ravel()],
        "observed": [int(seen) for seen in grid.observed.ravel()],
        "images": [
            {"occupied": occupied, "free": free, "pgm": list(pgm_bytes(grid, occupied, free))}
            for occupied, free in PAIRS
        ],
        "yaml": yaml_text(GEOMETRY, "map.pgm"),
        "readings": [
            {"occupied": occupied, "free": free, "values": values_of(occupied, free)} for occupied, free in PAIRS
        ],
    }


def text() -> str:
    return json.dumps(vectors(), separators=(",", ":")) + "\n"


def test_the_vectors_of_the_lecture_are_those_of_the_mapper():
    hint = "run: python tests/mapper/vectors/test_threshold_vectors.py --write"
    assert json.loads(VECTORS.read_text()) == json.loads(text()), hint


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(text())
