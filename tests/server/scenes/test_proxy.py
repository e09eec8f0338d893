"""The proxy's connection to a scene is closed in the end, also where the scene does not answer any more."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

from starlette.websockets import WebSocket
from websockets.utils import accept_key

from server.scenes.proxy import SUBPROTOCOL, pass_on, take
from tests.server.service import PATIENCE_S

CLOSE = 0x88  #: the first byte of a close frame


async def test_a_proxy_that_is_cancelled_twice_leaves_no_socket_open(tmp_path: Path) -> None:
    """As at the end of the service: uvicorn cancels its tasks, then the event loop those that are still there."""
    asked_to_close, ended = asyncio.Event(), asyncio.Event()

    async def mute(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """A scene that takes the connection and then says nothing, not even that it is closed."""
        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        key = next(line.split(": ")[1] for line in head.splitlines() if line.startswith("Sec-WebSocket-Key"))
        answer = ["HTTP/1.1 101 Switching Protocols", "Upgrade: websocket", "Connection: Upgrade"]
        answer += [f"Sec-WebSocket-Accept: {accept_key(key)}", f"Sec-WebSocket-Protocol: {SUBPROTOCOL}", "", ""]
        writer.write("\r\n".join(answer).encode())
        while data := await reader.read(1024):
            if data[0] == CLOSE:
                asked_to_close.set()
        ended.set()
        writer.close()

    accepted, connected = asyncio.Event(), asyncio.Event()

    async def receive() -> dict[str, Any]:
        if not accepted.is_set():
            return {"type": "websocket.connect"}
        connected.set()
        await asyncio.Event().wait()  # the browser says nothing either
        raise AssertionError

    async def send(message: Any) -> None:
        if message["type"] == "websocket.accept":
            accepted.set()

    path = tmp_path / "scene"
    async with asyncio.timeout(PATIENCE_S), await asyncio.start_unix_server(mute, path):
        scope = {"type": "websocket", "subprotocols": [SUBPROTOCOL]}
        browser = WebSocket(scope, receive, send)
        assert await take(browser)
        proxy = asyncio.create_task(pass_on(browser, path))
        await connected.wait()
        proxy.cancel()
        await asked_to_close.wait()
        assert not proxy.done()
        proxy.cancel()
        await asyncio.gather(proxy, return_exceptions=True)
        await ended.wait()
