"""The binary frames, one codec for each encoding of a layer; :mod:`server.stream.protocol` has the format."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from mapper.grid import TILE
from server.stream.protocol import ProtocolError

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
    """Encoder and decoder of one kind of content for the body of a frame.

    ``encode`` returns the header's ``count`` and the pieces of the body, ``decode`` takes the count and the body and
    raises :class:`ProtocolError` for a body that is too short or too long.
    """

    kind: int
    encode: Callable[[C], tuple[int, list[bytes]]]
    decode: Callable[[int, bytes], C]


@dataclass(frozen=True, slots=True)
class Frame:
    """A decoded binary frame; ``content`` is what the codec of its ``kind`` returns."""

    kind: int
    layer: int
    epoch: int
    seq: int
    complete: bool
    content: Any


def _encode_tiles(tiles: Sequence[TilePayload]) -> tuple[int, list[bytes]]:
    parts = []
    for tx, ty, revision, data in tiles:
        parts += [TILE_HEADER.pack(tx, ty, revision, len(data)), data]
    return len(tiles), parts


def _decode_tiles(count: int, body: bytes) -> Sequence[TilePayload]:
    at = 0
    tiles: list[TilePayload] = []
    for _ in range(count):
        if at + TILE_HEADER.size > len(body):
            raise ProtocolError("frame.cut", f"The frame states {count} tiles and ends after {len(tiles)}.")
        tx, ty, revision, nbytes = TILE_HEADER.unpack_from(body, at)
        at += TILE_HEADER.size
        if at + nbytes > len(body):
            raise ProtocolError("frame.cut", f"Tile ({tx}, {ty}) states {nbytes} bytes; {len(body) - at} are left.")
        tiles.append(TilePayload(tx, ty, revision, body[at : at + nbytes]))
        at += nbytes
    if at != len(body):
        raise ProtocolError("frame.rest", f"{len(body) - at} bytes follow the last tile.")
    return tiles


def _encode_changes(changes: CellChanges) -> tuple[int, list[bytes]]:
    revision, tiles, places, values = changes
    return len(tiles), [
        CHANGES_HEADER.pack(revision),
        tiles.astype("<i2", copy=False).tobytes(),
        places.astype("<u2", copy=False).tobytes(),
        values.tobytes(),
    ]


def _decode_changes(count: int, body: bytes) -> CellChanges:
    _check_size(body, CHANGES_HEADER.size + 8 * count)
    (revision,) = CHANGES_HEADER.unpack_from(body)
    tiles = np.frombuffer(body, "<i2", 4 * count, CHANGES_HEADER.size).reshape(count, 4)
    at = CHANGES_HEADER.size + 8 * count
    n_cells = int(tiles[:, 2].view(np.uint16).sum(dtype=np.int64))
    _check_size(body, at, 3 * n_cells)
    places = np.frombuffer(body, "<u2", n_cells, at)
    if np.any(places >= TILE * TILE):
        raise ProtocolError("frame.cell", f"A tile has {TILE * TILE} cells.")
    return CellChanges(revision, tiles, places, np.frombuffer(body, np.int8, n_cells, at + 2 * n_cells))


def _encode_table(table: Columns) -> tuple[int, list[bytes]]:
    return table.shape[1], [TABLE_HEADER.pack(len(table), 0), table.astype("<f4", copy=False).tobytes()]


def _decode_table(count: int, body: bytes) -> Columns:
    _check_size(body, TABLE_HEADER.size)
    columns, _ = TABLE_HEADER.unpack_from(body)
    _check_size(body, TABLE_HEADER.size, 4 * columns * count)
    return np.frombuffer(body, "<f4", columns * count, TABLE_HEADER.size).reshape(columns, count)


def _encode_graph(graph: Graph) -> tuple[int, list[bytes]]:
    columns, count = graph.nodes.shape
    return count, [
        GRAPH_HEADER.pack(columns, 0, len(graph.edges)),
        graph.nodes.astype("<f4", copy=False).tobytes(),
        graph.edges.astype("<u4", copy=False).tobytes(),
        graph.values.astype("<f4", copy=False).tobytes(),
    ]


def _decode_graph(count: int, body: bytes) -> Graph:
    _check_size(body, GRAPH_HEADER.size)
    columns, _, n_edges = GRAPH_HEADER.unpack_from(body)
    _check_size(body, GRAPH_HEADER.size, 4 * columns * count + 12 * n_edges)
    at = GRAPH_HEADER.size
    nodes = np.frombuffer(body, "<f4", columns * count, at).reshape(columns, count)
    edges = np.frombuffer(body, "<u4", 2 * n_edges, at + nodes.nbytes).reshape(n_edges, 2)
    if n_edges and int(edges.max()) >= count:
        raise ProtocolError("frame.edge", f"An edge ends at node {int(edges.max())} of {count}.")
    return Graph(nodes, edges, np.frombuffer(body, "<f4", n_edges, at + nodes.nbytes + edges.nbytes))


def _check_size(body: bytes, header: int, rest: int | None = None) -> None:
    """Raise :class:`ProtocolError` unless a body has ``header`` + ``rest`` bytes, or more if ``rest`` is None."""
    if len(body) < header + (rest or 0):
        raise ProtocolError("frame.cut", f"The frame states {header + (rest or 0)} bytes and has {len(body)}.")
    if rest is not None and len(body) > header + rest:
        raise ProtocolError("frame.rest", f"{len(body) - header - rest} bytes follow the content.")


TILES: Codec[Sequence[TilePayload]] = Codec(1, _encode_tiles, _decode_tiles)
TABLE: Codec[Columns] = Codec(2, _encode_table, _decode_table)
GRAPH: Codec[Graph] = Codec(3, _encode_graph, _decode_graph)
CHANGES: Codec[CellChanges] = Codec(4, _encode_changes, _decode_changes)
#: Of whole content, by the ``kind`` of a layer.
CODECS: dict[str, Codec[Any]] = {"grid": TILES, "points": TABLE, "path": TABLE, "graph": GRAPH}
_BY_NUMBER: dict[int, Codec[Any]] = {codec.kind: codec for codec in (TILES, TABLE, GRAPH, CHANGES)}


def join_frame(
    kind: int, layer: int, epoch: int, seq: int, count: int, parts: Sequence[bytes], *, complete: bool
) -> bytes:
    """Return a binary frame made of the ``count`` and the ``parts`` of a body that a codec has encoded."""
    return b"".join((HEADER.pack(kind, FLAG_COMPLETE if complete else 0, layer, epoch, seq, count), *parts))


def encode_frame(codec: Codec[C], content: C, *, layer: int, epoch: int, seq: int, complete: bool = False) -> bytes:
    """Return the binary frame that carries ``content``."""
    count, parts = codec.encode(content)
    return join_frame(codec.kind, layer, epoch, seq, count, parts, complete=complete)


def decode_frame(frame: bytes) -> Frame:
    """Decode a binary frame. Raises :class:`ProtocolError` if it is truncated or of an unknown kind."""
    if len(frame) < HEADER.size:
        raise ProtocolError("frame.cut", f"A binary frame has at least {HEADER.size} bytes, this one {len(frame)}.")
    kind, flags, layer, epoch, seq, count = HEADER.unpack_from(frame)
    codec = _BY_NUMBER.get(kind)
    if codec is None:
        raise ProtocolError("frame.kind", f"There are no binary frames of kind {kind}.")
    return Frame(kind, layer, epoch, seq, bool(flags & FLAG_COMPLETE), codec.decode(count, frame[HEADER.size :]))
