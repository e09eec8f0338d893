"""The recorded history of a simulation in the form used by requests, answers and puzzles."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Annotated, TypeAlias

from msgspec import Struct
from pydantic import BaseModel, Field, PlainSerializer, PlainValidator, WithJsonSchema

from mapper.core.errors import ConfigError
from server.parts.wire import command_of
from server.sessions.kind import GivenValues
from server.stream.commands import AutoCommand, DriveCommand, EditCommand, SensorCommand, TeleportCommand
from server.stream.protocol import ProtocolError, fields_of, type_of

MAX_JOURNAL = 1000  #: maximum number of actions in a history

Action: TypeAlias = TeleportCommand | DriveCommand | AutoCommand | SensorCommand | EditCommand
"""A command that moves the robot, its sensor or its world."""


def _recorded(fields: object) -> Struct:
    """Return a recorded command. Raises :class:`ConfigError` for anything else."""
    if isinstance(fields, Struct):
        return fields
    try:
        return command_of(fields)
    except ProtocolError as error:
        raise ConfigError(error.code, error.message) from error


def _action(fields: object) -> Action:
    """Return a recorded action. Raises :class:`ConfigError` for anything else."""
    command = _recorded(fields)
    if not isinstance(command, Action):
        raise ConfigError("story.action", f"A story cannot contain the action {type_of(command)!r:.80}.")
    return command


_AS_JSON = (PlainSerializer(fields_of), WithJsonSchema({"type": "object", "additionalProperties": True}))


class WorldEdits(BaseModel):
    """Edits of a world, as in the ``edit`` command."""

    added: Annotated[list[list[str | int]], Field(description="Walls and boxes that were drawn.")] = []
    erased: Annotated[list[int], Field(description="Indices of the built solids that were erased.")] = []


class History(BaseModel, extra="ignore"):
    """The history of a simulation. Its world, seed and history reproduce its recording and its map."""

    sensor: Annotated[GivenValues, Field(description="Initial values of the simulated sensor.")] = {}
    edits: Annotated[WorldEdits, Field(description="Initial edits of the world.")] = WorldEdits()
    steps: Annotated[int, Field(ge=0, description="Physics steps of 0.02 s since the beginning.")] = 0
    journal: Annotated[
        list[tuple[int, Annotated[Action, PlainValidator(_action), *_AS_JSON]]] | None,
        Field(
            max_length=MAX_JOURNAL,
            description="Each action with the step before which it was carried out; null if only the pose is known.",
        ),
    ] = None
    pose: Annotated[
        tuple[float, float, float] | None, Field(description="Final pose of the robot, if journal is null.")
    ] = None
    auto: Annotated[bool, Field(description="Whether the robot explores by itself then.")] = True
    parameters: Annotated[GivenValues, Field(description="Mapping parameters that differ from the initial ones.")] = {}
    faults: Annotated[GivenValues, Field(description="The robot's faults.")] = {}
    speed: Annotated[float | None, Field(description="Simulated seconds per second.")] = None
    playing: Annotated[bool, Field(description="Whether the session plays.")] = True
    navigation: Annotated[
        list[Annotated[Struct, PlainValidator(_recorded), *_AS_JSON]],
        Field(max_length=4, description="The commands that begin the costmap and set the goal of its path."),
    ] = []


class _Beginning(BaseModel):
    world: str = Field(description="Name of the world.")
    seed: int = Field(description="Seed of the random numbers.")


class SimulationHistory(History, _Beginning):
    """The history of a simulation, with its initial world and seed."""


class Replayable(ABC):
    """A session with a recorded history from which it can be reproduced."""

    @abstractmethod
    async def present_history(self) -> SimulationHistory:
        """Return the history, between two ticks, of all earlier requests to the session."""
