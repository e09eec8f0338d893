"""A model that catches up pauses before that, so that what was computed is sent first."""

from __future__ import annotations

from typing import Any

import pytest

from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sources.simulation import SimulationModel
from tests.server.begin import new_simulation
from tests.server.service import PATIENCE_S, eventually

N_COMMANDS, N_TICKS = 5, 9


async def test_only_commands_end_the_pause_of_a_model_that_catches_up(
    registry: SessionRegistry, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_simulation(registry, "me", "room", seed=1, playing=False)
    ticks, pause_s, advance = 0, PATIENCE_S, SimulationModel.advance

    def counted(self: SimulationModel, *arguments: Any) -> None:
        nonlocal ticks
        ticks += 1
        advance(self, *arguments)

    monkeypatch.setattr(SimulationModel, "advance", counted)
    monkeypatch.setattr(SimulationModel, "is_catching_up", property(lambda _: ticks < N_TICKS))
    monkeypatch.setattr(SimulationModel, "catch_up_pause_s", property(lambda _: pause_s))
    for number in range(N_COMMANDS):
        session.enqueue(command_of({"type": "auto", "value": False}))
        await session.carried_out()
        assert ticks == number + 1
    pause_s = 0.0
    session.enqueue(command_of({"type": "auto", "value": False}))
    await eventually(lambda: ticks == N_TICKS)
    async with session.settled():
        assert ticks == N_TICKS
