"""A viser server that listens on a Unix socket and offers nothing but the scene's WebSocket.

viser 1.1 can only listen on a TCP port. A TCP port of 127.0.0.1 is reachable by any process of the machine and by any
page in a browser, without the service's token and checks. Here viser's call of :func:`websockets.asyncio.server.serve`
is replaced, in viser's module only, by one that listens on a Unix socket in a folder of mode 0700. The class of its
message buffers is replaced by one that limits the size of what is sent at once.
"""

from __future__ import annotations

import asyncio
import os
import socket
import tempfile
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Iterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, is_dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import rich
import viser
import websockets.asyncio.server
import websockets.datastructures
import websockets.exceptions
import zstandard
from viser import _assignable_props_api as _props
from viser import _messages as viser_messages
from viser.infra import Message, _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer
from websockets.asyncio.server import Server, ServerConnection, unix_serve

from server.process_folder import process_folder
from server.scenes.visitors import PAGE_HEADER, VISITOR_HEADER, Viewer, viewer_of_connection


@dataclass
class CameraMovedMessage(viser_messages.Message, include_in_scene_serialization=False):
    """Our own message from a browser: a user has moved the camera whose pose is in the next message."""


MAX_TOGETHER = 4 << 20  #: maximum bytes of messages sent at once; a larger message is sent alone


def size_of(value: Any) -> int:  # noqa: ANN401 - any field of a message
    """Return the bytes of the arrays and byte strings in a message or one of its fields."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, bytes):
        return len(value)
    if isinstance(value, dict):
        return sum(size_of(value_) for value_ in value.values())
    if isinstance(value, Message) or is_dataclass(value):
        return sum(size_of(part) for part in vars(value).values())
    return 0


def parts_of(window: Sequence[Message]) -> Iterator[Sequence[Message]]:
    """Yield the messages in order, in parts of at most :data:`MAX_TOGETHER` bytes or of one message."""
    part: list[Message] = []
    size = 0
    for message in window:
        more = size_of(message)
        if part and size + more > MAX_TOGETHER:
            yield part
            part, size = [], 0
        part.append(message)
        size += more
    if part:
        yield part


class MessageBuffer(AsyncMessageBuffer):
    """viser's buffer of outgoing messages, with its windows divided by :func:`parts_of`.

    viser sends up to 128 messages of any size in one WebSocket message, and the whole scene to a new browser.
    """

    async def _window_loop(
        self, client_id: int, backlog_last_id: int, backlog_done_message: Message | None
    ) -> AsyncGenerator[Sequence[Message], None]:
        windows = super()._window_loop(client_id, backlog_last_id, backlog_done_message)
        try:
            async for window in windows:
                for part in parts_of(window):
                    yield part
        finally:
            await windows.aclose()


ZSTD_LEVEL = 6  #: for messages to browsers,
QUICK_LEVEL = 2  #: and for more than this many bytes at once: a fifth of the time and 1.1 × the bytes
QUICK_BYTES = 1 << 18
ROUNDS_OF_ACCEPT = 5  #: least number of loop rounds from accepting a connection to its handler


@asynccontextmanager
async def _serve(
    handler: Callable[[ServerConnection], Awaitable[None]],
    host: str,
    port: int,
    **options: Any,  # noqa: ANN401 - passed on
) -> AsyncIterator[Server]:
    """Replacement of ``websockets.asyncio.server.serve``: listen on the bound socket whose descriptor is ``host``."""
    del port
    options["process_request"] = None  # viser's own would serve files over HTTP
    options["ping_interval"] = None  # both ends are in one process, and the proxy does not read while a browser is slow
    bound = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM, fileno=int(host))

    async def of_viewer(connection: ServerConnection) -> None:
        if connection.request is not None:
            headers = connection.request.headers
            viewer_of_connection.set(Viewer(headers.get(VISITOR_HEADER, ""), headers.get(PAGE_HEADER, "")))
        await handler(connection)

    server = await unix_serve(of_viewer, sock=bound, **options)
    try:
        yield server
    finally:
        # If asyncio accepts a connection in the loop round in which the server is closed, it forgets the connection and
        # leaves its socket open (Server._attach refuses it). So accepting is stopped before that.
        asyncio.get_running_loop().remove_reader(bound)
        for _ in range(ROUNDS_OF_ACCEPT):
            await asyncio.sleep(0)
        server.close()
        await server.wait_closed()


class Compressor:
    """Replacement of ``zstandard.ZstdCompressor``, because viser's level 1 makes voxel files a quarter larger."""

    def __init__(self, level: int) -> None:
        del level
        self._small, self._large = (zstandard.ZstdCompressor(level=level) for level in (ZSTD_LEVEL, QUICK_LEVEL))

    def compress(self, data: bytes) -> bytes:
        """Return ``data`` as one frame."""
        return (self._large if len(data) > QUICK_BYTES else self._small).compress(data)


# viser determines the types of a node's fields again for each node, which takes half of the time per node.
_props.get_type_hints = cache(_props.get_type_hints)  # type: ignore[assignment,attr-defined]
_infra.zstandard = SimpleNamespace(ZstdCompressor=Compressor)  # type: ignore[assignment,attr-defined]
_infra.AsyncMessageBuffer = MessageBuffer  # type: ignore[attr-defined]
_infra.websockets = SimpleNamespace(  # type: ignore[assignment,attr-defined] # a stand-in for the module
    asyncio=SimpleNamespace(server=SimpleNamespace(serve=_serve, ServerConnection=ServerConnection)),
    datastructures=websockets.datastructures,
    exceptions=websockets.exceptions,
)


class ViserServer(viser.ViserServer):
    """A viser server on the Unix socket ``path``, which only this user's processes can open.

    Raises :class:`OSError` if the socket cannot be created.
    """

    def __init__(self) -> None:
        # viser prints a banner at every start and "Server stopped" at every end through rich's global console.
        rich.get_console().quiet = True
        self._folder = tempfile.TemporaryDirectory(dir=process_folder())
        self.path = Path(self._folder.name) / "viser"
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as bound:
            bound.bind(str(self.path))  # here, because viser would retry without end
            descriptor = os.dup(bound.fileno())
        super().__init__(host=str(descriptor), port=0, label="Gridbloom", verbose=False)

    @property
    def queued(self) -> int:
        """Number of messages queued for all browsers since the start."""
        return self._websock_server.get_message_buffer().message_counter

    def on_camera_moved(self, callback: Callable[[int], None]) -> None:
        """Register ``callback``, called with the number of each client whose camera a user has moved (viser's loop)."""
        self._websock_server.register_handler(CameraMovedMessage, lambda client_id, _: callback(client_id))

    def request_share_url(self, verbose: bool = True) -> None:
        """Do nothing: no public tunnel is opened."""

    def stop(self) -> None:
        """End viser's threads, close the socket and remove its folder."""
        super().stop()
        self._folder.cleanup()
