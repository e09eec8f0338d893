"""A registry on the test's own event loop, with a budget that a test may shrink."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import pytest

from server.parts.wire import command_of
from server.sessions import SessionHost, SessionRegistry
from tests.server.begin import between_ticks
from tests.server.service import eventually, settings_for


@pytest.fixture
async def make_registry(tmp_path: Path) -> AsyncIterator[Callable[..., SessionRegistry]]:
    """A function that returns a registry with the given settings."""
    made: list[SessionRegistry] = []

    def make(**changes: Any) -> SessionRegistry:
        clock = changes.pop("clock", None)
        more = {} if clock is None else {"clock": clock}
        made.append(SessionRegistry(settings_for(tmp_path, **changes), **more))
        return made[-1]

    yield make
    for registry in made:
        await registry.shutdown()


@pytest.fixture
def registry(make_registry: Callable[..., SessionRegistry]) -> SessionRegistry:
    """A registry with the default budget."""
    return make_registry()


@pytest.fixture
def one_tick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands sent to a session together are carried out in one tick, however slow the machine is."""
    monkeypatch.setattr("server.sessions.computation.COMMANDS_S", float("inf"))


async def obeyed(session: SessionHost, **command: Any) -> None:
    """Give a command and wait until it was carried out."""
    session.enqueue(command_of(command))
    await eventually(lambda: not session.has_queued_commands)
    await between_ticks(session)  # the tick that took it is over


@pytest.fixture
def obey() -> Callable[..., Any]:
    """A function that gives a session a command and waits until it was carried out."""
    return obeyed
