"""Frames of the stream between the server and a page: binary frames with tiles, and text frames with JSON.

A page opens one WebSocket for each map that it shows, `/api/sessions/{id}/stream`, with the subprotocol `gridbloom.v1`
and without permessage-deflate. With `?map=second` it carries the tiles of the second map, in its own epochs; commands
are accepted on either.

## Binary frames

Binary frames go from the server to the browser and carry tiles. All numbers are little-endian.

```text
header  kind u8 (1 = tiles), flags u8 (bit 0: last frame of a complete picture), reserved u16, epoch u32, seq u32,
        count u32
tile    tx i16, ty i16, revision u32, nbytes u32, nbytes of zstd data          (count times)
```

A tile is 64 x 64 int8, row 0 at the smallest y; (tx, ty) counts tiles from cell (0, 0) along columns and rows. A value
q from -127 to +127 stands for the log-odds `log_odds_min + (q + 127) / 254 * (log_odds_max - log_odds_min)`, with the
limits of the message `geometry`; -128 is a cell that was never observed. Of the values that give the cell's own state
(free, unknown, occupied), q is the nearest to the cell's log-odds.
`epoch` changes with the geometry: tiles of an older epoch are void. Tiles that were never sent are unobserved.

## Flow control

Each binary frame has a number, `seq`; a frame with count 0 carries only that number. The browser answers each with
`ack`. At most two frames are unacknowledged, one where acknowledgements take longer than 150 ms. Meanwhile the server
keeps the set of changed tiles and the newest `frame` message, so no frame waits in a queue.

## Text frames

Text frames are JSON objects with a `type`. NaN and infinities are not allowed. A page ignores fields that it does not
know; on a `type` or a session kind that it does not know it asks the person to reload the page. A command has at most
64 KiB; one that is malformed is answered with an `error` whose code is `command.` and the name of the field.
"""

from __future__ import annotations

import json
import re
import struct
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import msgspec

from server.stream.commands import Command
from server.stream.messages import ServerMessage

SUBPROTOCOL = "gridbloom.v1"
KIND_TILES = 1
FLAG_COMPLETE = 1
HEADER = struct.Struct("<BBHIII")
TILE_HEADER = struct.Struct("<hhII")
MAX_COMMAND_BYTES = 64 * 1024
_TYPE_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a string",
    "bool": "true or false",
    "array": "a list",
    "object": "an object",
    "null": "null",
    "bool | float | str": "a number, a string, or true or false",
}  #: msgspec's names of types in plain words


class ProtocolError(Exception):
    """A frame that breaks the protocol; ``code`` is stable, the message is one sentence."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.message = message


@dataclass(frozen=True, slots=True)
class TilePayload:
    """One compressed tile as it goes over the wire: shared by all who watch."""

    tx: int
    ty: int
    revision: int
    data: bytes


@dataclass(frozen=True, slots=True)
class TilesFrame:
    """A decoded binary frame."""

    epoch: int
    seq: int
    complete: bool
    tiles: tuple[TilePayload, ...]


def encode_tiles(epoch: int, seq: int, tiles: Sequence[TilePayload], *, complete: bool = False) -> bytes:
    """Return the binary frame that carries ``tiles``."""
    parts = [HEADER.pack(KIND_TILES, FLAG_COMPLETE if complete else 0, 0, epoch, seq, len(tiles))]
    for tile in tiles:
        parts.append(TILE_HEADER.pack(tile.tx, tile.ty, tile.revision, len(tile.data)))
        parts.append(tile.data)
    return b"".join(parts)


def decode_tiles(frame: bytes) -> TilesFrame:
    """Return what a binary frame says. Raises :class:`ProtocolError` for a frame that is cut or of another kind."""
    if len(frame) < HEADER.size:
        raise ProtocolError("frame.cut", f"A binary frame has at least {HEADER.size} bytes, this one {len(frame)}.")
    kind, flags, _, epoch, seq, count = HEADER.unpack_from(frame)
    if kind != KIND_TILES:
        raise ProtocolError("frame.kind", f"Binary frames are of kind {KIND_TILES}, this one is {kind}.")
    at = HEADER.size
    tiles: list[TilePayload] = []
    for _ in range(count):
        if at + TILE_HEADER.size > len(frame):
            raise ProtocolError("frame.cut", f"The frame promises {count} tiles and ends after {len(tiles)}.")
        tx, ty, revision, nbytes = TILE_HEADER.unpack_from(frame, at)
        at += TILE_HEADER.size
        if at + nbytes > len(frame):
            raise ProtocolError("frame.cut", f"Tile ({tx}, {ty}) promises {nbytes} bytes; {len(frame) - at} are left.")
        tiles.append(TilePayload(tx, ty, revision, frame[at : at + nbytes]))
        at += nbytes
    if at != len(frame):
        raise ProtocolError("frame.rest", f"{len(frame) - at} bytes follow the last tile.")
    return TilesFrame(epoch, seq, bool(flags & FLAG_COMPLETE), tuple(tiles))


def encode_text(message: ServerMessage | dict[str, Any]) -> str:
    """Return a text frame. Raises :class:`ValueError` for NaN and infinities, which JSON does not have."""
    plain = msgspec.to_builtins(message) if isinstance(message, msgspec.Struct) else message
    return json.dumps(plain, separators=(",", ":"), allow_nan=False)


def _refuse_constant(name: str) -> float:
    raise ProtocolError("command.number", f"{name} is not a JSON number.")


def decode_command(text: str | bytes) -> dict[str, Any]:
    """Return a command from the browser as an object, which :mod:`server.stream.commands` states.

    Raises :class:`ProtocolError` for anything else: binary, not JSON, NaN or Infinity, too long, no ``type`` or an
    unknown one, a field that is missing or of another type.
    """
    if isinstance(text, bytes):
        raise ProtocolError("command.binary", "Commands are text frames, not binary ones.")
    if len(text) > MAX_COMMAND_BYTES:
        raise ProtocolError("command.too_long", f"A command has at most {MAX_COMMAND_BYTES} characters.")
    try:
        command = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise ProtocolError("command.json", "A command is one JSON object; this is not JSON.") from error
    if not isinstance(command, dict) or not isinstance(command.get("type"), str):
        raise ProtocolError("command.type", 'A command is a JSON object with a "type".')
    try:
        msgspec.convert(command, Command)
    except msgspec.ValidationError as error:
        # What is wrong with one of the values is said by the table of parameters, which names it.
        if " - at `$.values[" not in str(error):
            raise _refused(command["type"], str(error)) from error
    except UnicodeEncodeError as error:
        raise ProtocolError("command.json", "A command has a surrogate without its pair, which is no text.") from error
    return command


def _refused(kind: str, told: str) -> ProtocolError:
    """Return the error for a command of type ``kind`` of which msgspec has ``told`` what is wrong."""
    what, _, path = told.partition(" - at `$.")
    if path == "type`":
        return ProtocolError("command.unknown", f"There is no command {kind!r:.80}.")
    missing = re.fullmatch(r"Object missing required field `(\w+)`", what)
    if missing is not None:
        return ProtocolError(f"command.{missing[1]}", f'The command "{kind}" needs a "{missing[1]}".')
    for name, words in _TYPE_WORDS.items():
        what = what.replace(f"`{name}`", words)
    path = path.removesuffix("`").replace("[...]", "")
    name = path.partition("[")[0]
    return ProtocolError(f"command.{name}", f'"{path}" of the command "{kind}" is wrong: {what}.')


def number(command: dict[str, Any], key: str, default: float | None = None) -> float:
    """Return a finite number of a command; raise :class:`ProtocolError` naming the key where there is none."""
    value = command.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise ProtocolError(f"command.{key}", f'"{key}" must be a finite number, not {value!r:.80}.')
    return float(value)


def integer(command: dict[str, Any], key: str, default: int | None = None) -> int:
    """Return a whole number of a command; raise :class:`ProtocolError` naming the key where there is none."""
    value = command.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or abs(value) > 2**53:
        raise ProtocolError(f"command.{key}", f'"{key}" must be a whole number, not {value!r:.80}.')
    return value


def values(command: dict[str, Any]) -> dict[str, Any]:
    """Return the ``values`` of a command, an object; raise :class:`ProtocolError` for anything else."""
    found = command.get("values")
    if not isinstance(found, dict):
        raise ProtocolError("command.values", '"values" must be an object of names and values.')
    return found


def text(command: dict[str, Any], key: str) -> str:
    """Return a string of a command; raise :class:`ProtocolError` naming the key where there is none."""
    value = command.get(key)
    if not isinstance(value, str):
        raise ProtocolError(f"command.{key}", f'"{key}" must be a string, not {value!r:.80}.')
    return value
