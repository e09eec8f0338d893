"""The voxels of a volume: one node for each chunk."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from server.scenes.chunk_nodes import ChunkNodes
from server.scenes.drawer import Drawer, DrawerContext, differs
from server.scenes.voxel_chunk import face_colors, voxel_chunk
from server.sessions.drawings import Voxels

CHUNK = 32


class VoxelsDrawer(Drawer[Voxels, Voxels]):
    """Sends the chunks that changed, and all of them in other colours or of another size."""

    max_hz: ClassVar[float] = 5.0

    def __init__(self, context: DrawerContext, drawing: Voxels) -> None:
        super().__init__(context, drawing)
        self._shown: Voxels | None = None
        self._nodes = ChunkNodes[NDArray[np.uint8]](context.scene, self.path)

    @property
    def unsettled(self) -> bool:
        """Whether replaced nodes still exist, which the next redraw removes."""
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
