"""Triangle mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float32Array, Int32Array
from mapper.core.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Mesh:
    """``vertices`` (n, 3), metres in the map's frame, their ``normals`` (n, 3), and ``triangles`` (m, 3) of vertex
    indices.

    The corners of a triangle are counter-clockwise seen from the side to which the normals point. Raises
    :class:`ConfigError` for arrays of other shapes.
    """

    vertices: Float32Array
    normals: Float32Array
    triangles: Int32Array

    def __post_init__(self) -> None:
        n = len(self.vertices)
        if self.vertices.shape != (n, 3) or self.normals.shape != (n, 3) or self.triangles.shape[1:] != (3,):
            raise ConfigError(
                "mesh.shape",
                "A mesh is vertices (n, 3), normals (n, 3) and triangles (m, 3), not "
                f"{self.vertices.shape}, {self.normals.shape} and {self.triangles.shape}.",
            )

    @property
    def area(self) -> float:
        """Total area of the triangles, m²."""
        a, b, c = (self.vertices[self.triangles[:, k]].astype(np.float64) for k in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
