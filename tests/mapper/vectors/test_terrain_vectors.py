"""Vectors that compare the page's planes of patches with the textbook's: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_terrain_vectors.py --write`` rewrites them after a change.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mapper.terrain.patches import TRIALS
from mapper.terrain.textbook import moments_of, plane_of, ransac_plane, triples_of

VECTORS = Path(__file__).parents[3] / "static" / "src" / "lessons" / "terrain" / "terrain.vectors.json"


def vectors() -> list[dict[str, Any]]:
    """Return patches of few and many points, flat, steep and rough, and such as have no plane."""
    rng = np.random.default_rng(17)
    patches = [np.zeros((0, 3)), np.ones((2, 3)), np.arange(12.0).reshape(4, 3)]
    for n, slope, noise in ((3, 0.3, 0.0), (9, 0.0, 0.01), (9, 1.5, 0.05), (20, -0.4, 0.3), (70, 0.2, 0.1)):
        xy = rng.uniform(-1.0, 1.0, (n, 2))
        patches.append(np.column_stack([xy, 0.2 + slope * xy[:, 0] - 0.1 * xy[:, 1] + rng.normal(0.0, noise, n)]))
    found = []
    for points in (np.round(patch, 3) for patch in patches):
        moments = moments_of(points.tolist())
        plane = plane_of(moments)
        numbers = {name: getattr(plane, name) for name in ("a", "b", "c", "n", "residual", "roughness", "slope")}
        numbers["meanHeight"] = plane.mean_height
        found.append(
            {
                "points": points.tolist(),
                "moments": np.round(moments, 12).tolist(),
                "agreeing": ransac_plane(points, triples_of(len(points), TRIALS), 0.1)[1].astype(int).tolist(),
                "plane": None if np.isnan(plane.a) else {name: round(value, 10) for name, value in numbers.items()},
            }
        )
    return found


def test_the_vectors_are_those_of_the_textbook() -> None:
    for kept, now in zip(json.loads(VECTORS.read_text()), vectors(), strict=True):
        assert kept["points"] == now["points"]
        assert kept["agreeing"] == now["agreeing"]
        np.testing.assert_allclose(kept["moments"], now["moments"], atol=1e-9)
        assert (kept["plane"] is None) == (now["plane"] is None)
        for name, value in (now["plane"] or {}).items():
            np.testing.assert_allclose(kept["plane"][name], value, atol=1e-7)


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(json.dumps(vectors(), separators=(",", ":")) + "\n")
