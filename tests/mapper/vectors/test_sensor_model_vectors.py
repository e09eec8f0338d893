"""Vectors that compare the page's sensor and motion models with the library's: written here, read by the page's tests.

``python tests/mapper/vectors/test_sensor_model_vectors.py --write`` writes them anew after a change of a formula.
"""

from __future__ import annotations

import json
import math
import sys
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from mapper.localization import textbook

VECTORS = Path(__file__).parents[3] / "static" / "src" / "grid" / "filter.vectors.json"
RANGE_MAX = 8.0
MIXTURES = ((0.5, 0.005, 0.05, 0.5, 0.2, 0.1), (0.95, 0.1, 0.0, 0.05, 0.03, 2.0))
ALPHAS = (0.2, 0.1, 0.05, 0.3, 0.4)


def vectors() -> dict[str, list[dict[str, Any]]]:
    """Return densities of readings, and poses after motions from the origin."""
    beams = [
        {
            "z": z, "expected": expected, "range_max": RANGE_MAX, "mixture": mixture,
            "p": textbook.beam_density(z, expected, *mixture, RANGE_MAX),
        }
        for z, expected, mixture in product((0.0, 1.1, 3.9, 4.1, 7.9), (2.0, 4.0), MIXTURES)
    ]  # fmt: skip
    fields = [
        {
            "distance": d, "range_max": RANGE_MAX, "mixture": m,
            "p": textbook.likelihood_field_range_finder_model(np.array([d]), m[0], m[3], m[4], RANGE_MAX),
        }
        for d, m in product((0.0, 0.15, 0.6, 2.0), MIXTURES)
    ]  # fmt: skip
    ends = ((1.5, 0.3, 0.4), (-0.5, 0.1, -0.2), (0.004, 0.0, 1.0), (0.0, 0.0, 0.0), (0.2, -0.9, -3.0))
    motions = []
    for end, normals in product(ends, ((0.0, 0.0, 0.0), (1.0, -2.0, 0.5), (-0.7, 0.3, 1.9))):
        start, noise = np.zeros(3), np.array(normals)
        control = textbook.odometry_control(start, np.array(end))
        sigmas = textbook.odometry_sigmas(control, ALPHAS[:4])
        moved = {
            "differential": textbook.sample_motion_model_odometry(control, sigmas, start, noise),
            "omni": textbook.sample_motion_model_omni(np.array(end), ALPHAS, start, noise),
        }
        poses = {name: [*pose[:2].tolist(), math.cos(pose[2]), math.sin(pose[2])] for name, pose in moved.items()}
        motions.append({"end": end, "normals": normals, "alphas": ALPHAS, **poses})
    return {"beams": beams, "fields": fields, "motions": motions}


def test_the_vectors_are_those_of_the_library() -> None:
    told, now = json.loads(VECTORS.read_text()), json.loads(json.dumps(vectors()))
    assert told.keys() == now.keys()
    for name, rows in now.items():
        for one, other in zip(told[name], rows, strict=True):
            for key, value in other.items():
                np.testing.assert_allclose(one[key], value, rtol=1e-9, atol=1e-12)


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(json.dumps(vectors(), separators=(",", ":")) + "\n")
