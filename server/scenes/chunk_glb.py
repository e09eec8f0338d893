"""Triangles of a chunk as a compact binary glTF file.

Positions are integers (KHR_mesh_quantization). The material is unlit (KHR_materials_unlit) and the colours include the
light, because lights take most of the time on a slow machine. viser compresses the file with zstd.

Source: glTF 2.0 Specification, Khronos Group, and the two extensions.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Brightness of a face by side: −x, +x, −y, +y, −z, +z; light from above and from the south-west.
LIGHT = np.array([0.86, 0.74, 0.93, 0.66, 0.5, 1.0])

_COMPONENTS = {np.dtype(np.uint8): 5121, np.dtype(np.uint16): 5123, np.dtype(np.uint32): 5125}
_JSON, _BIN = 0x4E4F534A, 0x004E4942  # types of chunks
_ABOUT = json.dumps(
    {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_mesh_quantization", "KHR_materials_unlit"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"extensions": {"KHR_materials_unlit": {}}}],
    },
    separators=(",", ":"),
)
#: Only the numbers that differ between files are inserted, because a scan changes a hundred chunks.
_NUMBERS = (
    ',"buffers":[{"byteLength":%d}],"bufferViews":['
    '{"buffer":0,"byteOffset":0,"byteLength":%d,"byteStride":%d,"target":34962},'
    '{"buffer":0,"byteOffset":%d,"byteLength":%d,"byteStride":4,"target":34962},'
    '{"buffer":0,"byteOffset":%d,"byteLength":%d,"target":34963}],"accessors":['
    '{"bufferView":0,"componentType":%d,"count":%d,"type":"VEC3","min":%s,"max":%s},'
    '{"bufferView":1,"componentType":5121,"normalized":true,"count":%d,"type":"VEC4"},'
    '{"bufferView":2,"componentType":%d,"count":%d,"type":"SCALAR"}]}'
)


def glb_bytes(places: NDArray[Any], colors: NDArray[np.uint8], triangles: NDArray[Any]) -> bytes:
    """Return triangles (m, 3), m > 0, as a GLB file.

    ``places`` (n, 3) uint8 or uint16 are the vertices, ``colors`` (n, 4) uint8 linear RGB and alpha. ``triangles`` are
    stored as uint16 if there are few enough vertices, otherwise as uint32.
    """
    n = len(places)
    positions = np.zeros((n, 4), dtype=places.dtype)  # a vertex begins at a multiple of four bytes
    positions[:, :3] = places
    parts = [positions.tobytes(), colors.tobytes(), triangles.tobytes()]
    a, b, c = map(len, parts)
    stride, kind = 4 * places.itemsize, _COMPONENTS[places.dtype]
    # Bounds are found faster in contiguous columns.
    columns = np.ascontiguousarray(places.T)
    low, high = (bound.tolist() for bound in (columns.min(axis=1), columns.max(axis=1)))
    text = (
        _ABOUT[:-1]
        + _NUMBERS
        % (a + b + c, a, stride, a, b, a + b, c, kind, n, low, high, n, _COMPONENTS[triangles.dtype], triangles.size)
    ).encode()
    text += b" " * (-len(text) % 4)
    rest = -(a + b + c) % 4
    length = 12 + 8 + len(text) + 8 + a + b + c + rest
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<II", len(text), _JSON),
            text,
            struct.pack("<II", a + b + c + rest, _BIN),
            *parts,
            b"\0" * rest,
        ]
    )
