"""The hub of a session, and its clients, one :class:`Client` for each browser.

There is no queue of frames. For each client the hub stores what it has of each layer, and one slot for each type of
text message; the next frames are created from the newest state when they are sent. At most two batches of binary frames
are unacknowledged, one if acknowledgements are slow, so a slow client gets fewer frames but no outdated ones.

This module does no I/O, and its clock is an argument: the route sends the bytes, and tests set the time.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable, Sequence

import msgspec
from msgspec import Struct

from server.stream.commands import MeasureCommand
from server.stream.frames import text_frame
from server.stream.layers import Body, Cursor, Layer
from server.stream.messages import FrameMessage, LayersMessage, ScanFields
from server.stream.protocol import TILES, ProtocolError, encode_text, join_frame, type_of
from server.stream.traffic import Traffic

WINDOW = 2  #: unacknowledged batches of a client that acknowledges quickly
SLOW_ACK_S = 0.150  #: acknowledgements slower than this halve the window
PRESUMED_LATENCY_S = 1.0  #: assumed latency of a new client, until its acknowledgements are quicker
HOLD_SHARE = 0.1  #: share of its latency that a slow client's next batch waits, so that it is recent when it is read
MAX_HOLD_S = 0.1
ACK_TIMEOUT_S = 30.0  #: a client without any acknowledgement for this time is disconnected
STALLED_S = 5.0  #: a client without any acknowledgement for this time is stalled: nothing is computed for it alone
FIRST_BATCH_BYTES = 16 * 1024
MIN_BATCH_BYTES = 8 * 1024
MAX_BATCH_BYTES = 256 * 1024
MAX_TEXT_FRAMES = 16  #: maximum number of text messages whose encoded frame a hub keeps until the next tick
MAX_ANSWERS = 64  #: maximum number of unsent answers and notices of one client; older ones are dropped
_FIRST_SLOTS = ("hello", "layers")  # the others are sent in the order in which they were first set
#: For messages encoded at each tick: ten times faster than Python's json. Frames and scans have no NaN.
_JSON = msgspec.json.Encoder(enc_hook=float)
_NOTHING = Body(TILES.kind, 0, 0, (), complete=False)


class Hub:
    """The newest state of one session, and its clients. Used from the event loop only."""

    def __init__(
        self,
        layers: Sequence[Layer],
        clock: Callable[[], float] = time.monotonic,
        traffic: Traffic | None = None,
        draw_on_demand: Callable[[], None] = lambda: None,
    ) -> None:
        """``draw_on_demand`` is called when a layer must be drawn that is written only while it is watched."""
        self.clock = clock
        self._draw_on_demand = draw_on_demand
        self.layers: tuple[Layer, ...] = ()
        self.clients: set[Client] = set()
        self.traffic = traffic or Traffic()
        self.slots: dict[str, str] = {}
        self.frame_number = 0  #: of the newest frame message; 0 before the first
        self.published_at = 0.0
        self.settled = True  #: whether nothing changes; the newest frame message is then valid now too
        self.scan_number = 0  #: of the newest scan; 0 before the first
        self.focus_xy = (0.0, 0.0)
        self._ids: dict[Layer, int] = {}
        self._ids_given = 0
        self._frame: FrameMessage | None = None
        self._scan: ScanFields | None = None
        self._scan_fields = ""
        self._texts: dict[bool, str] = {}  #: the frame message without and with the scan, while it is not settled
        self._text_frames: dict[str, bytes] = {}  #: frames of text messages sent since the last frame
        self.set_layers(layers)

    def join(self, *, follows: bool = False, page: str = "") -> Client:
        """Return a new client, which will receive the complete state. ``follows`` is whether it belongs to a class."""
        client = Client(self, follows=follows, page=page)
        self.clients.add(client)
        self.note_watched()
        return client

    def leave(self, client: Client) -> None:
        """Remove a client."""
        self.clients.discard(client)
        self.note_watched()

    def of_page(self, page: str) -> Client | None:
        """Return the client of the page with this name, None if there is none."""
        return next((client for client in self.clients if page and client.page == page), None)

    @property
    def has_room(self) -> bool:
        """Whether a frame may be sent to any client."""
        return any(client.has_room for client in self.clients)

    @property
    def has_acknowledged(self) -> bool:
        """Whether any client has acknowledged everything that was sent to it."""
        return any(not client.unacknowledged for client in self.clients)

    def note_watched(self) -> None:
        """Update for each layer whether it is sent to any client."""
        for number, layer in enumerate(self.layers):
            was_watched = layer.is_watched
            layer.is_watched = any(client.wants(layer.name, is_first=number == 0) for client in self.clients)
            if layer.is_on_demand and layer.is_watched and not was_watched:
                self._draw_on_demand()

    def set_layers(self, layers: Sequence[Layer]) -> None:
        """Set the layers, in this order. Raises :class:`ValueError` if two have the same name."""
        if self.layers == (*layers,) and "layers" in self.slots:
            return
        if len({layer.name for layer in layers}) < len(layers):
            raise ValueError("two layers of a session have one name")
        self.layers = (*layers,)
        ids = {layer: self._ids.get(layer) or self._new_id() for layer in layers}
        self._ids = ids
        self.set_slot(LayersMessage([layer.info(number) for layer, number in ids.items()]))
        for client in self.clients:
            client.keep_only(layers)
        self.note_watched()

    def _new_id(self) -> int:
        self._ids_given += 1
        return self._ids_given

    def id_of(self, layer: Layer) -> int:
        """Return the id under which a layer is sent."""
        return self._ids[layer]

    def set_slot(self, message: Struct) -> None:
        """Set ``message`` as the newest of its type, to send once to each client."""
        kind = type_of(message)
        self.slots[kind] = encode_text(message)
        for client in self.clients:
            client.unsent.add(kind)
            client.notify()

    def send_all(self, message: Struct) -> None:
        """Send a notice to all clients."""
        for client in self.clients:
            client.send(message)

    def publish(self, frame: FrameMessage, scan: ScanFields, focus_xy: tuple[float, float], *, settled: bool) -> None:
        """Set ``frame`` (without time and scan) as the newest frame message, and publish the changes of the layers.

        ``scan`` has the fields that are sent only if it is another object than at the client's last frame. ``focus_xy``
        is the point, map metres, whose nearest tiles are sent first.
        """
        for layer in self.layers:
            layer.publish()
        if scan is not self._scan:
            self._scan = scan
            self._scan_fields = _JSON.encode(scan).decode()[1:-1]
            self.scan_number += 1
        self._frame = frame
        self.focus_xy = focus_xy
        self.frame_number += 1
        self.published_at = self.clock()
        self.settled = settled
        self._texts.clear()
        self._text_frames.clear()
        for client in self.clients:
            if client.has_room:  # the others receive it after the next acknowledgement
                client.notify()

    def frame_text(self, *, with_scan: bool = True) -> str:
        """Return the newest frame message, with the time at which it was last valid."""
        text = None if self.settled else self._texts.get(with_scan)
        if text is None:
            assert self._frame is not None  # noqa: S101 - asked for once there is a frame message
            self._frame.t = round(self.clock() if self.settled else self.published_at, 6)
            text = _JSON.encode(self._frame).decode()
            if with_scan and self._scan_fields:
                text = f"{text[:-1]},{self._scan_fields}}}"
            if not self.settled:
                self._texts[with_scan] = text
        return text

    def text_frame(self, text: str) -> bytes:
        """Return the WebSocket frame of a text message, encoded once for all clients."""
        frame = self._text_frames.get(text)
        if frame is None:
            frame = text_frame(text)
            if len(self._text_frames) < MAX_TEXT_FRAMES:
                self._text_frames[text] = frame
        return frame


class Client:
    """One browser: what it has received, what it has not yet acknowledged, and what must be sent to it."""

    def __init__(self, hub: Hub, *, follows: bool = False, page: str = "") -> None:
        self.hub = hub
        self.follows = follows  #: whether it is a follower of a class
        self.page = page  #: the name that the page chose; empty for none
        self.selected: tuple[float, float] | None = None  #: the place marked in its 3D views, map metres
        self.measured: MeasureCommand | None = None  #: the measurement of its page; None for none
        self.wake = asyncio.Event()
        self.wake.set()
        self.on_wake: Callable[[], None] = self.wake.set  #: called when :meth:`take` may have something to return
        self.unsent: set[str] = set(hub.slots)
        self._answers: deque[str] = deque(maxlen=MAX_ANSWERS)
        self._wanted: frozenset[str] | None = None  #: names of layers; None before the first ``subscribe``
        self._cursors: dict[Layer, Cursor] = {}
        self._frame_number = 0
        self._scan_number = 0
        self._seq = 0
        self._batch = 0
        self._unacknowledged: deque[tuple[int, float]] = (
            deque()
        )  #: last number of each batch, and the time at which it was sent
        self._latency = PRESUMED_LATENCY_S  #: of acknowledgements; rises immediately, falls slowly
        self._least_latency = float("inf")
        self._batch_bytes = FIRST_BATCH_BYTES
        self._fresh_after = 0.0

    def notify(self) -> None:
        """Signal that :meth:`take` may have something to return."""
        self.on_wake()

    @property
    def is_slow(self) -> bool:
        """Whether acknowledgements are slow, or too few have arrived yet."""
        return self._latency > SLOW_ACK_S

    def send(self, message: Struct) -> None:
        """Send an answer or a notice to this client only."""
        self._answers.append(encode_text(message))
        self.notify()

    def resend(self, kind: str) -> None:
        """Send this client the newest message of a kind again."""
        self.unsent.add(kind)
        self.notify()

    def subscribe(self, names: Sequence[str]) -> None:
        """From now on, send only the layers with these names. A name takes effect when a layer has it."""
        self._wanted = frozenset(names)
        self.keep_only([layer for layer in self.hub.layers if layer.name in self._wanted])
        self.hub.note_watched()
        self.notify()

    def wants(self, name: str, *, is_first: bool) -> bool:
        """Return whether a layer of this name is sent to the client; before it subscribes, only the first one is."""
        return is_first if self._wanted is None else name in self._wanted

    def keep_only(self, layers: Sequence[Layer]) -> None:
        """Remove the cursors of all other layers."""
        self._cursors = {layer: cursor for layer, cursor in self._cursors.items() if layer in layers}

    def resume(self, name: str, epoch: int, revision: int) -> None:
        """Record that the client still has a layer's ``epoch`` up to ``revision`` from an earlier connection."""
        for layer in self.hub.layers:
            if layer.name == name:
                self._cursor(layer).resume(epoch, revision)

    def _cursor(self, layer: Layer) -> Cursor:
        cursor = self._cursors.get(layer)
        if cursor is None:
            cursor = self._cursors[layer] = layer.cursor()
        return cursor

    def _shown(self) -> list[tuple[Layer, Cursor]]:
        """Return the layers sent to the client."""
        if self._wanted is None:
            return [(layer, self._cursor(layer)) for layer in self.hub.layers[:1]]
        return [(layer, self._cursor(layer)) for layer in self.hub.layers if layer.name in self._wanted]

    def acknowledge(self, seq: int) -> None:
        """Record that the frames up to ``seq`` were painted. Raises :class:`ProtocolError` if ``seq`` was not sent."""
        if seq > self._seq or seq < 0:
            raise ProtocolError("command.seq", f"Frame {seq} was not sent; the newest is {self._seq}.")
        now = self.hub.clock()
        while self._unacknowledged and self._unacknowledged[0][0] <= seq:
            latency = now - self._unacknowledged.popleft()[1]
            self._measure(latency)
            # A client that paints at intervals has just painted. A frame created before this time would be older than a
            # whole period at its next repaint. A share of the period is reserved for uneven clocks and connections.
            self._fresh_after = now + (min(MAX_HOLD_S, HOLD_SHARE * latency) if self.is_slow else 0.0)
        if self.hub.settled or self._may_send_batch(self._shown()):
            self.notify()

    def _measure(self, latency: float) -> None:
        self._latency = max(latency, 0.7 * self._latency)
        self._least_latency = min(latency, self._least_latency * 1.02)
        # Batches get smaller if their size causes the latency; for a client that is always slow they keep their size.
        if latency > self._least_latency + 0.25:
            self._batch_bytes = max(MIN_BATCH_BYTES, self._batch_bytes // 2)
        elif latency <= self._least_latency + 0.1:
            self._batch_bytes = min(MAX_BATCH_BYTES, self._batch_bytes * 2)

    @property
    def is_lost(self) -> bool:
        """Whether the oldest unacknowledged batch is older than :data:`ACK_TIMEOUT_S`."""
        return bool(self._unacknowledged) and self.hub.clock() - self._unacknowledged[0][1] > ACK_TIMEOUT_S

    @property
    def is_stalled(self) -> bool:
        """Whether the oldest unacknowledged batch is older than :data:`STALLED_S`."""
        return bool(self._unacknowledged) and self.hub.clock() - self._unacknowledged[0][1] > STALLED_S

    @property
    def unacknowledged(self) -> int:
        """Number of sent, unacknowledged batches."""
        return len(self._unacknowledged)

    @property
    def dirty_tiles(self) -> int:
        """Number of tiles to send to the client."""
        return sum(cursor.dirty_tiles() for _, cursor in self._shown())

    def take(self) -> list[str | bytes]:
        """Return the messages to send now, in order."""
        out: list[str | bytes] = []
        if self.unsent:
            first = [kind for kind in _FIRST_SLOTS if kind in self.unsent]
            rest = [kind for kind in self.hub.slots if kind in self.unsent and kind not in first]
            out += [self.hub.slots[kind] for kind in (*first, *rest)]
            self.unsent.clear()
        shown = self._shown()
        for layer, cursor in shown:
            announcement = cursor.announcement(self.hub.id_of(layer))
            if announcement is not None:
                out.append(encode_text(announcement))
        out += self._answers
        self._answers.clear()
        if self._may_send_batch(shown):
            out += self._next_batch(shown)
        self.hub.traffic.bytes += sum(map(len, out))
        return out

    def wait_s(self) -> float:
        """Return how long, at most, to wait for :attr:`wake` before the next :meth:`take`, in seconds."""
        now = self.hub.clock()
        if self._unacknowledged:
            return max(0.0, self._unacknowledged[0][1] + ACK_TIMEOUT_S - now) + 0.01
        if self.hub.settled and self._wants_batch(self._shown()):
            # Not negative, because the time may have passed since take() was called, and nothing else would wake the
            # client.
            return max(0.0, self._fresh_after - now)
        return 3600.0

    @property
    def has_room(self) -> bool:
        """Whether another batch may be sent."""
        return len(self._unacknowledged) < (1 if self.is_slow else WINDOW)

    def _may_send_batch(self, shown: Sequence[tuple[Layer, Cursor]]) -> bool:
        hub = self.hub
        if not self.has_room:
            return False
        if (hub.clock() if hub.settled else hub.published_at) < self._fresh_after:
            return False
        return self._wants_batch(shown)

    def _wants_batch(self, shown: Sequence[tuple[Layer, Cursor]]) -> bool:
        number = self.hub.frame_number
        return number > 0 and (self._frame_number != number or any(cursor.is_behind() for _, cursor in shown))

    def _next_batch(self, shown: Sequence[tuple[Layer, Cursor]]) -> list[str | bytes]:
        hub = self.hub
        with_scan = self._scan_number != hub.scan_number
        self._scan_number = hub.scan_number
        self._frame_number = hub.frame_number
        self._batch += 1
        out: list[str | bytes] = [hub.frame_text(with_scan=with_scan)]
        # The layer that waited longest comes first and always gets something; the others share the remaining bytes.
        behind = sorted((viewer for viewer in shown if viewer[1].is_behind()), key=lambda viewer: viewer[1].batch)
        room = self._batch_bytes
        for place, (layer, cursor) in enumerate(behind):
            share = room // (len(behind) - place)
            body = cursor.take(room, share, hub.focus_xy, always=place == 0)
            if body is not None:
                cursor.batch = self._batch
                room = max(0, room - sum(map(len, body.parts)))
                out.append(self._frame(hub.id_of(layer), body))
        if len(out) == 1:
            out.append(self._empty_frame(shown))
        self._unacknowledged.append((self._seq, hub.clock()))
        return out

    def _empty_frame(self, shown: Sequence[tuple[Layer, Cursor]]) -> bytes:
        for layer, cursor in shown:
            body = cursor.empty()
            if body is not None:
                return self._frame(self.hub.id_of(layer), body)
        return self._frame(0, _NOTHING)

    def _frame(self, layer: int, body: Body) -> bytes:
        self._seq += 1
        self.hub.traffic.frames += 1
        self.hub.traffic.tiles += body.tiles
        return join_frame(body.kind, layer, body.epoch, self._seq, body.count, body.parts, complete=body.complete)
