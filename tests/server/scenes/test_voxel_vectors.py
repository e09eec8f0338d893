"""Vectors that compare the page's side of chunks of voxels with the server: written here, read by the pages' tests.

``python tests/server/scenes/test_voxel_vectors.py --write`` rewrites them after a change.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.volume.mesh.faces import triangles_of
from server.scenes.voxel_chunk import face_colors, voxel_chunk
from tests.server.scenes.voxel_world import PALETTE, blocks_world, seen_from_inside

VECTORS = Path(__file__).parents[3] / "static" / "src" / "render" / "voxels" / "voxels.vectors.json"


def vector(quads: NDArray[np.uint8], *, by_side: bool = False) -> dict[str, Any]:
    """Return a chunk's bytes, its rectangles, and of each rectangle its corners and its colour."""
    palette = np.random.default_rng(0).integers(0, 256, (6, 3), dtype=np.uint8) if by_side else PALETTE
    colors = face_colors(palette, by_side=by_side)
    corners, triangles = triangles_of(quads)
    return {
        "hex": voxel_chunk(quads, colors).hex(),
        "rectangles": np.column_stack([quads[:, :6], quads[:, 6] - 1]).tolist(),
        "triangles": corners[triangles].reshape(len(quads), 18).tolist(),
        "colours": colors[quads[:, 0], quads[:, 6] - 1].tolist(),
    }


def vectors() -> dict[str, Any]:
    """Return chunks of boxes, of one voxel at the chunk's end, and of a room seen from inside; and broken ones."""
    boxes = blocks_world(((1, 2, 3), (5, 4, 8)), ((4, 2, 8), (30, 32, 9)), ((9, 9, 20), (12, 12, 21)))
    plain = blocks_world(((1, 2, 3), (5, 4, 8)), ((4, 2, 8), (30, 32, 9)), colours=1)
    last = blocks_world(((31, 31, 31), (32, 32, 32)))
    _, room = seen_from_inside(np.random.default_rng(2), 300)
    (quads,), (same,), (one,), (seen,) = (list(faces.chunks.values()) for faces in (boxes, plain, last, room))
    chunk = voxel_chunk(one, face_colors(PALETTE))
    beyond = bytearray(chunk)
    beyond[-3] += 1  # the number of voxels skipped before the only one
    colourless = chunk[:-1] + bytes([2])
    return {
        "chunks": [vector(quads), vector(same, by_side=True), vector(one), vector(seen)],
        "broken": [
            chunk[:-1].hex(),
            (chunk + b"\0").hex(),
            bytes(beyond).hex(),
            colourless.hex(),
            chunk[:8].hex(),
            b"glTF".hex(),
        ],
    }


def test_the_vectors_of_the_pages_are_current() -> None:
    kept = json.loads(VECTORS.read_text(encoding="utf-8"))
    assert kept == vectors(), f"stale: run python {Path(__file__).relative_to(VECTORS.parents[4])} --write"


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(json.dumps(vectors()) + "\n", encoding="utf-8")
