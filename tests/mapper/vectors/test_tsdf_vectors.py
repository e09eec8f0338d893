"""Vectors that compare the lecture's beam with the textbooks of both volumes: written here, read by the pages' tests.

``python tests/mapper/vectors/test_tsdf_vectors.py --write`` rewrites them after a change.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.volume.occupancy import textbook
from mapper.volume.occupancy.parameters import VolumeConfig
from mapper.volume.occupancy.textbook import CENTRE
from mapper.volume.surface import textbook as textbook_tsdf
from mapper.volume.surface.parameters import TsdfConfig

VECTORS = Path(__file__).parents[3] / "static" / "src" / "lessons" / "tsdf" / "tsdf.vectors.json"
RESOLUTION = 0.1
VOXELS = 20
BEAMS = 6  #: readings of each vector


def along_x(readings: list[float]) -> tuple[Float64Array, Float64Array]:
    """Return the sensor (3,) and the points (n, 3) of beams along x through the centres of a row of voxels."""
    middle = RESOLUTION / 2
    return np.array([0.0, middle, middle]), np.array([[z, middle, middle] for z in readings])


def vector(
    readings: list[float], truncation: float, max_weight: float, *, carve: bool, drop_off: bool
) -> dict[str, Any]:
    """Return what both textbooks make of a row of voxels, reading by reading."""
    origin, points = along_x(readings)
    keys = [(CENTRE + k, CENTRE, CENTRE) for k in range(VOXELS)]
    voxels: textbook.Voxels = {}
    occupancy = VolumeConfig(resolution=RESOLUTION, discretise=False)
    for point in points:
        textbook.insert_scan(voxels, point[None].astype(np.float32), origin.astype(np.float32), occupancy)
    # A dense volume: all blocks are there before the first reading.
    surface: textbook_tsdf.Surface = {key: (np.float32(0.0), np.float32(0.0)) for key in keys} if carve else {}
    config = TsdfConfig(
        resolution=RESOLUTION, truncation=truncation, max_weight=max_weight, carve=carve, drop_off=drop_off
    )
    textbook_tsdf.fuse_points(surface, points, origin, config)
    found = [surface.get(key, (np.float32(0.0), np.float32(0.0))) for key in keys]
    return {
        "readings": readings,
        "fusion": {"truncation": truncation, "maxWeight": max_weight, "isCarved": carve, "hasDropOff": drop_off},
        "logOdds": [round(float(voxels[key]), 6) if key in voxels else None for key in keys],
        "distances": [round(float(distance), 6) for distance, _ in found],
        "weights": [round(float(weight), 6) for _, weight in found],
    }


def vectors() -> list[dict[str, Any]]:
    """Return rows of voxels with little and much noise, small and large truncations and weights, sparse and dense."""
    rng = np.random.default_rng(1996)
    found = []
    for wall, sigma, truncation, max_weight, carve, drop_off in (
        (1.234, 0.0, 0.4, 64.0, False, False),
        (1.234, 0.02, 0.4, 64.0, True, False),
        (0.987, 0.1, 0.2, 64.0, False, False),
        (1.311, 0.05, 0.6, 3.0, False, False),
        (0.651, 0.08, 0.26, 1.0, True, False),
        (1.311, 0.05, 0.6, 3.0, False, True),
        (1.012, 0.06, 0.3, 64.0, True, True),
    ):
        # Readings that are not multiples of 1 mm lie on no border of voxels in float32 either.
        readings = [round(wall + sigma * draw, 3) + 3e-4 for draw in rng.normal(size=BEAMS)]
        found.append(vector([round(z, 4) for z in readings], truncation, max_weight, carve=carve, drop_off=drop_off))
    return found


def test_the_vectors_are_those_of_the_textbooks() -> None:
    for kept, now in zip(json.loads(VECTORS.read_text()), vectors(), strict=True):
        assert (kept["readings"], kept["fusion"]) == (now["readings"], now["fusion"])
        assert [value is None for value in kept["logOdds"]] == [value is None for value in now["logOdds"]]
        for name in ("logOdds", "distances", "weights"):
            np.testing.assert_allclose(np.array(kept[name], float), np.array(now[name], float), atol=1e-5)


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(json.dumps(vectors(), separators=(",", ":")) + "\n")
