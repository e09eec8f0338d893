"""The triangles of a surface and the voxels of a volume: one node for each chunk."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mapper.volume.mesh.chunk_mesh import STEPS, ChunkMesh, shaded
from mapper.volume.mesh.faces import CHUNK
from server.scenes.chunk_glb import LIGHT, glb_bytes
from server.scenes.chunk_nodes import ChunkNodes
from server.scenes.drawer import Drawer, DrawerContext, differs
from server.scenes.voxel_chunk import face_colors, voxel_chunk
from server.sessions.drawings import Surface, Voxels

_LIGHT = LIGHT.astype(np.float32)


class SurfaceDrawer(Drawer[Surface, Surface]):
    """Sends the chunks that changed, and all of them in other colours or of another size."""

    max_hz: ClassVar[float] = 10.0

    def __init__(self, context: DrawerContext, drawing: Surface) -> None:
        super().__init__(context, drawing)
        self._shown: Surface | None = None
        self._nodes = ChunkNodes[ChunkMesh](context.scene, self.path)

    @property
    def unsettled(self) -> bool:
        """Whether replaced nodes are still there: the scene is drawn again, and they are removed."""
        return self._nodes.unsettled

    def show(self, content: Surface) -> None:
        """Draw the chunks that changed."""
        self.place(content)
        if differs(self._shown, content, "size", "corner", "colors_key"):
            self._nodes.forget()
        self._shown = content
        self._nodes.show(
            content.chunks,
            lambda key, mesh: surface_glb(mesh, content.colors(key, mesh)),
            content.size / STEPS,
            lambda key: (CHUNK * key.astype(np.float64) - content.corner + 0.5) * content.size,
        )


def surface_glb(mesh: ChunkMesh, colors: NDArray[np.uint8]) -> bytes:
    """Return a chunk's triangles as a GLB file, in steps of its places; ``colors`` (n, 3) are those of its vertices."""
    return glb_bytes(mesh.places, shaded(colors, mesh.normals, _LIGHT), mesh.triangles)


class VoxelsDrawer(Drawer[Voxels, Voxels]):
    """Sends the chunks that changed, and all of them in other colours or of another size."""

    max_hz: ClassVar[float] = 5.0

    def __init__(self, context: DrawerContext, drawing: Voxels) -> None:
        super().__init__(context, drawing)
        self._shown: Voxels | None = None
        self._nodes = ChunkNodes[NDArray[np.uint8]](context.scene, self.path)

    @property
    def unsettled(self) -> bool:
        """Whether replaced nodes are still there: the scene is drawn again, and they are removed."""
        return self._nodes.unsettled

    def show(self, content: Voxels) -> None:
        """Draw the chunks that changed."""
        self.place(content)
        if differs(self._shown, content, "palette", "size", "corner", "by_side"):
            self._nodes.forget()
        self._shown = content
        colors = face_colors(content.palette, by_side=content.by_side)
        self._nodes.show(
            content.chunks,
            lambda _, quads: voxel_chunk(quads, colors),
            content.size,
            lambda key: (CHUNK * key.astype(np.float64) - content.corner) * content.size,
        )
