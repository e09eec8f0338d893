"""Compact encoding of the drawn faces of one voxel chunk, from which the page creates a glTF file.

Rectangles in glTF files have four corners of eight bytes each; here a voxel with faces has two to three bytes. The
page's script (``static/src/pages/scene.ts``) merges the faces again and passes the file to viser's client.

Little-endian: :data:`MAGIC`, uint32 k of colours, uint32 m of pairs, uint32 n of voxels; colours (6, k, 3) uint8 by
side and number, linear RGB; pairs (m, 2) uint8; colour numbers (n,) uint8. The voxels with faces are in the order of x
+ 32 y + 1024 z. A pair is the number of voxels without faces before the next one with faces, and the sides of its faces
as bits, 1 for −x, 2 for +x, 4 for −y, up to 32 for +z. Without a bit there is no voxel, and the number, 255, is added
to the next pair's. A colour number, from 0, is stored as its difference from the previous voxel's, modulo 256.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from mapper.volume.mesh.chunk_mesh import linear_of
from mapper.volume.mesh.faces import CHUNK
from server.scenes.chunk_glb import LIGHT

MAGIC = b"GBVX"
HEADER = struct.Struct("<4sIII")
_FARTHEST = 255  #: voxels that one pair skips
_STRIDES = np.array([1, CHUNK, CHUNK * CHUNK])  #: of x, y and z in the index of a voxel


def face_colors(palette: NDArray[np.uint8], *, by_side: bool = False) -> NDArray[np.uint8]:
    """Return the colours (6, k, 3) uint8 of faces by side and number in the ``palette`` (k, 3), linear RGB.

    If ``by_side``, the first six of the palette are those of the sides, and k is 1.
    """
    linear = linear_of(palette)
    # Brightness applies to the sRGB value, whose steps look equal. 2.2 is close enough to its curve.
    light = (LIGHT**2.2)[:, None, None]
    return np.round(255.0 * ((linear[:6, None] if by_side else linear[None]) * light)).astype(np.uint8)


def voxel_chunk(quads: NDArray[np.uint8], colors: NDArray[np.uint8]) -> bytes:
    """Return a chunk's rectangles (n, 7), n > 0, in the ``colors`` of :func:`face_colors` as bytes for the page.

    Colour numbers beyond the last one are clamped to it, because voxels coloured by side may have the numbers of
    heights.
    """
    sides, numbers = _voxels(quads)
    voxels = np.flatnonzero(sides)
    skipped = np.diff(voxels, prepend=-1) - 1
    number = np.minimum(numbers[voxels], colors.shape[1]).astype(np.uint8) - np.uint8(1)
    whole = skipped // _FARTHEST
    pairs = np.empty((len(voxels) + int(whole.sum()), 2), dtype=np.uint8)
    pairs[:] = _FARTHEST, 0
    pairs[np.cumsum(whole + 1) - 1] = np.column_stack([skipped % _FARTHEST, sides[voxels]])
    return b"".join(
        [
            HEADER.pack(MAGIC, colors.shape[1], len(pairs), len(voxels)),
            colors.tobytes(),
            pairs.tobytes(),
            np.diff(number, prepend=np.uint8(0)).tobytes(),
        ]
    )


def _voxels(quads: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the sides of each voxel's faces as bits (32³,) and its colour (32³,), from 1, if it has any."""
    quads = quads[np.argsort(quads[:, 0], kind="stable")]
    axis = quads[:, 0] // 2
    wide, areas = quads[:, 4].astype(np.int64), quads[:, 4].astype(np.int64) * quads[:, 5]
    of = np.repeat(np.arange(len(quads)), areas)
    along, across = _STRIDES[(axis + 1) % 3], _STRIDES[(axis + 2) % 3]
    within = np.arange(len(of)) - np.repeat(np.cumsum(areas) - areas, areas)
    row, column = np.divmod(within, wide[of])
    voxels = (quads[:, 1:4] @ _STRIDES)[of] + column * along[of] + row * across[of]
    sides, numbers = np.zeros((2, CHUNK**3), dtype=np.uint8)
    numbers[voxels] = quads[of, 6]
    # Faces of one side belong to different voxels, so that each assignment adds one bit.
    ends = np.cumsum(np.bincount(quads[of, 0], minlength=6)).tolist()
    for side, (begin, end) in enumerate(zip([0, *ends[:-1]], ends, strict=True)):
        sides[voxels[begin:end]] |= np.uint8(1 << side)
    return sides, numbers
