"""How many requests of a visitor are answered at once and each second, and that nobody else waits for them."""

from __future__ import annotations

import time
from typing import Any

import pytest
from starlette.types import Message, Receive, Scope, Send

from server.http import brake
from server.http.brake import RequestPace


async def answer(scope: Scope, receive: Receive, send: Send) -> None:
    await send({"type": "http.response.start", "status": 204, "headers": []})
    await send({"type": "http.response.body", "body": b""})


async def status(app: RequestPace, visitor: str, address: str = "192.0.2.1") -> tuple[int, dict[bytes, bytes]]:
    starts: list[Message] = []

    async def send(message: Message) -> None:
        if message["type"] == "http.response.start":
            starts.append(message)

    async def receive() -> Message:
        return {"type": "http.request", "body": b"", "more_body": False}

    scope: dict[str, Any] = {"type": "http", "method": "GET", "path": "/", "headers": []}
    await app(scope | {"client": (address, 1), "state": {"visitor": visitor}}, receive, send)
    return starts[0]["status"], dict(starts[0]["headers"])


async def test_beyond_the_burst_requests_wait_and_then_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []

    async def sleep(seconds: float) -> None:
        waits.append(seconds)

    monkeypatch.setattr(brake, "VISITOR_BURST", 5.0)
    monkeypatch.setattr(brake, "VISITOR_PER_S", 0.01)
    monkeypatch.setattr(brake, "MAX_WAIT_S", 350.0)
    monkeypatch.setattr("server.http.brake.asyncio.sleep", sleep)
    app, began = RequestPace(answer), time.monotonic()
    assert [(await status(app, "greedy"))[0] for _ in range(9)] == [204] * 8 + [429]
    passed = time.monotonic() - began
    for number, wait in enumerate(waits, start=1):  # one token comes every 100 s
        assert 100.0 * number - passed <= wait <= 100.0 * number
    assert len(waits) == 3
    _, headers = await status(app, "greedy")
    assert 400.0 - (time.monotonic() - began) <= int(headers[b"retry-after"]) <= 400
    assert [(await status(app, "quiet"))[0] for _ in range(5)] == [204] * 5
    assert len(waits) == 3


async def test_a_visitor_without_a_cookie_is_one_of_a_network(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(brake, "NETWORK_BURST", 5.0)
    monkeypatch.setattr(brake, "NETWORK_PER_S", 0.01)
    app = RequestPace(answer)
    first = [(await status(app, f"visitor {n}", f"2001:db8::{n}"))[0] for n in range(7)]
    assert first == [204] * 5 + [429] * 2
    assert (await status(app, "visitor 8", "2001:db8:0:1::1"))[0] == 204


async def test_who_is_remembered_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(brake, "MAX_KNOWN", 4)
    monkeypatch.setattr(brake, "VISITOR_BURST", 1.0)
    monkeypatch.setattr(brake, "VISITOR_PER_S", 0.01)
    app = RequestPace(answer)
    assert (await status(app, "first"))[0] == 204
    assert (await status(app, "first"))[0] == 429
    for n in range(4):
        assert (await status(app, f"other {n}"))[0] == 204
    assert (await status(app, "first"))[0] == 204, "forgotten, as others came since"
