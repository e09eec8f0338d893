"""Viewers over real sockets: many in one event loop, so cheap that what is measured is the server.

Each looks at what has come ten times a second and acknowledges it, as a page that paints at that rate does.
"""

from __future__ import annotations

import asyncio
import json
import os
import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

PERIOD_S = 0.1  #: between two looks of a viewer
_UPGRADE = (
    "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Protocol: gridbloom.v3\r\n\r\n"
)


@dataclass(slots=True)
class Seen:
    """Figures of one viewer: the ages of the newest frame at each look, seconds, and the bytes that came."""

    ages: list[float] = field(default_factory=list)
    looks: int = 0
    bytes: int = 0
    messages: list[int] = field(default_factory=list)  #: lengths of the frames' texts and tiles


class Viewer(asyncio.Protocol):
    """One socket. It parses only what it needs of RFC 6455: the frames of a server are not masked."""

    def __init__(self, path: str, port: int, *, stalled: bool) -> None:
        self.seen = Seen()
        self.opened: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._request = _UPGRADE.format(path=path, port=port).encode()
        self._stalled = stalled
        self._buffer = bytearray()
        self._is_open = False
        self._newest: float | None = None  #: time of the newest frame message
        self._seq: int | None = None
        self._transport: asyncio.Transport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Ask for the stream."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        transport.write(self._request)

    def connection_lost(self, exc: Exception | None) -> None:
        """Fail if the stream was never opened."""
        if not self.opened.done():
            self.opened.set_exception(ConnectionError(f"the server closed the socket: {bytes(self._buffer[:300])!r}"))

    def data_received(self, data: bytes) -> None:
        """Take the messages that have come."""
        self.seen.bytes += len(data)
        buffer = self._buffer
        buffer += data
        if not self._is_open:
            end = buffer.find(b"\r\n\r\n")
            if end < 0:
                return
            if not buffer.startswith(b"HTTP/1.1 101"):
                if self._transport is not None:
                    self._transport.close()
                return
            del buffer[: end + 4]
            self._is_open = True
            self.opened.set_result(None)
            if self._stalled and self._transport is not None:
                self._transport.pause_reading()
        at = 0
        while len(buffer) - at >= 2:
            length, head = buffer[at + 1], 2
            if length == 126:
                head = 4
                length = int.from_bytes(buffer[at + 2 : at + 4]) if len(buffer) - at >= 4 else 1 << 62
            elif length == 127:
                head = 10
                length = int.from_bytes(buffer[at + 2 : at + 10]) if len(buffer) - at >= 10 else 1 << 62
            if len(buffer) - at < head + length:
                break
            self._take(buffer[at] & 15, bytes(buffer[at + head : at + head + length]))
            at += head + length
        del buffer[:at]

    def _take(self, opcode: int, message: bytes) -> None:
        if opcode == 2:
            self._seq = struct.unpack_from("<BBHIII", message)[4]
            self.seen.messages.append(len(message))
        elif opcode == 1 and message.startswith(b'{"type":"frame"'):
            self._newest = float(message[message.index(b'"t":') + 4 : message.index(b",", 16)])
            self.seen.messages.append(len(message))
        elif opcode == 9:
            self._send(10, message)

    def look(self) -> None:
        """Look at the newest frame, and acknowledge it."""
        if self._stalled:
            return
        self.seen.looks += 1
        if self._newest is not None:
            self.seen.ages.append(time.monotonic() - self._newest)
            self._newest = None
        if self._seq is not None:
            self._send(1, json.dumps({"type": "ack", "seq": self._seq}).encode())
            self._seq = None

    def _send(self, opcode: int, message: bytes) -> None:
        assert len(message) < 126
        if self._transport is not None:
            # With a key of zeros the masked message is the message.
            self._transport.write(bytes((0x80 | opcode, 0x80 | len(message))) + bytes(4) + message)

    def close(self) -> None:
        """Close the socket."""
        if self._transport is not None:
            self._transport.abort()


async def watch(
    streams: Sequence[tuple[int, str]], seconds: float, *, stalled: int, pids: Sequence[int], warm_up_s: float = 3.0
) -> tuple[list[Seen], float, float, float]:
    """Watch ``streams``, ports and paths, the last ``stalled`` of them without reading, after ``warm_up_s``.

    Return what the viewers that read saw, how long they were watched, and the processor time that the servers,
    processes ``pids``, and the viewers took meanwhile, all in seconds. Connecting hundreds of viewers takes longer than
    that.
    """
    loop = asyncio.get_running_loop()
    viewers: list[Viewer] = []
    for i, (port, path) in enumerate(streams):
        one = Viewer(path, port, stalled=i >= len(streams) - stalled)
        await loop.create_connection(lambda one=one: one, "127.0.0.1", port)  # type: ignore[misc]
        viewers.append(one)
        await one.opened
    reading = viewers[: len(viewers) - stalled]
    await _look(viewers, time.monotonic() + warm_up_s)
    for viewer in reading:
        viewer.seen = Seen()
    began, cpu, own = time.monotonic(), sum(map(cpu_seconds, pids)), time.process_time()
    await _look(viewers, began + seconds)
    lasted, cpu, own = time.monotonic() - began, sum(map(cpu_seconds, pids)) - cpu, time.process_time() - own
    for viewer in viewers:
        viewer.close()
    return [viewer.seen for viewer in reading], lasted, cpu, own


async def _look(viewers: Sequence[Viewer], until: float) -> None:
    """Let each viewer look ten times a second, evenly spread over the tenth."""
    loop = asyncio.get_running_loop()
    start = loop.time()

    async def looks(viewer: Viewer, first: float) -> None:
        due = start + first
        while due < until:
            await asyncio.sleep(max(0.0, due - loop.time()))
            viewer.look()
            due = max(due + PERIOD_S, loop.time())

    await asyncio.gather(*(looks(one, PERIOD_S * i / len(viewers)) for i, one in enumerate(viewers)))


def cpu_seconds(pid: int) -> float:
    """Return the processor time of a process and its finished children, seconds."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")
