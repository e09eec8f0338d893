"""The scene reads a session between ticks only."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from server.scenes.state import read_state
from server.sessions.view import SessionView
from tests.server.begin import new_simulation
from tests.server.scenes.conftest import Service
from tests.server.service import eventually


class GuardedArray:
    """An array that notes each read during a tick."""

    def __init__(self, values: np.ndarray, guard: Guard) -> None:
        self._values, self._guard = values, guard

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        self._guard.note("array")
        return self._values


class Guard:
    """Notes what is read while a tick computes."""

    def __init__(self) -> None:
        self.computing = False
        self.reads: list[str] = []
        self.early: list[str] = []

    def note(self, what: str) -> None:
        self.reads.append(what)
        if self.computing:
            self.early.append(what)


async def test_nothing_is_read_while_a_tick_computes(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    session.model.playback.playing = False
    scene = await service.scenes.get(session)
    guard, view = Guard(), session.model.view

    def guarded_view() -> SessionView:
        guard.note("view")
        seen: SessionView = view()
        return replace(
            seen,
            log_odds=cast("Any", GuardedArray(seen.log_odds, guard)),
            observed=cast("Any", GuardedArray(seen.observed, guard)),
        )

    monkeypatch.setattr(session.model, "view", guarded_view)
    async with session.still():
        guard.computing = True
        scene.enter()  # which asks for a drawing with the map
        waiting = cast("Any", session)._lock
        await eventually(lambda: bool(guard.early or waiting._waiters))
        scene._clicked(cast("Any", SimpleNamespace(ray_origin=(1.0, 1.0, 3.0), ray_direction=(0.0, 0.0, -1.0))))
        assert guard.early == []
        guard.computing = False
    await eventually(lambda: guard.reads.count("array") >= 2)
    assert guard.early == []
    scene.leave()


async def test_a_later_tick_does_not_change_what_was_read(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    session.model.playback.playing = False
    state = await read_state(session, with_map=True)
    assert state.picture is not None
    before = state.picture.floor.copy(), state.beams.copy()
    async with session.still():
        session.model.grid.log_odds += 1.0
        session.model.grid.observed[:] = True
        session.model.view().ranges[:] = 0.5
    np.testing.assert_array_equal(state.picture.floor, before[0])
    np.testing.assert_array_equal(state.beams, before[1])
    assert (await read_state(session, with_map=False)).picture is None
