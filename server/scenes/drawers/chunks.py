"""The triangles of a surface and the voxels of a volume: one node for each chunk."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar, Generic, TypeVar

import numpy as np
import viser
from numpy.typing import NDArray

from mapper.volume.mesh.chunk_mesh import STEPS, ChunkMesh, shaded
from mapper.volume.mesh.faces import CHUNK
from server.scenes.chunk_glb import LIGHT, glb_bytes
from server.scenes.drawer import Drawer, DrawerContext, differs
from server.scenes.voxel_chunk import face_colors, voxel_chunk
from server.sessions.drawings import Surface, Voxels

ChunkKey = tuple[int, int, int]
ContentT = TypeVar("ContentT")


class ChunkNodes(Generic[ContentT]):
    """Replaces the node of a changed chunk. The old node is kept until the browser has had time to read the new one.

    viser's client continues drawing while it reads a GLB file, so that a node of the same name would vanish meanwhile.
    A chunk has changed if its content is another object.
    """

    def __init__(self, scene: viser.SceneApi, path: str) -> None:
        self._scene, self._path = scene, path
        self._shown: dict[ChunkKey, ContentT] = {}
        self._nodes: dict[ChunkKey, viser.GlbHandle] = {}
        self._old: list[viser.GlbHandle] = []
        self._turns: dict[ChunkKey, bool] = {}  #: which of its two names the node of a chunk has

    @property
    def unsettled(self) -> bool:
        """Whether replaced nodes still exist, which the next :meth:`show` removes."""
        return bool(self._old)

    def forget(self) -> None:
        """Send all chunks with the next :meth:`show`."""
        self._shown.clear()

    def show(
        self,
        chunks: Mapping[ChunkKey, ContentT],
        encoded: Callable[[ChunkKey, ContentT], bytes],
        scale: float,
        place: Callable[[NDArray[np.int64]], NDArray[np.float64]],
    ) -> None:
        """Send changed chunks, ``encoded`` as GLB files, at ``place`` of their key, scaled by ``scale``."""
        for node in self._old:
            node.remove()
        self._old.clear()
        for key in [key for key in self._nodes if key not in chunks]:
            self._nodes.pop(key).remove()
            self._shown.pop(key, None)
        for key in sorted(key for key, content in chunks.items() if self._shown.get(key) is not content):
            if key in self._nodes:
                self._old.append(self._nodes[key])
            turn = self._turns[key] = not self._turns.get(key, False)
            self._nodes[key] = self._scene.add_glb(
                f"{self._path}/{'_'.join(map(str, key))}_{'a' if turn else 'b'}",
                encoded(key, chunks[key]),
                scale=scale,
                position=place(np.array(key)),
                cast_shadow=False,
                receive_shadow=False,
            )
            self._shown[key] = chunks[key]


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
        """Whether replaced nodes still exist, which the next redraw removes."""
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
    """Return a chunk's triangles as a GLB file with integer positions; ``colors`` (n, 3) are those of its vertices."""
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
