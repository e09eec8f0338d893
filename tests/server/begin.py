"""Sessions begun at a registry, without a request. Loosely typed: tests read the model of a kind."""

from __future__ import annotations

import math
from typing import Any

from mapper.sensors.scan import ScanLog
from server.sessions import SessionRegistry
from server.sources import log_plan
from server.sources.history import History, SimulationHistory
from server.sources.simulation_kind import simulation_plan


async def new_simulation(
    registry: SessionRegistry,
    owner: str,
    world: str | None = None,
    seed: int | None = None,
    history: SimulationHistory | dict[str, Any] | None = None,
    *,
    max_story_s: float = math.inf,
    **more: Any,
) -> Any:
    """Begin a session of a simulated world."""
    begun = None if history is None else History.model_validate(history)
    return await registry.begin(simulation_plan(world, seed, begun, max_story_s=max_story_s, **more), owner)


async def new_log(registry: SessionRegistry, owner: str, log: ScanLog, *, link: str | None = None, **more: Any) -> Any:
    """Begin a session of a log."""
    return await registry.begin(log_plan(log, **more), owner, link=link)


async def between_ticks(session: Any) -> None:
    """Return once the present tick of a session is over."""
    async with session.locked():
        pass
