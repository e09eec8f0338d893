"""Request and plan of simulation sessions."""

from __future__ import annotations

import asyncio
import secrets
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from mapper.core.errors import ConfigError
from server.sessions.kind import Kind, Plan, Resources, SessionRequest
from server.sessions.making import Making
from server.stream.protocol import ProtocolError
from server.work.scheduler import URGENT_S

if TYPE_CHECKING:
    from server.sessions.hosting import ModelHost
    from server.sessions.model import SessionModel

DEFAULT_WORLD = "office"


class Story(BaseModel):
    """The history of a simulation: enough to reproduce the world, its recording and its map."""

    model_config = ConfigDict(extra="ignore")

    sensor: dict[str, Any] = Field({}, description="Initial values of the simulated sensor.")
    edits: dict[str, list[Any]] = Field({}, description="Initial edits of the world: added, erased.")
    steps: int = Field(0, ge=0, description="Physics steps of 0.02 s since the beginning.")
    journal: list[tuple[int, dict[str, Any]]] | None = Field(
        None, description="Each action with the step before which it was carried out; null if only the pose is known."
    )
    pose: tuple[float, float, float] | None = Field(None, description="Final pose of the robot, if journal is null.")
    auto: bool = Field(True, description="Whether the robot explores by itself then.")
    parameters: dict[str, Any] = Field({}, description="Mapping parameters that differ from the initial ones.")
    faults: dict[str, Any] = Field({}, description="The robot's faults.")
    navigation: list[dict[str, Any]] = Field(
        [], max_length=4, description="The commands that begin the costmap and set the goal of its path."
    )
    playing: bool = Field(True, description="Whether the session plays.")
    speed: float | None = Field(None, description="Simulated seconds per second.")


class PresentStory(Story):
    """The history of a simulation, and the world and the seed that it begins with."""

    world: str = Field(description="Name of the world.")
    seed: int = Field(description="Seed of the random numbers.")


class NewSimulation(SessionRequest):
    """A session of a simulation."""

    kind: Literal["simulation"]
    playing: bool = Field(
        True, description="Whether the session plays from the start; false pauses it, also with a story."
    )
    world: str | None = Field(None, max_length=100, description="Name of the world; by default the first one.")
    seed: int | None = Field(None, ge=0, lt=2**31, description="The same seed and commands give the same scans.")
    story: Story | None = Field(None, description="Recorded history of a simulation, from /api/sessions/{id}/story.")


def simulation_plan(
    world: str | None = None,
    seed: int | None = None,
    story: dict[str, Any] | None = None,
    *,
    max_story_s: float,
    playing: bool = True,
    name: str | None = None,
) -> Plan:
    """Return the plan of a simulation; with ``story``, of one in which that history was replayed.

    Raises :class:`mapper.core.errors.LimitError` for a story that would take more than ``max_story_s`` to replay and
    :class:`mapper.core.errors.ConfigError` for an unknown world; making it raises as :func:`replayed`.
    """
    from mapper.simulation.live_map import world_named  # noqa: PLC0415 - the simulator is imported with the first session
    from server.sources.story import check_story  # noqa: PLC0415

    story = story or {}
    cost_s = check_story(story, max_story_s)
    begun = {**story, "world": world_named(DEFAULT_WORLD if world is None else world).name}
    begun["seed"] = secrets.randbelow(2**31) if seed is None else seed

    def make(host: ModelHost, making: Making) -> SessionModel:
        from server.sources.simulation import SimulationModel  # noqa: PLC0415
        from server.sources.story import replayed  # noqa: PLC0415

        mapper = replayed(begun, limits=host.limits, wanted=making.may_continue, report=making.report)
        model = SimulationModel(host, mapper, max_story_s)
        try:
            model.resume(story)
        except ProtocolError as error:
            raise ConfigError(error.code, error.message) from error
        return model

    return Plan(make, name=name, interactive=cost_s <= URGENT_S, playing=playing)


async def _plan(wanted: NewSimulation, resources: Resources) -> Plan:
    story = None if wanted.story is None else wanted.story.model_dump()
    plan = partial(simulation_plan, max_story_s=resources.max_story_s, playing=wanted.playing, name=wanted.name)
    return await asyncio.to_thread(plan, wanted.world, wanted.seed, story)


SIMULATION = Kind(NewSimulation, _plan)
