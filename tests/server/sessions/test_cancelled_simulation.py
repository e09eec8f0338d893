"""Long computations of the lab end when they are cancelled, and leave everything as it was."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.mapping.integrate import integrate_parts
from mapper.simulation.edits import Edits, edited, solid_ids
from mapper.simulation.live_map import LiveMap
from mapper.simulation.second_map import Vanishing
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sources.simulation import SimulationModel
from tests.server.begin import between_ticks, new_simulation
from tests.server.service import PATIENCE_S, eventually

SQUARE = [[2.0, 2.0], [2.4, 2.0], [2.4, 2.4], [2.0, 2.4]]


class Held:
    """Holds each part of a map until it is released."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.held, self.released = threading.Event(), threading.Event()
        self.parts = 0
        monkeypatch.setattr("mapper.simulation.live_map.integrate_parts", self._parts)

    def _parts(self, *given: Any) -> Iterator[Any]:
        for part in integrate_parts(*given):
            self.parts += 1
            self.held.set()
            assert self.released.wait(PATIENCE_S)
            yield part


@pytest.mark.parametrize(
    "command",
    [
        {"type": "parameters", "values": {"window": 0.41}},
        {"type": "faults", "values": {"drift": True}},
        {"type": "compare", "values": {"window": 0.0}},
        {"type": "step", "scans": -1},
    ],
    ids=lambda command: str(command["type"]),
)
async def test_a_command_that_is_cancelled_changes_nothing(
    command: dict[str, Any], registry: SessionRegistry, obey: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_simulation(registry, "me", playing=False)
    client = session.join()
    await obey(session, type="step", scans=5)
    model = session.model
    assert isinstance(model, SimulationModel)
    before = model.grid.log_odds.copy()
    state = (asdict(model.config), asdict(model._mapper.faults), model._mapper.second, model.progress)
    client.take()
    held = Held(monkeypatch)
    session.enqueue(command_of(command), client)
    assert await asyncio.to_thread(held.held.wait, PATIENCE_S)
    session.enqueue(command_of({"type": "cancel"}), client)
    held.released.set()
    await eventually(lambda: not session.has_queued_commands)
    await between_ticks(session)
    assert held.parts == 1
    assert (asdict(model.config), asdict(model._mapper.faults), model._mapper.second, model.progress) == state
    np.testing.assert_array_equal(model.grid.log_odds, before)
    texts = [json.loads(message) for message in client.take() if isinstance(message, str)]
    assert "error" not in {message["type"] for message in texts}
    told = [message for message in texts if message["type"] == "parameters"]
    assert command["type"] == "step" or told[-1]["values"]["window"] == state[0]["window"]


def _is_seen(mapper: LiveMap, name: int) -> bool:
    """Return whether the map holds a part of the world of this name, so that it can be erased and forgotten."""
    try:
        after = edited(mapper.plan, Edits(erased=frozenset({name})), mapper.limits())
        Vanishing.of(mapper.grid, mapper.config, mapper.simulation.world, after)
    except ConfigError:
        return False
    return True


async def test_an_edit_whose_second_map_is_cancelled_leaves_the_world(
    registry: SessionRegistry, obey: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    session = await new_simulation(registry, "me", "office", 0, playing=False)
    session.join()
    model = session.model
    assert isinstance(model, SimulationModel)
    mapper = model._mapper
    name = next(one for one in solid_ids(mapper.plan, mapper.edits) if _is_seen(mapper, one))
    journal, solids = len(mapper.journal), len(model.world.solids)
    held = Held(monkeypatch)
    session.enqueue(command_of({"type": "edit", "added": [], "erased": [name], "watch": True}))
    assert await asyncio.to_thread(held.held.wait, PATIENCE_S)
    session.enqueue(command_of({"type": "cancel"}))
    held.released.set()
    await eventually(lambda: not session.has_queued_commands)
    assert (len(mapper.journal), len(model.world.solids), mapper.second, mapper.vanishing) == (
        journal,
        solids,
        None,
        None,
    )
