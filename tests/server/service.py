"""The service as its users meet it: a real uvicorn server on a free loopback port, and a client that reads its stream.

The client decodes the frames by itself, from what the protocol's text says, so that it can disagree with the server.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import msgspec
import numpy as np
from numpy.typing import NDArray
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from server.http.services import Services, services_of
from server.parts.wire import ServerMessage
from server.serving import Server, listen, make_server
from server.sessions import Kind, SessionNotFoundError
from server.settings import Settings
from server.sources import KINDS
from tests.server.stream.applied_frames import apply_frame

PATIENCE_S = 240.0  #: how long a test waits for what a machine with other work to do is slow at; only then it fails
SCAN = ("scan_pose", "ranges", "angle_min", "angle_increment", "range_max")  # of a frame message: only when new


def settings_for(folder: Path, **changes: Any) -> Settings:
    """Settings of a service that keeps its things in ``folder``."""
    options: dict[str, Any] = {"data_dir": folder, "port": 0} | changes
    return Settings(**options)


def until(condition: Callable[[], Any]) -> Any:
    """Return the first true value of ``condition``."""
    deadline, pause_s = time.monotonic() + PATIENCE_S, 0.01
    while not (found := condition()):
        assert time.monotonic() < deadline, f"waited {PATIENCE_S:g} s in vain"
        time.sleep(pause_s)
        pause_s = min(1.2 * pause_s, 0.05)  # most conditions are requests, which take the time of what is waited for
    return found


def once_read(client: httpx.Client, log_id: str) -> dict[str, Any]:
    """Return what the service says of a log that it has read, or failed to read."""
    ends = ("ready", "failed")
    return dict(until(lambda: (log := client.get(f"/api/logs/{log_id}").json())["state"] in ends and log))


async def eventually(condition: Callable[[], bool]) -> None:
    """Return once ``condition`` holds."""
    deadline, pause_s = time.monotonic() + PATIENCE_S, 0.002
    while not condition():
        assert time.monotonic() < deadline, f"waited {PATIENCE_S:g} s in vain"
        await asyncio.sleep(pause_s)
        pause_s = min(1.2 * pause_s, 0.02)


def stream_at(address: str, **more: Any) -> Any:
    """Open the stream at an address."""
    return connect(address, subprotocols=["gridbloom.v3"], compression=None, max_size=None, **more)  # type: ignore[list-item]


class Service:
    """A running service."""

    def __init__(self, server: Server, port: int) -> None:
        self.server = server
        self.port = port
        # Kept connections are given up before uvicorn closes them, after 5 s: a request may not meet that.
        limits = httpx.Limits(keepalive_expiry=2.0)
        self.http = httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE_S, limits=limits)

    @property
    def state(self) -> Services:
        """The application's services: sessions, library, settings."""
        return services_of(self.server.config.app)  # type: ignore[arg-type]

    def begin(self, **wanted: Any) -> str:
        """Start a session; return its id."""
        answer = self.http.post("/api/sessions", json=wanted or {"kind": "simulation", "world": "room", "seed": 3})
        assert answer.status_code == 201, answer.text
        return str(answer.json()["id"])

    def end_sessions(self) -> None:
        """End all sessions, whoever began them."""
        sessions = self.state.sessions
        for session in sessions.all():
            with contextlib.suppress(SessionNotFoundError):  # it has ended meanwhile
                asyncio.run_coroutine_threadsafe(sessions.close(session.id), sessions.loop).result(PATIENCE_S)

    def address(self, session: str) -> str:
        return f"ws://127.0.0.1:{self.port}/api/sessions/{session}/stream"

    def connect(self, session: str, **more: Any) -> Any:
        """Open a session's stream."""
        return stream_at(self.address(session), **more)


@contextmanager
def running(settings: Settings, kinds: Mapping[str, Kind] = KINDS) -> Iterator[Service]:
    """Run a service with sessions of these kinds in a thread until the block ends."""
    bound = listen("127.0.0.1", 0)
    server = make_server(settings, kinds)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [bound]}, name="uvicorn")
    thread.start()
    service = Service(server, bound.getsockname()[1])
    try:
        deadline = time.monotonic() + PATIENCE_S
        while not server.started and thread.is_alive() and time.monotonic() < deadline:
            time.sleep(0.01)
        assert server.started
        yield service
    finally:
        service.http.close()
        server.should_exit = True
        thread.join(PATIENCE_S)
        bound.close()
        assert not thread.is_alive()


async def until_closed(socket: ClientConnection) -> None:
    """Read until the server closes the socket."""
    async with asyncio.timeout(PATIENCE_S):
        with contextlib.suppress(ConnectionClosed):
            while True:
                await socket.recv()


class Watcher:
    """A browser without a screen: follows a grid of a stream, keeps its picture, acknowledges when told to."""

    def __init__(self, socket: ClientConnection, layer: str = "map") -> None:
        self.socket = socket
        self.layer = layer
        self._subscribed = layer == "map"  # that is sent unasked
        self.newest: dict[str, dict[str, Any]] = {}  #: the newest message of each type
        self.messages: list[dict[str, Any]] = []  #: all but frame messages
        self.frames = 0
        self.of_other_layers: dict[int, int] = {}  #: tiles by the id of the layer
        self.scans = 0  #: frame messages that brought a scan
        self.unacknowledged = 0
        self.complete = False
        self.epoch = -1
        self.geometry: dict[str, Any] = {}  #: of the grid
        self.revision = 0
        self.picture: NDArray[np.int8] = np.full((0, 0), -128, dtype=np.int8)
        self.ages: list[float] = []  #: of each frame message when it was read, in seconds

    async def read(self, patience_s: float = PATIENCE_S) -> dict[str, Any] | None:
        """Read one message; return it if it is a text."""
        if not self._subscribed:
            self._subscribed = True
            await self.send("subscribe", layers=[self.layer])
        async with asyncio.timeout(patience_s):
            data = await self.socket.recv()
        if isinstance(data, bytes):
            await self._tiles(data)
            return None
        message: dict[str, Any] = json.loads(data)
        # Every message is one of those that are stated, without a field more or less.
        stated = msgspec.json.decode(data, type=ServerMessage)
        assert json.loads(msgspec.json.encode(stated)) == message
        if message["type"] == "frame":
            # Without a new scan the frame says nothing of it: it is still the one before.
            self.scans += "ranges" in message
            message = {key: self.newest["frame"][key] for key in SCAN if key in self.newest.get("frame", ())} | message
        self.newest[message["type"]] = message
        if message["type"] == "frame":
            self.ages.append(time.monotonic() - message["t"])
        else:
            self.messages.append(message)
        if message["type"] == "geometry" and message["layer"] == self.layer_id():
            self._begin(message)
        return message

    def _begin(self, message: dict[str, Any]) -> None:
        self.geometry = message
        if message["epoch"] != self.epoch:
            self.epoch = message["epoch"]
            self.picture = np.full((message["rows"], message["cols"]), -128, dtype=np.int8)

    def layer_id(self) -> int:
        """The id of the grid, 0 before it is known."""
        layers = self.newest.get("layers", {"layers": []})["layers"]
        return next((int(one["id"]) for one in layers if one["name"] == self.layer), 0)

    async def _tiles(self, data: bytes) -> None:
        kind, flags, layer, epoch, seq, count = struct.unpack_from("<BBHIII", data)
        assert kind in (1, 4)
        if layer != self.layer_id():
            self.unacknowledged = seq
            self.of_other_layers[layer] = self.of_other_layers.get(layer, 0) + count
            return
        if epoch == self.epoch:
            self.revision = max(self.revision, apply_frame(data, self.picture)[0])
        self.frames += 1
        self.unacknowledged = seq
        self.complete = bool(flags & 1) and epoch == self.epoch

    async def acknowledge(self) -> None:
        await self.send("ack", seq=self.unacknowledged)

    async def send(self, kind: str, **more: Any) -> None:
        await self.socket.send(json.dumps({"type": kind} | more))

    async def until(self, condition: Callable[[], bool]) -> None:
        """Read and acknowledge until ``condition`` holds."""
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < deadline, f"read {PATIENCE_S:g} s in vain"
            if await self.read() is None:
                await self.acknowledge()

    async def answer(self, kind: str) -> dict[str, Any]:
        """Read and acknowledge until a message of ``kind`` comes; return it."""
        seen = len(self.messages)
        await self.until(lambda: any(m["type"] == kind for m in self.messages[seen:]))
        return next(m for m in self.messages[seen:] if m["type"] == kind)

    async def settle(self) -> None:
        """Pause, and read until the picture is all of the session's map, after everything that was asked of it."""
        await self.send("pause")
        await self.until(lambda: self.epoch >= 0)
        # Commands are carried out in their turn: the answer about a cell comes after all that was asked before. It
        # fails to come where another map has begun meanwhile.
        told = None
        while told != "cell":
            seen = len(self.messages)
            await self.send("inspect", row=0, col=0, epoch=self.epoch)
            told = await self._told(seen, ("cell", "command.epoch"))
        # What is sent after an answer is as new as the answer; the second pause sees to it that something is.
        await self.send("pause")
        self.complete = False
        await self.until(lambda: self.complete)

    async def _told(self, seen: int, kinds: tuple[str, ...]) -> str:
        """Read until one of some answers has come, or errors of some codes; return which."""

        def told() -> str | None:
            names = (m["code"] if m["type"] == "error" else m["type"] for m in self.messages[seen:])
            return next((name for name in names if name in kinds), None)

        await self.until(lambda: told() is not None)
        return told() or ""

    def log_odds(self) -> NDArray[np.float64]:
        """The picture's log-odds, NaN where never observed."""
        g = self.geometry
        low, high = g["low"], g["high"]
        value = low + (self.picture.astype(np.float64) + 127.0) / 254.0 * (high - low)
        return np.where(self.picture == -128, np.nan, value)
