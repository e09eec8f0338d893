"""The triangles of a surface: one node for each chunk."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from mapper.volume.mesh.chunk_mesh import STEPS, ChunkMesh
from server.scenes.chunk_nodes import ChunkNodes
from server.scenes.drawer import Drawer, DrawerContext, differs
from server.scenes.surface_glb import surface_glb
from server.sessions.drawings import Surface

CHUNK = 32


class SurfaceDrawer(Drawer[Surface, Surface]):
    """Sends the chunks that changed, and all of them in other colours or of another size."""

    max_hz: ClassVar[float] = 10.0

    def __init__(self, context: DrawerContext, drawing: Surface) -> None:
        super().__init__(context, drawing)
        self._shown: Surface | None = None
        self._nodes = ChunkNodes[ChunkMesh](context.scene, self.path)

    @property
    def unsettled(self) -> bool:
        """Whether replaced nodes are still there: the scene is drawn once more, and they are removed."""
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
