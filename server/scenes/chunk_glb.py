"""Triangles of a chunk as a binary glTF file of few bytes.

Positions are whole numbers (KHR_mesh_quantization). The material is not lit (KHR_materials_unlit): its colours have the
light in them, because lights are what a slow machine needs most of its time for. viser packs the file with zstd.

Source: glTF 2.0 Specification, Khronos Group, and the two extensions.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: How bright a face is by its side: −x, +x, −y, +y, −z, +z; light from above and from the south-west.
LIGHT = np.array([0.86, 0.74, 0.93, 0.66, 0.5, 1.0])

_COMPONENTS = {"uint8": 5121, "uint16": 5123, "uint32": 5125}
_JSON, _BIN = 0x4E4F534A, 0x004E4942  # types of chunks


def linear_of(colors: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return sRGB colours as linear ones, 0 to 1."""
    srgb = colors.astype(np.float64) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def glb_bytes(places: NDArray[Any], colors: NDArray[np.uint8], triangles: NDArray[Any]) -> bytes:
    """Return triangles (m, 3), m > 0, as a GLB file.

    ``places`` (n, 3) uint8 or uint16 are the vertices, ``colors`` (n, 4) uint8 linear RGB and alpha; ``triangles`` are
    of uint16 where there are so few vertices, or of uint32.
    """
    n = len(places)
    positions = np.zeros((n, 4), dtype=places.dtype)  # a vertex begins at a multiple of four bytes
    positions[:, :3] = places
    parts = [positions.tobytes(), colors.tobytes(), triangles.tobytes()]
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    stride = 4 * places.dtype.itemsize
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": len(parts[0]), "byteStride": stride, "target": 34962},
        {"buffer": 0, "byteOffset": starts[1], "byteLength": len(parts[1]), "byteStride": 4, "target": 34962},
        {"buffer": 0, "byteOffset": starts[2], "byteLength": len(parts[2]), "target": 34963},
    ]
    about = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_mesh_quantization", "KHR_materials_unlit"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"extensions": {"KHR_materials_unlit": {}}}],
        "buffers": [{"byteLength": starts[3]}],
        "bufferViews": views,
        "accessors": [
            {
                "bufferView": 0,
                "componentType": _COMPONENTS[places.dtype.name],
                "count": n,
                "type": "VEC3",
                "min": places.min(axis=0).tolist(),
                "max": places.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": _COMPONENTS["uint8"], "normalized": True, "count": n, "type": "VEC4"},
            {
                "bufferView": 2,
                "componentType": _COMPONENTS[triangles.dtype.name],
                "count": triangles.size,
                "type": "SCALAR",
            },
        ],
    }
    text = json.dumps(about, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data = b"".join(parts)
    data += b"\0" * (-len(data) % 4)
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
