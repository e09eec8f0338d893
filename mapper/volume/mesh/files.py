"""Mesh files: PLY, and glTF 2.0 as one binary file.

Source: Greg Turk's description of PLY (1994); Khronos, glTF 2.0 Specification, sections 3.7 (meshes) and 4 (GLB).
"""

from __future__ import annotations

import json
import os
import struct
from pathlib import Path

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError
from mapper.volume.mesh.mesh import Mesh

ENDINGS = (".ply", ".glb")
_FLOAT, _UINT32, _ARRAY, _ELEMENTS = 5126, 5125, 34962, 34963  # glTF's codes of types and buffers
# glTF has y up and z towards the viewer: a quarter turn about x maps our z to up.
_Z_UP_TO_Y_UP = (-0.7071067811865476, 0.0, 0.0, 0.7071067811865476)


def ply_bytes(mesh: Mesh, offset: Float64Array | None = None) -> bytes:
    """Return a mesh as a binary PLY file: vertices with normals, float32, and faces of three int32.

    ``offset`` (3,) is written as a comment; adding it to the vertices yields the coordinates of the mapped file.
    """
    moved = "" if offset is None or not offset.any() else f"comment offset {' '.join(map(repr, offset.tolist()))}\n"
    header = (
        f"ply\nformat binary_little_endian 1.0\ncomment metres, z up\n{moved}"
        f"element vertex {len(mesh.vertices)}\n"
        + "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
        + f"element face {len(mesh.triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(mesh.triangles), dtype=[("n", "u1"), ("of", "<i4", 3)])
    faces["n"], faces["of"] = 3, mesh.triangles
    points = np.concatenate([mesh.vertices, mesh.normals], axis=1).astype("<f4")
    return header.encode() + points.tobytes() + faces.tobytes()


def glb_bytes(mesh: Mesh, offset: Float64Array | None = None) -> bytes:
    """Return a mesh as a binary glTF file with one grey material.

    Coordinates are those of the map, in a node that rotates z up to glTF's y up; ``offset``, as in :func:`ply_bytes`,
    is in the node's extras. Raises :class:`ConfigError` for a mesh without triangles, which glTF cannot represent.
    """
    if not len(mesh.triangles):
        raise ConfigError("mesh.empty", "A GLB file cannot hold a mesh without triangles.")
    parts = (
        mesh.vertices.astype("<f4").tobytes(),
        mesh.normals.astype("<f4").tobytes(),
        mesh.triangles.astype("<u4").tobytes(),
    )
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    views = [
        {"buffer": 0, "byteOffset": start, "byteLength": len(part), "target": target}
        for start, part, target in zip(starts, parts, (_ARRAY, _ARRAY, _ELEMENTS), strict=False)
    ]
    n = len(mesh.vertices)
    moved = {} if offset is None or not offset.any() else {"extras": {"offset": offset.tolist()}}
    bounds = {"min": mesh.vertices.min(axis=0).tolist(), "max": mesh.vertices.max(axis=0).tolist()}
    tree = {
        "asset": {"version": "2.0", "generator": "Gridbloom"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "rotation": _Z_UP_TO_Y_UP} | moved],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0, "mode": 4}]}
        ],
        "materials": [
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.72, 0.74, 0.78, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9,
                },
                "doubleSided": True,
            }
        ],
        "accessors": [
            {"bufferView": 0, "componentType": _FLOAT, "count": n, "type": "VEC3", **bounds},
            {"bufferView": 1, "componentType": _FLOAT, "count": n, "type": "VEC3"},
            {"bufferView": 2, "componentType": _UINT32, "count": 3 * len(mesh.triangles), "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": starts[-1]}],
    }  # fmt: skip
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", starts[-1], b"BIN\0")
    size = 12 + len(chunks) + starts[-1]
    return b"".join([struct.pack("<4sII", b"glTF", 2, size), chunks, *parts])


def write_mesh(mesh: Mesh, path: str | os.PathLike[str], offset: Float64Array | None = None) -> None:
    """Write a mesh in the format of the file name's extension, .ply or .glb. Raises :class:`ConfigError` for others."""
    target = Path(path)
    if target.suffix not in ENDINGS:
        raise ConfigError("mesh.ending", f"A mesh is written as {' or '.join(ENDINGS)}, not as {target.name!r:.80}.")
    content = (ply_bytes if target.suffix == ".ply" else glb_bytes)(mesh, offset)
    with atomic_write(target) as out:
        out.write(content)
