"""An echo server on the sockets that the service uses: what the sockets alone cost.

It answers each message with a text and a binary message of the lengths in its arguments, at the next tenth of a second.
"""

from __future__ import annotations

import contextlib
import socket
import struct
import sys
import time

import uvicorn
from starlette.types import Receive, Scope, Send
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol


def application(text_bytes: int, tile_bytes: int) -> object:
    """Return the ASGI application."""
    tiles = bytes(max(0, tile_bytes - 16))

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            while (await receive())["type"] != "lifespan.shutdown":
                await send({"type": "lifespan.startup.complete"})
            await send({"type": "lifespan.shutdown.complete"})
            return
        await receive()
        await send({"type": "websocket.accept", "subprotocol": "gridbloom.v3"})
        with contextlib.suppress(Exception):
            seq = 0
            while True:
                seq += 1
                head = f'{{"type":"frame","t":{time.monotonic():.6f},"x":"'
                await send({"type": "websocket.send", "text": head + "x" * (text_bytes - len(head) - 2) + '"}'})
                frame = struct.pack("<BBHIII", 1, 1, 1, 1, seq, 0) + tiles
                await send({"type": "websocket.send", "bytes": frame})
                if (await receive())["type"] != "websocket.receive":
                    return

    return app


def main() -> None:
    """Serve on a free port of loopback, and print it."""
    bound = socket.create_server(("127.0.0.1", 0), backlog=2048)
    config = uvicorn.Config(
        application(int(sys.argv[1]), int(sys.argv[2])),  # type: ignore[arg-type]
        ws=WebSocketsSansIOProtocol,
        ws_per_message_deflate=False,
        log_config=None,
    )
    print(bound.getsockname()[1], flush=True)
    uvicorn.Server(config).run(sockets=[bound])


if __name__ == "__main__":
    main()
