"""The part of viser's client that the tests need: a socket, its messages, a camera, a click, a slider."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import msgspec
import numpy as np
import viser
import zstandard
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

from tests.server.service import PATIENCE_S

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, 0.0, 10.0),
    "fov": 1.0,
    "near": 0.1,
    "far": 100.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}


def unpack(frame: bytes) -> list[dict[str, Any]]:
    """The messages of one frame, each array in its place, flat, as viser's client has it."""
    size = int.from_bytes(frame[8:16], "little")
    inner = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + size], int.from_bytes(frame[:8], "little"))
    content = msgspec.msgpack.decode(inner)
    buffers, at = [], 16 + size
    for length in content["binaryBufferLengths"]:
        at += -at % 8
        buffers.append(memoryview(frame)[at : at + length])
        at += length

    def filled(value: Any) -> Any:
        if isinstance(value, dict) and "__binary_index" in value:
            return np.frombuffer(buffers[value["__binary_index"]], value["dtype"])
        if isinstance(value, dict):
            return {key: filled(one) for key, one in value.items()}
        return value

    return [filled(message) for message in content["messages"]]


class Client:
    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.seen: list[dict[str, Any]] = []
        self.received = 0  #: bytes
        self.received_at = 0.0  #: of the newest frame, seconds of :func:`time.perf_counter`

    async def send(self, **message: Any) -> None:
        await self.socket.send(msgspec.msgpack.encode(message))

    async def until(self, wanted: Any) -> dict[str, Any]:
        """The first message, seen already or still to come, of which ``wanted`` is true."""
        for message in self.seen:
            if wanted(message):
                return message
        async with asyncio.timeout(PATIENCE_S):
            while True:
                frame = await self.socket.recv()
                self.received_at = time.perf_counter()
                assert isinstance(frame, bytes)
                self.received += len(frame)
                messages = unpack(frame)
                self.seen += messages
                for message in messages:
                    if wanted(message):
                        return message

    def forget(self) -> None:
        """Begin to count again."""
        self.seen, self.received = [], 0

    def of_type(self, kind: str) -> list[dict[str, Any]]:
        """Messages of this type that were seen."""
        return [message for message in self.seen if message["type"] == kind]

    async def aimed(self) -> dict[str, Any]:
        """The message on what the camera is to look at, for the shape of its picture, which each view is sent once."""
        return await self.until(lambda m: m["type"] == "SetCameraLookAtMessage" and not m["initial"])

    async def control(self, label: str) -> dict[str, Any]:
        """The message that made the control with this label."""
        return await self.until(lambda m: "uuid" in m and m.get("props", {}).get("label") == label)


@asynccontextmanager
async def viser_client(
    port: int, session_id: str, cookies: str = "", page: str = "", is_moved: bool = False, **camera: Any
) -> AsyncIterator[Client]:
    """A browser's view, which tells its camera first: :data:`CAMERA` with the given fields, moved or not."""
    protocol = Subprotocol(f"viser-v{viser.__version__}")
    url = f"ws://127.0.0.1:{port}/scenes/{session_id}" + (f"/plain/{page}/" if page else "")
    headers = {"Cookie": cookies} if cookies else {}
    async with connect(
        url,
        subprotocols=[protocol],
        max_size=None,
        compression=None,
        additional_headers=headers,
        open_timeout=PATIENCE_S,
    ) as socket:
        client = Client(socket)
        if is_moved:
            await client.send(type="CameraMovedMessage")
        await client.send(**CAMERA | camera)
        yield client
