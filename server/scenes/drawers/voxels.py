"""The voxels of a volume: one node for each chunk. Only chunks that changed are sent again."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser
from numpy.typing import NDArray

from server.scenes.drawer import Drawer, DrawerContext, differs
from server.scenes.voxel_glb import chunk_glb, face_colors
from server.sessions.drawings import Voxels

CHUNK = 32
ChunkKey = tuple[int, int, int]


class VoxelsDrawer(Drawer[Voxels, Voxels]):
    """Replaces the node of a changed chunk; the old one stays until the browser has had time to read the new one.

    viser's client reads a GLB file while it goes on drawing: a node of the same name would vanish meanwhile.
    """

    max_hz: ClassVar[float] = 5.0

    def __init__(self, context: DrawerContext, drawing: Voxels) -> None:
        super().__init__(context, drawing)
        self._shown: Voxels | None = None
        self._nodes: dict[ChunkKey, viser.GlbHandle] = {}
        self._old: list[viser.GlbHandle] = []
        self._turns: dict[ChunkKey, bool] = {}  #: which of its two names the node of a chunk has

    @property
    def unsettled(self) -> bool:
        """Whether replaced nodes are still there: the scene is drawn once more, and they are removed."""
        return bool(self._old)

    def show(self, content: Voxels) -> None:
        """Draw the chunks that changed."""
        self.place(content)
        for node in self._old:
            node.remove()
        self._old.clear()
        old, self._shown = self._shown, content
        before = {} if differs(old, content, "palette", "size", "corner", "by_side") or old is None else old.chunks
        for key in [key for key in self._nodes if key not in content.chunks]:
            self._nodes.pop(key).remove()
        changed = [(key, quads) for key, quads in content.chunks.items() if before.get(key) is not quads]
        if not changed:
            return
        colors = face_colors(content.palette, by_side=content.by_side)
        for key, quads in sorted(changed, key=lambda one: one[0]):
            if key in self._nodes:
                self._old.append(self._nodes[key])
            self._nodes[key] = self._added(content, key, quads, colors)

    def _added(
        self, content: Voxels, key: ChunkKey, quads: NDArray[np.uint8], colors: NDArray[np.uint8]
    ) -> viser.GlbHandle:
        turn = self._turns[key] = not self._turns.get(key, False)
        return self.scene.add_glb(
            f"{self.path}/{'_'.join(map(str, key))}_{'a' if turn else 'b'}",
            chunk_glb(quads, colors),
            scale=content.size,
            position=(CHUNK * np.array(key) - content.corner) * content.size,
            cast_shadow=False,
            receive_shadow=False,
        )
