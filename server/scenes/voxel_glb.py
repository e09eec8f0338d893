"""The rectangles of one chunk of voxels as a GLB file: positions are whole numbers of voxels as bytes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.volume.faces import triangles_of
from mapper.volume.textbook_chunks import linear_of
from server.scenes.chunk_glb import LIGHT, glb_bytes

GROUP = 128  #: rectangles whose corners are stored together


def face_colors(palette: NDArray[np.uint8], *, by_side: bool = False) -> NDArray[np.uint8]:
    """Return the colours (6, k + 1, 4) uint8 of faces by side and number in the palette, linear RGB and alpha."""
    linear = linear_of(palette)
    table = np.full((6, len(palette) + 1, 4), 255, dtype=np.uint8)
    # Brightness is of the sRGB value, whose steps look equal: 2.2 is near enough to its curve.
    light = (LIGHT**2.2)[:, None, None]
    table[:, 1:, :3] = np.round(255.0 * (linear[:6, None] if by_side else linear[None] * light))
    return table


def chunk_glb(quads: NDArray[np.uint8], colors: NDArray[np.uint8]) -> bytes:
    """Return a chunk's rectangles (n, 7), n > 0, in the ``colors`` of :func:`face_colors` as a GLB file, in voxels.

    Of :data:`GROUP` rectangles all first corners come first, then all second ones, and so on: places that follow each
    other are nearly the same, and the packed file is up to a quarter smaller. The last group is filled up with corners
    that no triangle uses. So the indices of all chunks are the same numbers, of which only the first ones take room.
    """
    order = np.lexsort((quads[:, 1], quads[:, 2], quads[:, 3], quads[:, 0]))
    n = len(quads)
    quads = np.pad(quads[order], ((0, -n % GROUP), (0, 0)), mode="edge")
    corners, _ = triangles_of(quads)
    places = corners.reshape(-1, GROUP, 4, 3).swapaxes(1, 2).reshape(-1, 3)
    shades = colors[quads[:, 0], quads[:, 6]].reshape(-1, 1, GROUP, 4).repeat(4, axis=1).reshape(-1, 4)
    number = np.arange(n)
    first = number // GROUP * (4 * GROUP) + number % GROUP
    indices = first[:, None] + GROUP * np.array([0, 1, 2, 0, 2, 3])
    kind = np.uint16 if len(places) <= 1 << 16 else np.uint32
    return glb_bytes(places, shades, indices.reshape(-1, 3).astype(kind))
