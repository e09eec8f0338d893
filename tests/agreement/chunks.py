"""Parts of a mesh and the light on them, for the table: random fields, cut into random parts."""

from __future__ import annotations

from typing import Any

import numpy as np

from mapper.volume.mesh import textbook
from mapper.volume.mesh.chunk_mesh import STEPS, chunk_meshes, shaded
from mapper.volume.mesh.mesh import Mesh
from mapper.volume.mesh.meshing import surface_mesh
from mapper.volume.surface.tsdf import CENTRE
from tests.agreement.tsdf import FieldCase, volume_of

RESOLUTION = 0.1  # of the fields
LIGHT = np.array([0.9, 0.7, 0.95, 0.6, 0.5, 1.0], dtype=np.float32)


def parts(case: FieldCase) -> tuple[Mesh, np.ndarray, np.ndarray]:
    """The mesh of a field, the ends of three parts of its triangles, one of them empty, and their first places."""
    mesh = surface_mesh(volume_of(case))
    middle = len(mesh.triangles) // 3
    firsts = np.repeat(case.corner[None] - CENTRE + 0.5, 3, axis=0).astype(np.float64)
    firsts[2] += 2.0  # some places are cut off at 0
    return mesh, np.array([middle, middle, len(mesh.triangles)]), firsts


def colors_of(normals: np.ndarray) -> np.ndarray:
    """A colour for each normal."""
    colors: np.ndarray = (normals.astype(np.int64) * (3, 5, 7) % 256).astype(np.uint8)
    return colors


def parts_by_kernel(case: FieldCase) -> tuple[Any, ...]:
    out: list[Any] = []
    for part in chunk_meshes(*parts(case), RESOLUTION):
        shades = shaded(colors_of(part.normals), part.normals, LIGHT)
        out += [part.places, part.normals, part.triangles.astype(np.int64), shades / 255.0]
    return tuple(out)


def parts_by_textbook(case: FieldCase) -> tuple[Any, ...]:
    mesh, ends, firsts = parts(case)
    out: list[Any] = []
    begin = 0
    for end, first in zip(ends.tolist(), firsts, strict=True):
        part = textbook.part_of_mesh(mesh, mesh.triangles[begin:end], first, RESOLUTION, STEPS)
        out += [*part, textbook.shaded(colors_of(part[1]), part[1], LIGHT) / 255.0]
        begin = end
    return tuple(out)
