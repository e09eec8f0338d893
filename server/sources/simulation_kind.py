"""Request and plan of simulation sessions."""

from __future__ import annotations

import asyncio
import secrets
from functools import partial
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from mapper.core.errors import ConfigError
from server.sessions.kind import Kind, Plan, Resources, SessionRequest
from server.sessions.making import Making
from server.sources.history import History, SimulationHistory
from server.stream.protocol import ProtocolError
from server.work.scheduler import URGENT_S

if TYPE_CHECKING:
    from server.sessions.hosting import ModelHost
    from server.sessions.model import SessionModel

DEFAULT_WORLD = "office"


class NewSimulation(SessionRequest):
    """A session of a simulation."""

    kind: Literal["simulation"]
    playing: bool = Field(
        True, description="Whether the session plays from the start; false pauses it, also with a story."
    )
    world: str | None = Field(None, max_length=100, description="Name of the world; by default the first one.")
    seed: int | None = Field(None, ge=0, lt=2**31, description="The same seed and commands give the same scans.")
    story: History | None = Field(None, description="Recorded history of a simulation, from /api/sessions/{id}/story.")


def simulation_plan(
    world: str | None = None,
    seed: int | None = None,
    history: History | None = None,
    *,
    max_story_s: float,
    playing: bool = True,
    name: str | None = None,
) -> Plan:
    """Return the plan of a simulation, optionally with a replayed ``history``.

    Raises :class:`mapper.core.errors.LimitError` for a history that would take more than ``max_story_s`` to replay and
    :class:`mapper.core.errors.ConfigError` for an unknown world. Creating it raises like :func:`replayed`.
    """
    from mapper.simulation.live_map import world_named  # noqa: PLC0415 - the simulator is imported with the first session
    from server.sources.simulation_replay import check_cost  # noqa: PLC0415

    history = history or History()
    cost_s = check_cost(history, max_story_s)
    name_of_world = world_named(DEFAULT_WORLD if world is None else world).name
    begun = {"world": name_of_world, "seed": secrets.randbelow(2**31) if seed is None else seed}
    whole = SimulationHistory.model_validate(dict(history) | begun)

    def make(host: ModelHost, making: Making) -> SessionModel:
        from server.sources.simulation import SimulationModel  # noqa: PLC0415
        from server.sources.simulation_replay import replayed  # noqa: PLC0415

        mapper = replayed(whole, limits=host.limits, may_continue=making.may_continue, report=making.report)
        model = SimulationModel(host, mapper, max_story_s)
        try:
            model.resume(history)
        except ProtocolError as error:
            raise ConfigError(error.code, error.message) from error
        return model

    return Plan(make, name=name, interactive=cost_s <= URGENT_S, playing=playing)


async def _plan(request: NewSimulation, resources: Resources) -> Plan:
    plan = partial(simulation_plan, max_story_s=resources.max_story_s, playing=request.playing, name=request.name)
    return await asyncio.to_thread(plan, request.world, request.seed, request.story)


SIMULATION = Kind(NewSimulation, _plan)
