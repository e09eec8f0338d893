"""The layers of a session: written by the computation, published by the event loop, read by clients.

A layer is written on a worker thread. Its changes take effect with :meth:`Layer.publish`, which the hub calls on the
event loop while the worker does not run. Content is encoded once for all clients; a :class:`Cursor` records what one
client has of a layer. Points, paths and graphs are always sent in full; grids are in :mod:`server.stream.grid_layer`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from server.stream.message_parts import LayerInfo
from server.stream.messages import Geometry
from server.stream.protocol import CODECS, Graph

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Body:
    """The encoded body of a frame, with the fields of its header; ``tiles`` is the number of its tiles."""

    kind: int
    epoch: int
    count: int
    parts: Sequence[bytes]
    complete: bool = True
    tiles: int = 0


class Cursor(ABC):
    """Records what one client has of a layer (event loop)."""

    batch = 0  #: number of the client's last batch that contained the layer

    @abstractmethod
    def is_behind(self) -> bool:
        """Return whether there is newer content than the client was sent."""

    @abstractmethod
    def take(self, room: int, share: int, focus_xy: Point, *, always: bool) -> Body | None:
        """Return the next body, and mark it as sent.

        A layer that can be divided returns about ``share`` bytes. Other layers return at most ``room`` bytes, otherwise
        None, unless ``always``. Tiles nearest to ``focus_xy``, map metres, are sent first.
        """

    def announcement(self, layer: int) -> Geometry | None:  # noqa: ARG002 - most have none
        """Return the message to send once before the next frame of the layer with the id ``layer``."""
        return None

    def resume(self, epoch: int, revision: int) -> None:  # noqa: B027 - nothing to do for content that is always sent whole
        """Record that the client still has ``epoch`` up to ``revision`` from an earlier connection."""

    def empty(self) -> Body | None:
        """Return a body without content; None if the codec has none."""
        return None

    def dirty_tiles(self) -> int:
        """Return the number of tiles to send to the client."""
        return 0


class Layer(ABC):
    """A named layer. ``style`` is the palette or overlay that pages use for it.

    ``columns`` are the names of the columns of its table: ``x``, ``y`` (map metres) and more, such as ``yaw``
    (radians), ``value`` or ``stamp`` (seconds).
    """

    kind: Literal["grid", "points", "path", "graph"]

    def __init__(self, name: str, title: str, style: str, columns: Sequence[str] = ()) -> None:
        self.name = name
        self.title = title
        self.style = style
        self.columns = tuple(columns)
        self.codec = CODECS[self.kind]
        self.is_watched = False  #: whether the layer is sent to any client (set on the event loop)
        self.is_on_demand = False  #: whether it is written only while it is watched

    def info(self, layer: int) -> LayerInfo:
        """Return the entry of the ``layers`` message for the layer, whose id is ``layer``."""
        return LayerInfo(layer, self.name, self.kind, self.title, self.style, list(self.columns))

    @abstractmethod
    def publish(self) -> None:
        """Publish the changes since the last call (event loop)."""

    @abstractmethod
    def cursor(self) -> Cursor:
        """Return the cursor of a client without content (event loop)."""


class WholeLayer(Layer):
    """A layer whose content is always sent in full and replaces the older content."""

    def __init__(self, name: str, title: str, style: str, columns: Sequence[str]) -> None:
        super().__init__(name, title, style, columns)
        self.number = 0  #: of the published content; 0 before the first
        self.body: tuple[int, list[bytes]] = (0, [])  #: the published content, encoded
        self._written = self.body

    def _write(self, content: Graph | NDArray[np.float32]) -> None:
        self._written = self.codec.encode(content)

    def _as_table(self, columns: ArrayLike) -> NDArray[np.float32]:
        table: NDArray[np.float32] = np.asarray(columns, dtype=np.float32)
        if table.ndim != 2 or len(table) != len(self.columns):
            raise ValueError(f"a table of shape {table.shape} does not have the columns {', '.join(self.columns)}")
        return table

    def publish(self) -> None:
        """Publish the newest content, with a new number if it differs."""
        if self._written is not self.body and self._written != self.body:
            self.number += 1
            self.body = self._written

    def cursor(self) -> WholeCursor:
        """Return the cursor of a client that has no content."""
        return WholeCursor(self)


class TableLayer(WholeLayer):
    """Points, or a path through them."""

    def __init__(
        self, name: str, title: str, style: str, columns: Sequence[str], kind: Literal["points", "path"] = "points"
    ) -> None:
        self.kind = kind
        super().__init__(name, title, style, columns)

    def set(self, columns: ArrayLike) -> None:
        """Set a table (columns, points) of numbers, NaN for no value (worker thread).

        Raises :class:`ValueError` for another number of columns than the layer's, or columns of different lengths.
        """
        self._write(self._as_table(columns))


class GraphLayer(WholeLayer):
    """Nodes, which are poses, and edges between them."""

    kind = "graph"

    def set(self, nodes: ArrayLike, edges: ArrayLike, values: ArrayLike) -> None:
        """Set ``nodes`` (columns, n) and ``edges`` (m, 2), indices of nodes (from, to), with ``values`` (m,).

        Called on the worker thread. Raises :class:`ValueError` for another number of columns than the layer's, for an
        edge to a missing node, and unless there is a value for each edge.
        """
        table = self._as_table(nodes)
        pairs = np.asarray(edges, dtype=np.int64).reshape(-1, 2)
        each = np.asarray(values, dtype=np.float32)
        if each.shape != (len(pairs),) or np.any(pairs < 0) or np.any(pairs >= table.shape[1]):
            raise ValueError(f"{len(pairs)} edges of {table.shape[1]} nodes with {each.shape} values are not a graph")
        self._write(Graph(table, pairs.astype(np.uint32), each))


class WholeCursor(Cursor):
    """Records the content that was last sent to a client."""

    def __init__(self, layer: WholeLayer) -> None:
        self._layer = layer
        self._has = 0

    def is_behind(self) -> bool:
        """Return whether there is newer content than the client was sent."""
        return self._has != self._layer.number

    def take(self, room: int, share: int, focus_xy: Point, *, always: bool) -> Body | None:  # noqa: ARG002 - undivided
        """Return the newest content if it has at most ``room`` bytes, or ``always``."""
        count, parts = self._layer.body
        if not always and sum(map(len, parts)) > room:
            return None
        self._has = self._layer.number
        return Body(self._layer.codec.kind, self._has, count, parts)
