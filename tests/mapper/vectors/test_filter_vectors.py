"""Vectors of the particle filter and its models by the textbook: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_filter_vectors.py --write`` rewrites them after a change of the textbook.
"""

from __future__ import annotations

import json
import sys
from itertools import cycle, product
from pathlib import Path
from typing import Any

import numpy as np

from mapper.localization import textbook

VECTORS = Path(__file__).parents[3] / "static" / "src" / "grid" / "filter.vectors.json"

POSES = ((0.0, 0.0, 0.0), (0.4, 0.1, 0.3), (-0.5, 0.0, 0.1), (0.003, 0.0, 1.0), (-0.2, -0.6, -2.9))
ALPHAS = (0.2, 0.1, 0.3, 0.05, 0.4)
NORMALS = ((0.3, -1.1, 0.7), (0.0, 0.0, 0.0), (-0.7, 0.3, 1.9))
WEIGHTS = ((0.1, 0.5, 0.15, 0.25), (0.0, 0.0, 1.0), (0.02,) * 50, (0.9, 0.05, 0.05))
MIXTURES = (
    {
        "z_hit": 0.5,
        "z_short": 0.05,
        "z_max": 0.05,
        "z_rand": 0.4,
        "sigma_hit": 0.2,
        "lambda_short": 0.1,
        "range_max": 8.0,
    },
    {
        "z_hit": 0.7,
        "z_short": 0.2,
        "z_max": 0.0,
        "z_rand": 0.1,
        "sigma_hit": 0.05,
        "lambda_short": 1.3,
        "range_max": 5.0,
    },
    {
        "z_hit": 0.95,
        "z_short": 0.1,
        "z_max": 0.0,
        "z_rand": 0.05,
        "sigma_hit": 0.03,
        "lambda_short": 2.0,
        "range_max": 8.0,
    },
)


def motions() -> list[dict[str, Any]]:
    """Return controls, standard deviations and sampled poses between pairs of poses."""
    found = []
    for (before, after), normals in zip(product(POSES, POSES), cycle(NORMALS)):
        control = textbook.odometry_control(np.array(before), np.array(after))
        sigmas = textbook.odometry_sigmas(control, ALPHAS[:4])
        pose = textbook.sample_motion_model_odometry(control, sigmas, np.array(before), np.array(normals))
        found.append(
            {
                "before": before,
                "after": after,
                "normals": normals,
                "control": control,
                "sigmas": sigmas.tolist(),
                "pose": pose.tolist(),
            }
        )
    return found


def omni() -> list[dict[str, Any]]:
    """Return poses of a robot that moves sideways too, after motions from the origin."""
    return [
        {
            "end": end,
            "normals": normals,
            "pose": textbook.sample_motion_model_omni(np.array(end), ALPHAS, np.zeros(3), np.array(normals)).tolist(),
        }
        for end, normals in product(POSES, NORMALS)
    ]


def draws() -> list[dict[str, Any]]:
    """Return which particles the low-variance sampler takes, and the effective number of the weights."""
    return [
        {
            "weights": weights,
            "r": share / count,
            "count": count,
            "drawn": textbook.low_variance_sampler(np.array(weights), share / count, count).tolist(),
            "effective": textbook.effective_number(np.array(weights)),
        }
        for weights, count, share in product(WEIGHTS, (1, 7, 24), (0.01, 0.63))
    ]


def shares() -> list[list[float]]:
    """Return w_slow, w_fast and the share of random particles after each of some averages."""
    slow, fast, found = 0.5, 0.5, []
    for average in (0.5, 0.48, 0.1, 0.12, 0.1, 0.4, 0.55):
        slow, fast, share = textbook.augmented_share(average, slow, fast, 0.05, 0.4)
        found.append([average, slow, fast, share])
    return found


def numbers() -> list[dict[str, float]]:
    """Return how many particles some bins need, by table 8.4."""
    return [
        {"k": k, "error": error, "quantile": quantile, "n": textbook.kld_number(k, error, quantile)}
        for k, error, quantile in product((0, 1, 2, 9, 24), (0.01, 0.05, 0.4), (0.0, 0.99, 2.33))
    ]


def densities() -> list[dict[str, Any]]:
    """Return p(z | x, m) of readings before, at and behind what the map has, and at the maximum."""
    return [
        {"z": z, "expected": expected, "mix": i, "p": textbook.beam_density(z, expected, *mix.values())}
        for (i, mix), z, expected in product(enumerate(MIXTURES), (0.0, 1.0, 2.9, 3.0, 3.3, 5.0, 8.0), (0.0, 3.0, 4.9))
    ]


def fields() -> list[dict[str, float]]:
    """Return the factors of end points by their distance from the nearest occupied cell."""
    return [
        {
            "distance": d,
            "mix": i,
            "q": textbook.likelihood_field_range_finder_model(
                np.array([d]), mix["z_hit"], mix["z_rand"], mix["sigma_hit"], mix["range_max"]
            ),
        }
        for d, (i, mix) in product((0.0, 0.1, 0.35, 2.0), enumerate(MIXTURES))
    ]


def vectors() -> dict[str, Any]:
    return {
        "alphas": ALPHAS,
        "mixtures": MIXTURES,
        "motions": motions(),
        "omni": omni(),
        "draws": draws(),
        "shares": shares(),
        "numbers": numbers(),
        "densities": densities(),
        "fields": fields(),
    }


def test_the_vectors_are_those_of_the_textbook() -> None:
    stored, fresh = json.loads(VECTORS.read_text()), json.loads(json.dumps(vectors()))
    for name in ("alphas", "mixtures"):
        assert stored[name] == fresh[name]
    for name in ("motions", "omni", "draws", "shares", "numbers", "densities", "fields"):
        for old, new in zip(stored[name], fresh[name], strict=True):
            for a, b in zip(*(one.values() if isinstance(one, dict) else one for one in (old, new)), strict=True):
                np.testing.assert_allclose(a, b, atol=1e-9)


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(json.dumps(vectors(), separators=(",", ":")) + "\n")
