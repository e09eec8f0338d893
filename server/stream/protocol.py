"""Frames of the stream between the server and a page: binary frames with layers, and text frames with JSON.

A page opens one WebSocket for each session that it shows, `/api/sessions/{id}/stream`, with the subprotocol
`gridbloom.v3` and without permessage-deflate.

## Layers

A session has a set of named layers: grids, points, paths and graphs. The `layers` message lists them, at the start and
whenever the set changes. The `subscribe` command selects layers by name; before it, the first layer is sent. A name
that is not in the list yet takes effect when a layer has it. A layer that is omitted from a later `subscribe` is sent
in full when it is selected again. The id of a layer is unique during the session.

## Binary frames

Binary frames go from the server to the browser. All numbers are little-endian.

```text
header  kind u8 (1 = tiles, 2 = table, 3 = graph, 4 = changes), flags u8 (bit 0: the layer is complete with this frame),
        layer u16 (id), epoch u32, seq u32, count u32
tiles   tx i16, ty i16, revision u32, nbytes u32, nbytes of zstd data          (count times)
table   columns u16, reserved u16, then for each column count f32
graph   columns u16, reserved u16, edges u32, then for each column count f32 (the nodes), then for each edge the indices
        of its nodes, from u32 and to u32, then for each edge a value f32
changes revision u32, then tx i16, ty i16, cells u16, reserved u16 (count times), then for each of the cells, tile after
        tile, place u16, then for each of them value i8
```

Layers of the kind `grid` are sent as tiles and changes, `points` and `path` as a table, `graph` as a graph. The names
of the columns are in the message `layers`.

A tile is 64 x 64 int8, row 0 at the smallest y; (tx, ty) counts tiles from cell (0, 0) along columns and rows. A value
q from -127 to +127 represents `low + (q + 127) / 254 * (high - low)`, with the limits of the layer's message
`geometry`; -128 means no value. In a layer of the style `belief` the values are log-odds, and -128 is a cell that was
never observed; of the values that give the cell's own state (free, unknown, occupied), q is the nearest to the cell's
log-odds. `epoch` changes with the geometry; tiles of an older epoch are ignored. Tiles that were never sent have no
values. To a browser that has all tiles, a few changed cells are sent as changes instead: `place` is the cell's row
times 64 plus its column within the tile, `value` its new value, and `revision` that of all these tiles with them.

A table or a graph is the whole content of its layer; `epoch` is the number of that content. NaN means no value.

## Flow control

Each binary frame has a number, `seq`. Frames are sent in batches: a `frame` message, and directly after it one binary
frame for each subscribed layer of which the browser does not have the newest content. If there is none, the batch has a
frame of kind 1 with count 0 instead, of the first subscribed grid (layer 0 if there is none). The browser answers with
`ack`, which names the newest binary frame that it has painted. At most two batches are unacknowledged, one if
acknowledgements take longer than 150 ms. Meanwhile the server keeps the set of changed tiles, the newest content of the
other layers and the newest `frame` message, so no frame waits in a queue. The layers of a batch share its bytes; the
layer that has waited longest comes first.

## Text frames

Text frames are JSON objects with a `type`. NaN and infinities are not allowed. A page ignores unknown fields; for an
unknown `type` or session kind it shows a request to reload the page. A command has at most 64 KiB; a malformed one is
answered with an `error` whose code is `command.` and the name of the field.

## Classes

A page of a class opens `/api/classes/{code}/stream` with the same subprotocol, a page that follows it with
`?follows=true`, also in the lecturer's browser. Only text frames go over it, those of the sections on classes below. Of
each type a follower gets the newest message; none waits in a queue. The session that the lecturer shows is watched at
`/api/classes/{code}/session`, as any other session; commands are answered with the error `class.read_only`, except
those that drive the robot from the follower to whom it was handed. The `hello` of such a connection has no `session`.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import msgspec
import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

C = TypeVar("C")

SUBPROTOCOL = "gridbloom.v3"
MAX_COMMAND_BYTES = 64 * 1024
PAGE_NAME = "^[0-9a-f]{32}$"  #: pattern of the name that a page gives itself


class ProtocolError(Exception):
    """An invalid frame or command; ``code`` is stable, the message is one sentence."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.message = message


def encode_text(message: Struct) -> str:
    """Return a text frame. Raises :class:`ValueError` for NaN and infinities, which JSON does not have."""
    return json.dumps(msgspec.to_builtins(message), separators=(",", ":"), allow_nan=False)


def fields_of(command: Struct) -> dict[str, Any]:
    """Return the fields of a command as plain data, including its ``type``, without those that are None."""
    return {name: value for name, value in msgspec.to_builtins(command).items() if value is not None}


def place_of(command: Struct) -> tuple[float, ...] | None:
    """Return the place in a command, x, y and sometimes z, metres; None for a command without x.

    Raises :class:`ProtocolError` for a command with x but without the others.
    """
    if getattr(command, "x", None) is None:
        return None
    place = []
    for name in (name for name in "xyz" if name in command.__struct_fields__):
        value = getattr(command, name)
        if value is None:
            raise ProtocolError(f"command.{name}", f'The command "{type_of(command)}" needs a "{name}" with its "x".')
        place.append(value)
    return tuple(place)


def type_of(message: Struct) -> str:
    """Return the ``type`` of a message or a command; for a command that no client sends, the name of its class."""
    return str(message.__struct_config__.tag or type(message).__name__)


# -- binary frames: one codec for each encoding of a layer -------------------------------------------------------------

FLAG_COMPLETE = 1
HEADER = struct.Struct("<BBHIII")
TILE_HEADER = struct.Struct("<hhII")
CHANGES_HEADER = struct.Struct("<I")
TABLE_HEADER = struct.Struct("<HH")
GRAPH_HEADER = struct.Struct("<HHI")

Columns = NDArray[np.float32]  #: (columns, rows of the table)


class CellChanges(NamedTuple):
    """Changes of single cells since the previous revision, by tile, shared by all clients.

    ``tiles`` (k, 4) int16: tx, ty, number of cells, 0. For each cell: ``places`` (n,) uint16, ``row · 64 + col`` within
    its tile, and ``values`` (n,) int8. After them all tiles have ``revision``.
    """

    revision: int
    tiles: NDArray[np.int16]
    places: NDArray[np.uint16]
    values: NDArray[np.int8]


class TilePayload(NamedTuple):
    """One compressed tile as sent, shared by all clients."""

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
#: For complete content, by the ``kind`` of a layer.
CODECS: dict[str, Codec[Any]] = {"grid": TILES, "points": TABLE, "path": TABLE, "graph": GRAPH}


def join_frame(
    kind: int, layer: int, epoch: int, seq: int, count: int, parts: Sequence[bytes], *, complete: bool
) -> bytes:
    """Return a binary frame from the ``count`` and the ``parts`` of a body that a codec has encoded."""
    return b"".join((HEADER.pack(kind, FLAG_COMPLETE if complete else 0, layer, epoch, seq, count), *parts))
