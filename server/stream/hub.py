"""Who still needs what: one :class:`Client` for each browser, all fed from one :class:`Hub` of a session.

Nothing queues. For every client the hub knows which revision of each tile it has, and holds one slot for each kind of
text message; what is sent next is decided when it is sent, from the newest state. At most two binary frames are
unacknowledged, one where acknowledgements are slow, so a slow client gets fewer frames and never stale ones.

This file does no I/O and reads no clock of its own: the route moves the bytes, and tests turn the clock.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.grid import TILE
from server.stream.protocol import ProtocolError, TilePayload, encode_text, encode_tiles
from server.stream.tiles import TilePicture

WINDOW = 2  #: unacknowledged binary frames of a client that acknowledges quickly
SLOW_ACK_S = 0.150  #: acknowledgements slower than this halve the window
PRESUMED_LATENCY_S = 1.0  #: before anything is known of a client: it has to show that it is quick
HOLD_SHARE = 0.1  #: a slow client's next frame waits this share of its latency, so that it is fresh when it is read
MAX_HOLD_S = 0.1
ACK_TIMEOUT_S = 30.0  #: a client that acknowledges nothing for so long is gone
FIRST_FRAME_BYTES = 16 * 1024
MIN_FRAME_BYTES = 8 * 1024
MAX_FRAME_BYTES = 256 * 1024
MAX_FRAME_TILES = 2048
MAX_ANSWERS = 64  #: answers and notices that wait for one client; older ones give way
SLOTS = (
    "hello",
    "geometry",
    "world",
    "parameters",
    "trajectory",
    "forgetting",
    "comparison",
    "working",
)  #: in the order in which they are sent


@dataclass(slots=True)
class Traffic:
    """What went out, for the metrics."""

    frames: int = 0
    bytes: int = 0
    tiles: int = 0


class Hub:
    """The newest state of one session, and the clients that watch it. Lives on the event loop."""

    def __init__(
        self,
        picture: TilePicture,
        clock: Callable[[], float] = time.monotonic,
        traffic: Traffic | None = None,
    ) -> None:
        self.clock = clock
        self.picture = picture
        self.clients: set[Client] = set()
        self.traffic = traffic or Traffic()
        self.slots: dict[str, str] = {"geometry": encode_text(picture.message())}
        self.frame_number = 0  #: of the newest frame message; 0 before the first
        self.published_at = 0.0
        self.settled = True  #: whether nothing moves: the newest frame message is then true now, not only at its tick
        self.scan_number = 0  #: of the newest scan; 0 before the first
        self._frame_rest = ""
        self._scan: dict[str, Any] | None = None
        self._scan_rest = ""
        self._focus_xy = (0.0, 0.0)

    def join(self) -> Client:
        """Return a new client, which is sent everything."""
        client = Client(self)
        self.clients.add(client)
        return client

    def leave(self, client: Client) -> None:
        """Forget a client."""
        self.clients.discard(client)

    def set_slot(self, message: dict[str, Any]) -> None:
        """Make ``message`` the newest of its type, to be sent to all clients once."""
        kind = message["type"]
        self.slots[kind] = encode_text(message)
        for client in self.clients:
            client.unsent.add(kind)
            client.wake.set()

    def tell_all(self, message: dict[str, Any]) -> None:
        """Send a notice to every client."""
        for client in self.clients:
            client.tell(message)

    def set_picture(self, picture: TilePicture) -> None:
        """Begin a new epoch."""
        self.picture = picture
        self.set_slot(picture.message())

    def publish(
        self, frame: dict[str, Any], scan: dict[str, Any], focus_xy: tuple[float, float], *, settled: bool
    ) -> None:
        """Make ``frame`` (without its ``t``) the newest frame message, and the picture's changes due to everyone.

        ``scan`` is the part of it that a client is sent only when it is another object than the client was sent
        last; ``focus_xy`` is the place in map metres whose tiles go first.
        """
        self.picture.publish()
        if scan is not self._scan:
            self._scan = scan
            self._scan_rest = json.dumps(scan, separators=(",", ":"), allow_nan=False)[1:-1]
            self.scan_number += 1
        self._frame_rest = json.dumps(frame, separators=(",", ":"), allow_nan=False)[1:]
        self._focus_xy = focus_xy
        self.frame_number += 1
        self.published_at = self.clock()
        self.settled = settled
        for client in self.clients:
            client.wake.set()

    def frame_text(self, *, with_scan: bool = True) -> str:
        """Return the newest frame message, with the instant at which it was last known to be true."""
        t = self.clock() if self.settled else self.published_at
        scan = f"{self._scan_rest}," if with_scan else ""
        return f'{{"type":"frame","t":{t:.6f},{scan}{self._frame_rest}'

    def nearest_first(self, dirty: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Return (n, 2) tiles (ty, tx) of the mask ``dirty``, the robot's own first, at most a frame's worth."""
        tiles = np.argwhere(dirty)
        if len(tiles) > 1:
            at = self.picture.geometry.to_lattice(np.array(self._focus_xy)) / TILE - 0.5
            away = np.square(tiles - at[::-1]).sum(axis=1)
            if len(tiles) > MAX_FRAME_TILES:
                nearest = np.argpartition(away, MAX_FRAME_TILES)[:MAX_FRAME_TILES]
                tiles, away = tiles[nearest], away[nearest]
            tiles = tiles[np.argsort(away, kind="stable")]
        return tiles


class Client:
    """One browser: what it has, what it was sent and has not yet acknowledged, and what waits for it."""

    def __init__(self, hub: Hub) -> None:
        self.hub = hub
        self.wake = asyncio.Event()
        self.wake.set()
        self.unsent: set[str] = set(hub.slots)
        self._answers: deque[str] = deque(maxlen=MAX_ANSWERS)
        self._picture: TilePicture | None = None
        self._has: NDArray[np.uint32] = np.zeros((0, 0), dtype=np.uint32)  #: revision of each tile that it was sent
        self._frame_number = 0
        self._scan_number = 0
        self._seq = 0
        self._unacknowledged: deque[tuple[int, float]] = deque()
        self._latency = PRESUMED_LATENCY_S  #: of acknowledgements: rises at once, falls slowly
        self._least_latency = float("inf")
        self._frame_bytes = FIRST_FRAME_BYTES
        self._fresh_after = 0.0

    @property
    def is_slow(self) -> bool:
        """Whether acknowledgements take long, or too few came to tell."""
        return self._latency > SLOW_ACK_S

    def tell(self, message: dict[str, Any]) -> None:
        """Send an answer or a notice to this client alone."""
        self._answers.append(encode_text(message))
        self.wake.set()

    def remind(self, kind: str) -> None:
        """Send this client the newest message of a kind again."""
        self.unsent.add(kind)
        self.wake.set()

    def resume(self, epoch: int, revision: int) -> None:
        """The client has kept all tiles of ``epoch`` up to ``revision`` from an earlier connection."""
        self._follow_epoch()
        picture = self.hub.picture
        if epoch == picture.epoch:
            known = picture.revision <= revision
            self._has[known] = picture.revision[known]

    def acknowledge(self, seq: int) -> None:
        """The client has read the binary frames up to ``seq``. Raises :class:`ProtocolError` for one not sent yet."""
        if seq > self._seq or seq < 0:
            raise ProtocolError("command.seq", f"Frame {seq} was not sent; the newest is {self._seq}.")
        now = self.hub.clock()
        while self._unacknowledged and self._unacknowledged[0][0] <= seq:
            latency = now - self._unacknowledged.popleft()[1]
            self._measure(latency)
            # Whoever looks once in a while has just looked: what was made before this instant would be older than a
            # whole period at the next look. With a share of the period to spare, clocks and lines may be uneven.
            self._fresh_after = now + (min(MAX_HOLD_S, HOLD_SHARE * latency) if self.is_slow else 0.0)
        self.wake.set()

    def _measure(self, latency: float) -> None:
        self._latency = max(latency, 0.7 * self._latency)
        self._least_latency = min(latency, self._least_latency * 1.02)
        # Frames whose size is what makes them late get smaller; a client that is late by itself keeps its size.
        if latency > self._least_latency + 0.25:
            self._frame_bytes = max(MIN_FRAME_BYTES, self._frame_bytes // 2)
        elif latency <= self._least_latency + 0.1:
            self._frame_bytes = min(MAX_FRAME_BYTES, self._frame_bytes * 2)

    @property
    def is_lost(self) -> bool:
        """Whether the oldest unacknowledged frame is so old that nobody reads any more."""
        return bool(self._unacknowledged) and self.hub.clock() - self._unacknowledged[0][1] > ACK_TIMEOUT_S

    @property
    def unacknowledged(self) -> int:
        """Binary frames that were sent and not acknowledged."""
        return len(self._unacknowledged)

    @property
    def dirty_tiles(self) -> int:
        """Tiles that the client has yet to be sent."""
        self._follow_epoch()
        return int(np.count_nonzero(self.hub.picture.revision != self._has))

    def take(self) -> list[str | bytes]:
        """Return the messages that go out now, in order; empty when nothing does."""
        out: list[str | bytes] = []
        if self.unsent:
            out += [self.hub.slots[kind] for kind in SLOTS if kind in self.unsent]
            self.unsent.clear()
        out += self._answers
        self._answers.clear()
        if self._may_send_frame():
            out += self._next_frame()
        self.hub.traffic.bytes += sum(map(len, out))
        return out

    def wait_s(self) -> float:
        """Return how long, at most, to wait for :attr:`wake` before the next :meth:`take`, in seconds."""
        now = self.hub.clock()
        if self._unacknowledged:
            return max(0.0, self._unacknowledged[0][1] + ACK_TIMEOUT_S - now) + 0.01
        if self.hub.settled and self._wants_frame():
            # Never past due: the instant may have come since take() looked, and nothing else would wake the client.
            return max(0.0, self._fresh_after - now)
        return 3600.0

    def _may_send_frame(self) -> bool:
        hub = self.hub
        if len(self._unacknowledged) >= (1 if self.is_slow else WINDOW):
            return False
        if (hub.clock() if hub.settled else hub.published_at) < self._fresh_after:
            return False
        return self._wants_frame()

    def _wants_frame(self) -> bool:
        number = self.hub.frame_number
        return number > 0 and (self._frame_number != number or self._has_dirty())

    def _has_dirty(self) -> bool:
        self._follow_epoch()
        return bool(np.any(self.hub.picture.revision != self._has))

    def _follow_epoch(self) -> None:
        if self._picture is not self.hub.picture:
            self._picture = self.hub.picture
            self._has = np.zeros_like(self._picture.revision)

    def _next_frame(self) -> list[str | bytes]:
        hub, picture = self.hub, self.hub.picture
        self._follow_epoch()
        tiles: list[TilePayload] = []
        size = 0
        waiting = hub.nearest_first(picture.revision != self._has)
        for ty, tx in waiting.tolist():
            tile = picture.payload(ty, tx)
            size += len(tile.data)
            if tiles and size > self._frame_bytes:
                break
            tiles.append(tile)
            self._has[ty, tx] = tile.revision
        complete = not self._has_dirty()
        self._seq += 1
        self._frame_number = hub.frame_number
        self._unacknowledged.append((self._seq, hub.clock()))
        hub.traffic.frames += 1
        hub.traffic.tiles += len(tiles)
        with_scan = self._scan_number != hub.scan_number
        self._scan_number = hub.scan_number
        return [hub.frame_text(with_scan=with_scan), encode_tiles(picture.epoch, self._seq, tiles, complete=complete)]
