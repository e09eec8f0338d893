"""The binary frames, one codec for each encoding of a layer; :mod:`server.stream.protocol` has the format."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

FLAG_COMPLETE = 1
HEADER = struct.Struct("<BBHIII")
TILE_HEADER = struct.Struct("<hhII")
CHANGES_HEADER = struct.Struct("<I")
TABLE_HEADER = struct.Struct("<HH")
GRAPH_HEADER = struct.Struct("<HHI")

Columns = NDArray[np.float32]  #: (columns, rows of the table)

C = TypeVar("C")


class CellChanges(NamedTuple):
    """Changes of single cells of the preceding revision, by tile, shared by all clients.

    ``tiles`` (k, 4) int16: tx, ty, number of cells, 0; of each cell ``places`` (n,) uint16, ``row · 64 + col`` within
    its tile, and ``values`` (n,) int8. All tiles have ``revision`` with them.
    """

    revision: int
    tiles: NDArray[np.int16]
    places: NDArray[np.uint16]
    values: NDArray[np.int8]


class TilePayload(NamedTuple):
    """One compressed tile as it is sent, shared by all clients."""

    tx: int
    ty: int
    revision: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Graph:
    """Nodes (columns, n) float32, edges (m, 2) uint32 as indices of nodes (from, to), and a value of each edge (m,)
    float32.
    """

    nodes: Columns
    edges: NDArray[np.uint32]
    values: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Codec(Generic[C]):
    """Encoder of one kind of content for the body of a frame.

    ``encode`` returns the header's ``count`` and the pieces of the body.
    """

    kind: int
    encode: Callable[[C], tuple[int, list[bytes]]]


def _encode_tiles(tiles: Sequence[TilePayload]) -> tuple[int, list[bytes]]:
    parts = []
    for tx, ty, revision, data in tiles:
        parts += [TILE_HEADER.pack(tx, ty, revision, len(data)), data]
    return len(tiles), parts


def _encode_changes(changes: CellChanges) -> tuple[int, list[bytes]]:
    revision, tiles, places, values = changes
    return len(tiles), [
        CHANGES_HEADER.pack(revision),
        tiles.astype("<i2", copy=False).tobytes(),
        places.astype("<u2", copy=False).tobytes(),
        values.tobytes(),
    ]


def _encode_table(table: Columns) -> tuple[int, list[bytes]]:
    return table.shape[1], [TABLE_HEADER.pack(len(table), 0), table.astype("<f4", copy=False).tobytes()]


def _encode_graph(graph: Graph) -> tuple[int, list[bytes]]:
    columns, count = graph.nodes.shape
    return count, [
        GRAPH_HEADER.pack(columns, 0, len(graph.edges)),
        graph.nodes.astype("<f4", copy=False).tobytes(),
        graph.edges.astype("<u4", copy=False).tobytes(),
        graph.values.astype("<f4", copy=False).tobytes(),
    ]


TILES: Codec[Sequence[TilePayload]] = Codec(1, _encode_tiles)
TABLE: Codec[Columns] = Codec(2, _encode_table)
GRAPH: Codec[Graph] = Codec(3, _encode_graph)
CHANGES: Codec[CellChanges] = Codec(4, _encode_changes)
#: Of whole content, by the ``kind`` of a layer.
CODECS: dict[str, Codec[Any]] = {"grid": TILES, "points": TABLE, "path": TABLE, "graph": GRAPH}


def join_frame(
    kind: int, layer: int, epoch: int, seq: int, count: int, parts: Sequence[bytes], *, complete: bool
) -> bytes:
    """Return a binary frame made of the ``count`` and the ``parts`` of a body that a codec has encoded."""
    return b"".join((HEADER.pack(kind, FLAG_COMPLETE if complete else 0, layer, epoch, seq, count), *parts))
