"""The scene reads a session between ticks only."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from server.scenes.drawers import DRAWERS
from server.scenes.drawers.grid_columns import GridContent
from server.scenes.reading import SceneState, read_state
from server.sessions.drawings import Drawing, GridColumns, RobotBody
from tests.server.begin import new_simulation
from tests.server.scenes.conftest import Service
from tests.server.service import eventually
from tests.server.view import view_of


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
    guard, drawings = Guard(), session.model.drawings

    def guarded_drawings() -> list[Drawing]:
        guard.note("drawings")
        return [
            replace(
                one,
                log_odds=cast("Any", GuardedArray(one.log_odds, guard)),
                observed=cast("Any", GuardedArray(one.observed, guard)),
            )
            if isinstance(one, GridColumns)
            else one
            for one in drawings()
        ]

    monkeypatch.setattr(session.model, "drawings", guarded_drawings)
    async with session.locked():
        guard.computing = True
        scene.enter()  # which asks for a drawing with the map
        waiting = cast("Any", session)._lock
        await eventually(lambda: bool(guard.early or waiting._waiters))
        click = SimpleNamespace(client_id=1, ray_origin=(1.0, 1.0, 3.0), ray_direction=(0.0, 0.0, -1.0))
        scene._clicked(cast("Any", click))
        assert guard.early == []
        guard.computing = False
    await eventually(lambda: guard.reads.count("array") >= 2)
    assert guard.early == []
    scene.leave()


def contents(state: SceneState, kind: type[Drawing]) -> Any:
    (content,) = (one.content for one in state.readings if isinstance(one.drawing, kind))
    return content


async def test_a_later_tick_does_not_change_what_was_read(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    session.model.playback.playing = False
    state = await read_state(session, DRAWERS, lambda _: True)
    grid, robot = contents(state, GridColumns), contents(state, RobotBody)
    assert isinstance(grid, GridContent)
    before = grid.levels.floor.copy(), robot.beams.copy()
    async with session.locked():
        session.model.grid.log_odds += 1.0
        session.model.grid.observed[:] = True
        view_of(session).ranges[:] = 0.5
    np.testing.assert_array_equal(grid.levels.floor, before[0])
    np.testing.assert_array_equal(robot.beams, before[1])


async def test_drawings_that_are_not_due_are_not_read(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    state = await read_state(session, DRAWERS, lambda drawing: not isinstance(drawing, GridColumns))
    assert contents(state, GridColumns) is None
    assert contents(state, RobotBody) is not None


async def test_two_drawings_of_one_name_are_a_defect(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    twice = 2 * session.model.drawings()
    monkeypatch.setattr(session.model, "drawings", lambda: twice)
    with pytest.raises(ValueError, match="one name"):
        await read_state(session, DRAWERS, lambda _: True)
