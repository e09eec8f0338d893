"""A browser that draws slowly is sent no more than it draws; a program that reports nothing is sent everything."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest
from starlette.websockets import WebSocket
from websockets.asyncio.server import ServerConnection, unix_serve

from server.scenes import Scenes, proxy
from server.scenes.proxy import DRAWN, MOST_AHEAD, SCRIPT, SUBPROTOCOL, Pace, client_page, pass_on, take
from server.sessions import SessionHost
from tests.server.begin import new_simulation
from tests.server.scenes.conftest import Service
from tests.server.scenes.viser_client import CAMERA, viser_client
from tests.server.service import PATIENCE_S, eventually

MESSAGES = 60


class Browser:
    """The browser's end of the proxy: what it sends, and how many messages it was sent."""

    def __init__(self) -> None:
        self.sends: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.sends.put_nowait({"type": "websocket.connect"})
        self.received: list[bytes] = []

    def say(self, data: bytes) -> None:
        self.sends.put_nowait({"type": "websocket.receive", "bytes": data})

    async def take(self, message: Any) -> None:
        if message["type"] == "websocket.send":
            self.received.append(message["bytes"])

    async def has(self, count: int) -> None:
        await eventually(lambda: len(self.received) >= count)


@asynccontextmanager
async def proxied(path: Path) -> AsyncIterator[Browser]:
    """A browser behind the proxy of a scene that sends all its messages once the browser has told its camera."""

    async def scene(connection: ServerConnection) -> None:
        await connection.recv()
        for number in range(MESSAGES):
            await connection.send(bytes([number]))
        await connection.wait_closed()

    browser = Browser()
    scope = {"type": "websocket", "subprotocols": [SUBPROTOCOL]}
    server = await unix_serve(scene, str(path), select_subprotocol=lambda _, offered: offered[0])
    async with asyncio.timeout(PATIENCE_S), server:
        socket = WebSocket(scope, browser.sends.get, browser.take)
        assert await take(socket)
        forwarding = asyncio.create_task(pass_on(socket, path))
        yield browser
        forwarding.cancel()
        await asyncio.gather(forwarding, return_exceptions=True)


async def test_a_browser_that_reports_is_sent_as_much_as_it_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(proxy, "PATIENCE_S", 10 * PATIENCE_S)
    async with proxied(tmp_path / "scene") as browser:
        browser.say(DRAWN)
        browser.say(msgspec.msgpack.encode(CAMERA))
        for drawn in range(20):
            await browser.has(MOST_AHEAD + drawn)
            assert len(browser.received) == MOST_AHEAD + drawn
            browser.say(DRAWN)
        await browser.has(MOST_AHEAD + 20)
    assert browser.received == [bytes([number]) for number in range(MOST_AHEAD + 20)]


async def test_a_program_that_reports_nothing_is_sent_everything(tmp_path: Path) -> None:
    async with proxied(tmp_path / "scene") as browser:
        browser.say(msgspec.msgpack.encode(CAMERA))
        await browser.has(MESSAGES)


async def test_a_lost_report_stops_nothing_for_good(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(proxy, "PATIENCE_S", 0.001)
    pace = Pace()
    pace.drawn()
    async with asyncio.timeout(PATIENCE_S):
        for _ in range(3 * MOST_AHEAD):
            await pace.turn()


@pytest.mark.parametrize("plain_view", [False, True])
def test_the_script_stands_before_those_of_viser(plain_view: bool) -> None:
    page = client_page(b"ours", plain_view=plain_view).plain
    assert page.index(b"<script") == page.index(SCRIPT)
    assert page.index(b"ours") < page.index(b"<script", page.index(b"ours")) < page.index(b"data-p=")
    assert msgspec.msgpack.decode(DRAWN)["type"].encode() in SCRIPT


async def test_the_socket_is_open_before_the_scene_is_made(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    # Viser's client closes a socket that is not open after 5 s, and a scene may take longer on a busy machine.
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    may_open = asyncio.Event()
    opened = Scenes.get

    async def held(scenes: Scenes, session: SessionHost) -> Any:
        await may_open.wait()
        return await opened(scenes, session)

    monkeypatch.setattr(Scenes, "get", held)
    async with asyncio.timeout(PATIENCE_S), viser_client(service.port, session.id) as client:
        may_open.set()
        await client.control("Hit increment")
