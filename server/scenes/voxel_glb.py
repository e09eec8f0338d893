"""The rectangles of one chunk of voxels as a binary glTF file of few bytes.

Positions are whole numbers of voxels as bytes (KHR_mesh_quantization). The material is not lit (KHR_materials_unlit):
its colours have the light in them, because lights are what a slow machine needs most of its time for. viser packs the
file with zstd; the indices of all chunks are the same numbers, of which only the first ones take room.

Source: glTF 2.0 Specification, Khronos Group, and the two extensions.
"""

from __future__ import annotations

import json
import struct

import numpy as np
from numpy.typing import NDArray

from mapper.volume.faces import triangles_of

#: How bright a face is by its side: −x, +x, −y, +y, −z, +z; light from above and from the south-west.
LIGHT = np.array([0.86, 0.74, 0.93, 0.66, 0.5, 1.0])

_BYTE, _SHORT, _INT = 5121, 5123, 5125  # component types
_JSON, _BIN = 0x4E4F534A, 0x004E4942  # types of chunks


def face_colors(palette: NDArray[np.uint8], *, by_side: bool = False) -> NDArray[np.uint8]:
    """Return the colours (6, k + 1, 4) uint8 of faces by side and number in the palette, linear RGB and alpha."""
    srgb = palette.astype(np.float64) / 255.0
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    table = np.full((6, len(palette) + 1, 4), 255, dtype=np.uint8)
    # Brightness is of the sRGB value, whose steps look equal: 2.2 is near enough to its curve.
    light = (LIGHT**2.2)[:, None, None]
    table[:, 1:, :3] = np.round(255.0 * (linear[:6, None] if by_side else linear[None] * light))
    return table


def chunk_glb(quads: NDArray[np.uint8], colors: NDArray[np.uint8]) -> bytes:
    """Return a chunk's rectangles (n, 7), n > 0, in the ``colors`` of :func:`face_colors` as a GLB file, in voxels."""
    order = np.lexsort((quads[:, 1], quads[:, 2], quads[:, 3], quads[:, 0]))
    quads = quads[order]
    corners, faces = triangles_of(quads)
    n = len(corners)
    positions = np.zeros((n, 4), dtype=np.uint8)  # a vertex begins at a multiple of four bytes
    positions[:, :3] = corners
    shades = np.repeat(colors[quads[:, 0], quads[:, 6]], 4, axis=0)
    is_short = n <= 1 << 16
    indices = faces.astype(np.uint16 if is_short else np.uint32)
    parts = [indices.tobytes(), positions.tobytes(), shades.tobytes()]
    sizes = [len(part) for part in parts]
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": sizes[0], "target": 34963},
        {"buffer": 0, "byteOffset": sizes[0], "byteLength": sizes[1], "byteStride": 4, "target": 34962},
        {"buffer": 0, "byteOffset": sizes[0] + sizes[1], "byteLength": sizes[2], "byteStride": 4, "target": 34962},
    ]
    about = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_mesh_quantization", "KHR_materials_unlit"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1, "COLOR_0": 2}, "indices": 0, "material": 0}]}],
        "materials": [{"extensions": {"KHR_materials_unlit": {}}}],
        "buffers": [{"byteLength": sum(sizes)}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": 0, "componentType": _SHORT if is_short else _INT, "count": 3 * len(faces), "type": "SCALAR"},
            {
                "bufferView": 1,
                "componentType": _BYTE,
                "count": n,
                "type": "VEC3",
                "min": corners.min(axis=0).tolist(),
                "max": corners.max(axis=0).tolist(),
            },
            {"bufferView": 2, "componentType": _BYTE, "normalized": True, "count": n, "type": "VEC4"},
        ],
    }
    text = json.dumps(about, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data = b"".join(parts)
    length = 12 + 8 + len(text) + 8 + len(data)
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<II", len(text), _JSON),
            text,
            struct.pack("<II", len(data), _BIN),
            data,
        ]
    )
