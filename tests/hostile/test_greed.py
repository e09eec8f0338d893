"""Visitors who request more than their share: other sessions continue, and a session can always be ended."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import Any

import pytest

from mapper.mapping.integrate import integrate_scans
from server.sessions import SessionHost
from tests.server.service import PATIENCE_S, Service, Watcher, eventually, until_closed

Undisturbed = Callable[[Service], AbstractAsyncContextManager[Watcher]]


def session_of(service: Service, session_id: str) -> SessionHost:
    session: SessionHost = service.state.sessions.get(session_id)
    return session


async def test_a_session_ends_immediately_with_any_number_of_commands(
    service: Service, undisturbed: Undisturbed, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.http.stream_connection.COMMAND_BURST", 1e9)
    session_id = await asyncio.to_thread(lambda: service.begin(kind="simulation", world="office"))
    session = session_of(service, session_id)
    async with undisturbed(service), service.connect(session_id) as socket:
        started = session.model.progress[0]
        for _ in range(200):
            await socket.send(json.dumps({"type": "step", "scans": 100}))
        watcher = Watcher(socket)
        await watcher.send("ping", id=1)
        await watcher.answer("pong")  # all of them were taken in
        await eventually(lambda: session.model.progress[0] > started + 300)
        assert (await asyncio.to_thread(service.http.delete, f"/api/sessions/{session_id}")).status_code == 204
        # 20,000 scans were asked for: all of them would have taken the session a minute.
        assert session.model.progress[0] < started + 5000


async def test_a_session_ends_in_the_middle_of_a_long_computation(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A map of fifty million readings takes a minute: neither its end nor the service's waits for it."""
    session_id = await asyncio.to_thread(lambda: service.begin(kind="log", log="sample-office"))
    session = session_of(service, session_id)
    begun, parts = threading.Event(), []

    def slow(*arguments: Any) -> Any:
        parts.append(arguments)
        begun.set()
        deadline = time.monotonic() + PATIENCE_S
        while not session.closed and time.monotonic() < deadline:
            time.sleep(0.01)
        return integrate_scans(*arguments)

    monkeypatch.setattr("mapper.replay.replay.PART_READINGS", 360)
    async with service.connect(session_id) as socket:
        monkeypatch.setattr("mapper.replay.replay.integrate_scans", slow)
        await socket.send(json.dumps({"type": "seek", "index": 600}))
        await asyncio.to_thread(begun.wait, PATIENCE_S)
        assert (await asyncio.to_thread(service.http.delete, f"/api/sessions/{session_id}")).status_code == 204
        await until_closed(socket)
        assert socket.close_code == 4410
    assert len(parts) == 1


async def test_a_long_step_is_computed_in_parts_to_its_end(service: Service) -> None:
    session_id = await asyncio.to_thread(service.begin)
    session = session_of(service, session_id)
    async with service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.settle()
        started = session.model.progress[0]
        for _ in range(10):
            await watcher.send("step", scans=95)
        await watcher.send("step", scans=50)
        counts = set()
        while session.model.progress[0] < started + 1000:
            if await watcher.read() is None:
                await watcher.acknowledge()
            counts.add(session.model.progress[0])
        await watcher.settle()
        assert watcher.newest["frame"]["index"] == started + 1000
        assert len(counts) > 3


async def test_many_questions_are_answered_once_per_tick(
    service: Service, undisturbed: Undisturbed, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only the newest "why" of each client counts: a thousand of them are not a thousand searches of the log."""
    monkeypatch.setattr("server.http.stream_connection.COMMAND_BURST", 1e9)
    session_id = await asyncio.to_thread(lambda: service.begin(kind="log", log="sample-office"))
    async with undisturbed(service), service.connect(session_id) as socket:
        watcher = Watcher(socket)
        await watcher.settle()
        for number in range(200):
            await watcher.send("why", row=number % 50, col=number, epoch=watcher.epoch)
        await watcher.until(lambda: watcher.newest.get("why", {}).get("col") == 199)
        assert len([m for m in watcher.messages if m["type"] == "why"]) < 100
