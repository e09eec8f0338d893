"""Binary frames whole: encoded with the codecs of the service, and decoded by code of their own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from mapper.grid import TILE
from server.stream.protocol import (
    CHANGES,
    CHANGES_HEADER,
    FLAG_COMPLETE,
    GRAPH,
    GRAPH_HEADER,
    HEADER,
    TABLE,
    TABLE_HEADER,
    TILE_HEADER,
    TILES,
    CellChanges,
    Codec,
    Columns,
    Graph,
    ProtocolError,
    TilePayload,
    join_frame,
)

C = TypeVar("C")


@dataclass(frozen=True, slots=True)
class Frame:
    """A decoded binary frame; ``content`` is what the decoder of its ``kind`` returns."""

    kind: int
    layer: int
    epoch: int
    seq: int
    complete: bool
    content: Any


def encode_frame(codec: Codec[C], content: C, *, layer: int, epoch: int, seq: int, complete: bool = False) -> bytes:
    """Return the binary frame that carries ``content``."""
    count, parts = codec.encode(content)
    return join_frame(codec.kind, layer, epoch, seq, count, parts, complete=complete)


def _check_size(body: bytes, header: int, rest: int | None = None) -> None:
    """Raise :class:`ProtocolError` unless a body has ``header`` + ``rest`` bytes, or more if ``rest`` is None."""
    if len(body) < header + (rest or 0):
        raise ProtocolError("frame.cut", f"The frame states {header + (rest or 0)} bytes and has {len(body)}.")
    if rest is not None and len(body) > header + rest:
        raise ProtocolError("frame.rest", f"{len(body) - header - rest} bytes follow the content.")


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


def decode_table(count: int, body: bytes) -> Columns:
    _check_size(body, TABLE_HEADER.size)
    columns, _ = TABLE_HEADER.unpack_from(body)
    _check_size(body, TABLE_HEADER.size, 4 * columns * count)
    return np.frombuffer(body, "<f4", columns * count, TABLE_HEADER.size).reshape(columns, count)


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


_DECODERS: dict[int, Callable[[int, bytes], Any]] = {
    TILES.kind: _decode_tiles,
    TABLE.kind: decode_table,
    GRAPH.kind: _decode_graph,
    CHANGES.kind: _decode_changes,
}


def decode_frame(frame: bytes) -> Frame:
    """Decode a binary frame. Raises :class:`ProtocolError` if it is truncated or of an unknown kind."""
    if len(frame) < HEADER.size:
        raise ProtocolError("frame.cut", f"A binary frame has at least {HEADER.size} bytes, this one {len(frame)}.")
    kind, flags, layer, epoch, seq, count = HEADER.unpack_from(frame)
    decode = _DECODERS.get(kind)
    if decode is None:
        raise ProtocolError("frame.kind", f"There are no binary frames of kind {kind}.")
    return Frame(kind, layer, epoch, seq, bool(flags & FLAG_COMPLETE), decode(count, frame[HEADER.size :]))
