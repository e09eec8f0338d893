"""The response of a download: wait for a slot, produce and send the file in pieces, stop if the client disconnects.

There are time limits for a slow client: for each piece, and for all of them together.
"""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine, Iterator
from typing import Any

import structlog
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from server.downloads.download_slots import Requester
from server.downloads.downloads import Content, Downloads, Make
from server.downloads.names import disposition

STALLED_S = 30.0  #: time in which a client must accept a piece
LEAST_BYTES_PER_S = 32 << 10  #: average over the whole download
PIECE_BYTES = 1 << 18  #: size of a piece that is sent
_log = structlog.get_logger(__name__)


class ClientPace:
    """The data that the client of one download has accepted, and the time that this took.

    Only the time of sending counts, not that of creating the file. A client may be ``STALLED_S`` behind the least
    average rate, for example after a short disconnection, or if its network buffers much.
    """

    def __init__(self) -> None:
        self._bytes, self._seconds = 0, 0.0

    @property
    def seconds_left(self) -> float:
        """Return the time in which the client must accept the next piece."""
        allowed = STALLED_S + self._bytes / LEAST_BYTES_PER_S
        return min(STALLED_S, max(0.0, allowed - self._seconds))

    @property
    def figures(self) -> dict[str, float]:
        """Return the figures for the log."""
        return {"bytes": self._bytes, "seconds": round(self._seconds, 1)}

    def accept(self, nbytes: int, seconds: float) -> None:
        """Record that the client has accepted a piece in this time."""
        self._bytes += nbytes
        self._seconds += seconds


class Download(Response):
    """A file that is created once the download holds a slot, and sent as it is created.

    Errors before the first byte, including :class:`server.downloads.BusyError`, are answered as JSON errors.
    """

    def __init__(self, downloads: Downloads, who: Requester, make: Make, media_type: str) -> None:
        self.status_code, self.media_type, self.background = 200, media_type, None
        self.init_headers({"Cache-Control": "no-store"})
        self._downloads, self._who, self._make = downloads, who, make

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:  # noqa: ARG002 - ASGI
        """Answer a request."""
        await _while_connected(receive, self._answer(send))

    async def _answer(self, send: Send) -> None:
        async with self._downloads.slots.hold(self._who):
            content = await self._make()
            try:
                await self._send(content, send)
            finally:
                content.close()

    async def _send(self, content: Content, send: Send) -> None:
        self.headers["Content-Disposition"] = disposition(content.name)
        if content.nbytes is not None:
            self.headers["Content-Length"] = str(content.nbytes)
        # If the first piece fails, an error can still be answered.
        piece = await self._downloads.run(lambda _: _next(content.pieces))
        await send({"type": "http.response.start", "status": self.status_code, "headers": self.raw_headers})
        pace, clock = ClientPace(), asyncio.get_running_loop().time
        while piece:
            try:
                # A file that is created in one piece, such as a mesh, would have to be accepted in the time of one
                # piece.
                for start in range(0, len(piece), PIECE_BYTES):
                    part, began = piece[start : start + PIECE_BYTES], clock()
                    async with asyncio.timeout(pace.seconds_left):
                        await send({"type": "http.response.body", "body": part, "more_body": True})
                    pace.accept(len(part), clock() - began)
            except TimeoutError:
                _log.info("a download was ended: its client stalled or is too slow", **pace.figures)
                return  # uvicorn then closes the connection, so that the client sees that the file is incomplete
            piece = await self._downloads.run(lambda _: _next(content.pieces))
        await send({"type": "http.response.body", "body": b"", "more_body": False})


def _next(pieces: Iterator[bytes]) -> bytes:
    """Return the next pieces, until there are enough to send; empty at the end."""
    data = bytearray()
    for piece in pieces:
        data += piece
        if len(data) >= PIECE_BYTES:
            break
    return bytes(data)


async def _while_connected(receive: Receive, answering: Coroutine[Any, Any, None]) -> None:
    """Await ``answering``; cancel it once the client has disconnected."""
    answer = asyncio.ensure_future(answering)
    gone = asyncio.ensure_future(_disconnected(receive))
    try:
        await asyncio.wait({answer, gone}, return_when=asyncio.FIRST_COMPLETED)
        if answer.done():
            answer.result()
    finally:
        for task in (answer, gone):
            task.cancel()
        await asyncio.gather(answer, gone, return_exceptions=True)


async def _disconnected(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
