"""Layers whose content is always sent as a whole: points, paths and graphs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from server.stream.codecs import Graph
from server.stream.layers import Body, Cursor, Layer, Point


class WholeLayer(Layer):
    """A layer whose content is always sent as a whole and replaces the older content."""

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
    """Records the content that a client was sent last."""

    def __init__(self, layer: WholeLayer) -> None:
        self._layer = layer
        self._has = 0

    def is_behind(self) -> bool:
        """Whether there is newer content than the client was sent."""
        return self._has != self._layer.number

    def take(self, room: int, share: int, focus_xy: Point, *, always: bool) -> Body | None:  # noqa: ARG002 - undivided
        """Return the newest content if it has at most ``room`` bytes, or ``always``."""
        count, parts = self._layer.body
        if not always and sum(map(len, parts)) > room:
            return None
        self._has = self._layer.number
        return Body(self._layer.codec.kind, self._has, count, parts)
