"""The wire: what the stream's frames look like, encoded and decoded once (its twin: ``static/src/wire/protocol.ts``).

One WebSocket, ``/api/sessions/{id}/stream``, subprotocol ``gridbloom.v1``, permessage-deflate off. With ``?map=second``
it carries the picture of the second map that ``compare`` asks for, in its own epochs; commands are taken on either.

**Binary frames (server → browser)** carry tiles, little-endian::

    header  kind u8 (1 = tiles) · flags u8 (bit 0: the last frame of a complete picture) · reserved u16 · epoch u32
            · seq u32 · count u32
    tile    tx i16 · ty i16 · revision u32 · nbytes u32 · nbytes of zstd data          (count times)

A tile is 64 × 64 int8, row 0 at the smallest y; (tx, ty) counts tiles from cell (0, 0) along columns and rows. A cell's
value q is its log-odds over the range [log_odds_min, log_odds_max] that the ``geometry`` message states, spread over
−127 … +127: ``ℓ = log_odds_min + (q + 127) / 254 · (log_odds_max − log_odds_min)``; −128 is "never observed". Of the
values that stand for the cell's own state (free, unknown, occupied) it is the nearest.
``epoch`` changes when the geometry does: tiles of an older epoch are void, and tiles that are not sent are unobserved.

**Flow control.** Every binary frame has a ``seq`` (a frame with count 0 carries only a seq); the browser answers each
with ``{"type": "ack", "seq": n}``. At most two are unacknowledged (one, when acknowledgements are slow). What changes
meanwhile waits as a *set* of dirty tiles and as the newest ``frame`` message: nothing queues, so nothing grows stale.

**Text frames** are JSON objects with a ``type``. Server → browser:

``hello``       {protocol, session, kind: "world"|"log", title, epoch_id, parameters: {table, values},
                 speeds: [least, greatest], sensor: {table, values}|null, world: name, seed: n (of a world session),
                 log: {id, trajectory, trajectories: [{name, description}], n_beams, n_scans, duration_s, format,
                 notes}|null}
                first message; ``duration_s`` is the recorded time, from the earliest stamp to the latest, 0 where the
                log has no times; ``table`` is rows of mapper.core.parameter.Parameter as objects, whose ``initial``
                is what such a session begins with; ``epoch_id`` changes when the server restarts or the session is made
                anew
``geometry``    {epoch, resolution, rows, cols, origin: [x, y, yaw], log_odds_min, log_odds_max, tile: 64}
``frame``       {t, playing, speed, index, count, stamp, pose: [x, y, yaw], sensor_pose: [x, y, yaw],
                 scan_pose: [x, y, yaw], ranges: [m|null, ...], angle_min, angle_increment, bearings?, beam_width?,
                 range_max, remade_ms?, auto}
                the newest state, sent right before the binary frame of the same instant; ``t`` is the server's clock in
                seconds (monotonic, for measuring age); ``index`` of ``count`` scans are in the map; ``ranges`` are
                those of the newest scan, ``null`` for no return or no reading; ``scan_pose`` is where the sensor was
                then, ``sensor_pose`` where it is now, both T_map_laser as the robot states it, without the correction
                of the mount that the parameters hold; ``believed_pose`` and ``believed_scan_pose`` are ``pose`` and
                ``scan_pose`` as the map has them, only where the robot drifts. ``scan_pose``, ``believed_scan_pose``,
                ``ranges``, ``angle_min``, ``angle_increment``, ``bearings`` and ``range_max`` are sent only with a new
                scan: where ``ranges`` is left out all of them are as they were; ``bearings`` [rad, ...] are those of
                sonars, which are not even, and ``beam_width`` is the angle of their cones
``trajectory``  {name, every, poses: [[x, y], ...], stamps: [s, ...]}   log sessions only: the base at every scan (of
                very long logs at scans 0, ``every``, 2 · ``every``, ...), and how much of the recorded time is over
                then; sent at the start and after a change
``parameters``  {values, sensor: values|null, faults?: values, compare?: {values, with_faults, ...}|null}
                after a change by anyone, or as the answer to a refused one; ``faults`` of world sessions; ``compare``
                says what the second map has otherwise, and in a log session, where it is the side A of a comparison,
                also {trajectory, log: id|null, topic|null, title}: the poses that it is made with, and which log it is
                of where that is not the session's own
``comparison``  {index, refused: sentence|null, numbers: {cells, states, same, only: [a, b], both, entropy_bits: [a, b],
                contrast: [a, b], mean_difference, max_difference, max_at: [x, y]|null}|null}
                log sessions only: how the map of ``index`` scans, B, differs from the second one, A, as
                :class:`mapper.grid.compare.Comparison` has it; ``states[i][j]`` counts the cells in state i in A and j
                in B (free, occupied, unknown); ``refused`` says why there are no numbers; neither: nothing is compared
``world``       {name, title, names: [...], bounds: [x0, y0, x1, y1], polygons: [[[x, y], ...], ...], ids: [i, ...],
                 edits: {added: [[kind, x0, y0, x1, y1], ...], erased: [i, ...]}, polished: [[ax, ay, bx, by], ...]}
                what is solid; ``ids`` say of each polygon which solid of the world it is (from 0), or −1 − its place
                in ``added``; ``polished`` are the faces that swallow beams while the fault ``specular`` is on
``forgetting``  {cells, scans, with_clamp|null, without_clamp|null, free_with_clamp, free_without_clamp}
                after an ``edit`` with ``watch``: after ``scans`` scans these shares of the ``cells`` that held what was
                erased are free in the map with the clamp and in the one without it, and after how many scans 9 in 10
                were; ``cells`` 0: nothing is watched any more
``working``     {elapsed_s|null, fraction|null}
                something has been computed for more than 0.3 s, of which ``fraction`` is done where that is known;
                repeated four times a second; ``elapsed_s`` null: it is over
``notice``      {code, message}      something a person should know: a teleport that had to move, end of the log
``error``       {code, message, detail}   the last command was refused; everything goes on
``cell``        {row, col, epoch, x, y, observed, log_odds, p_occ, state: "free"|"unknown"|"occupied"}
                answers ``inspect``
``why``         {row, col, epoch, index, log_odds, prior, log_odds_min|null, log_odds_max|null, per_scan, total, hits,
                 first_scan|null, curve: [[n, log_odds], ...], touches: [{n, scan, stamp, beam, pose: [x, y, yaw],
                 bearing, range|null, hit, increment, log_odds}, ...]}
                answers ``why`` from the map of ``index`` scans: ``total`` beams touched the cell, ``hits`` of them
                argued for occupied; touch ``n`` (from 1) is the beam ``beam`` of scan ``scan`` (from 0), taken by a
                sensor at ``pose``, T_map_laser with the correction of the mount, ``bearing`` radians from its x axis;
                ``range`` is null for no return; ``log_odds`` is what the cell held after ``increment`` was added and
                clamped (limits null: no clamp). ``touches`` are at most 300; ``curve`` runs over all of them, at most
                600 with the least and the greatest of each stretch kept. ``per_scan``: each scan counts once
``pong``        {id, t}

Browser → server:

``ack``         {seq}
``resume``      {epoch_id, epoch, revision}   first message after a reconnect: "I have all tiles up to this revision";
                 the server then sends only newer ones when epoch_id and epoch still hold
``play`` ``pause`` ``step`` {scans?: ±n} ``speed`` {value} ``seek`` {index} ``restart``
``parameters``  {values: {name: value, ...}}
``teleport``    {x, y, yaw?}      ``drive`` {linear, angular}  (m/s, rad/s; held for 0.5 s)   ``auto`` {value: bool}
``edit``        {added: [[kind, x0, y0, x1, y1], ...], erased: [i, ...], watch?: bool}   all changes to the world as
                 it was built, in place of earlier ones: "wall"s from corner to corner and "box"es, whole centimetres;
                 ``watch`` begins a second map with the clamp the other way and counts as ``forgetting`` tells
``faults``      {values: {drift?: bool, specular?: bool}}     how the robot's faults enter the map, all of it
``compare``     {values: {name: value, ...}|null}    a second map of the same recording, of what is true, with these
                 (world sessions; what a log is compared with is set with PUT /api/sessions/{id}/compare)
``world``       {name, added?, erased?}            ``sensor`` {values: {name: value, ...}}       ``trajectory`` {name}
``inspect``     {row, col, epoch, map?: "second"}       ``why`` {row, col, epoch, until?: n, map?: "second"}   (the
                 touches up to the n-th, else the newest; of several that wait only the last is answered; with ``map``
                 about a cell of a log's second map, in its own epoch, and the answer then says so too)
``ping``        {id}

The socket is closed with 1008 (no subprotocol, too many malformed frames or too many commands), 4404 (there is no such
session), 4408 (no frame was acknowledged for a long time: connect again) or 4410 (the session has ended).
"""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

SUBPROTOCOL = "gridbloom.v1"
KIND_TILES = 1
FLAG_COMPLETE = 1
HEADER = struct.Struct("<BBHIII")
TILE_HEADER = struct.Struct("<hhII")
MAX_COMMAND_BYTES = 64 * 1024


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


def encode_text(message: dict[str, Any]) -> str:
    """Return a text frame. Numbers that JSON cannot say (NaN, infinities) are a defect of the caller and raise."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False)


def _refuse_constant(name: str) -> float:
    raise ProtocolError("command.number", f"{name} is not a JSON number.")


def decode_command(text: str | bytes) -> dict[str, Any]:
    """Return a command from the browser, an object with a ``type`` string.

    Raises :class:`ProtocolError` for anything else: binary, not JSON, NaN or Infinity, too long, no ``type``.
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
    return command


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
