"""One viser node for each chunk of a 3D map. Only changed chunks are sent again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

import numpy as np
import viser
from numpy.typing import NDArray

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
