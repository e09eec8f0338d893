"""Vectors that compare the page's curve of costs with the library's: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_cost_vectors.py --write`` rewrites them after a change of the formula.
"""

from __future__ import annotations

import json
import sys
from itertools import product
from pathlib import Path
from typing import Any

from mapper.costmap import cost_of_distance

VECTORS = Path(__file__).parents[3] / "static" / "src" / "grid" / "costs.vectors.json"


def vectors() -> list[dict[str, Any]]:
    """Return costs of distances on both sides of inscribed radii."""
    return [
        {"distance": d, "inscribed": r, "factor": k, "cost": cost_of_distance(d, r, k)}
        for d, r, k in product((0.0, 0.05, 0.2, 0.21, 0.35, 0.55, 1.7), (0.0, 0.2, 0.51), (0.5, 3.0, 10.0))
    ]


def test_the_vectors_are_those_of_the_library() -> None:
    assert json.loads(VECTORS.read_text()) == vectors()


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(json.dumps(vectors(), separators=(",", ":")) + "\n")
