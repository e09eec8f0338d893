"""The commands that move the robot, its sensor or its world: carried out, and kept so that all can be told again."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from mapper.core.errors import ConfigError, LimitError, MapperError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import Edits, Faults, SensorConfig
from mapper.simulation.live_map import LiveMap, world_named
from mapper.simulation.simulation import STEP
from server.sessions.story_cost import story_seconds
from server.sessions.tick import TickResult
from server.stream.protocol import ProtocolError, number, values

ACTIONS = ("teleport", "drive", "auto", "sensor", "edit")
MAX_JOURNAL = 1000  #: actions that a story holds
MAX_STORY_S = 600.0  #: seconds of the world's time that are told again


def flag(command: dict[str, Any], key: str) -> bool:
    """Return a true or false of a command, false where it is left out. Raises :class:`ProtocolError`."""
    value = command.get(key, False)
    if not isinstance(value, bool):
        raise ProtocolError(f"command.{key}", f'"{key}" must be true or false, not {value!r:.80}.')
    return value


def edits_of(command: dict[str, Any]) -> Edits:
    """Return the edits that a command names, none where it names none. Raises :class:`ConfigError`."""
    return Edits.of(command.get("added", []), command.get("erased", []))


def act(mapper: LiveMap, command: dict[str, Any], outcome: TickResult) -> None:
    """Carry out one of :data:`ACTIONS`. Raises as the mapper does, and nothing has changed then."""
    simulation = mapper.simulation
    steps = simulation.steps
    match command["type"]:
        case "teleport":
            yaw = None if command.get("yaw") is None else number(command, "yaw")
            change, message = mapper.teleport(number(command, "x"), number(command, "y"), yaw)
            outcome.add(change)
            if message is not None:
                outcome.notice("teleport.moved", message)
        case "drive":
            simulation.drive(number(command, "linear"), number(command, "angular"))
        case "auto":
            simulation.auto = flag(command, "value")
        case "sensor":
            outcome.new_grid |= mapper.set_sensor(simulation.sensor.with_values(values(command)))
        case "edit":
            if mapper.edit(edits_of(command), watch=flag(command, "watch")):
                outcome.notice("edit.moved", "The robot stood where you drew: it made way.")
        case other:
            raise ProtocolError("command.unknown", f"{other!r:.80} is nothing that a robot or its world can do.")
    mapper.journal.append((steps, {key: value for key, value in command.items() if key != "watch"}))


def story_of(mapper: LiveMap, most_s: float = math.inf) -> dict[str, Any]:
    """Return all that is needed to make this world, its recording and its map again; see :func:`retold`.

    ``journal`` is None where the story is too long, or would take more than ``most_s`` seconds to replay; the world
    then only begins as it stands now.
    """
    short = len(mapper.journal) <= MAX_JOURNAL and mapper.simulation.steps * STEP <= MAX_STORY_S
    told = {"sensor": asdict(mapper.first_sensor), "steps": mapper.simulation.steps, "journal": mapper.journal}
    short = short and story_seconds(told) <= most_s
    first = mapper.first_edits if short else mapper.edits
    added, erased = first.as_lists()
    sensor = mapper.first_sensor if short else mapper.simulation.sensor
    return {
        "world": mapper.plan.name,
        "seed": mapper.seed,
        "sensor": _changed(sensor, SensorConfig()),
        "edits": {"added": added, "erased": erased},
        "steps": mapper.simulation.steps if short else 0,
        "journal": [list(entry) for entry in mapper.journal] if short else None,
        "pose": [round(v, 3) for v in mapper.simulation.pose],
        "auto": mapper.simulation.auto,
        "parameters": _changed(mapper.config, LiveMap.first_config(sensor)),
        "faults": _changed(mapper.faults, Faults()),
    }


def retold(
    story: dict[str, Any],
    limits: Callable[[], Limits] = Limits,
    wanted: Callable[[], bool] = lambda: True,
    report: Callable[[float], None] = lambda _: None,
) -> LiveMap:
    """Return the mapper to which everything in a story has happened again.

    ``world`` and ``seed`` are there, the rest may be left out. ``wanted`` is asked about every hundredth of a second,
    and ``report`` is called with the share of the world's time that has passed. Raises :class:`LimitError` for a story
    that is too long, :class:`mapper.core.errors.WorkCancelledError` where it is not wanted any more, and as the
    mapper does for one that cannot be followed.
    """
    journal, steps = story.get("journal"), story.get("steps", 0)
    if len(journal or ()) > MAX_JOURNAL or not 0 <= steps * STEP <= MAX_STORY_S:
        raise LimitError("story.long", f"A story has at most {MAX_JOURNAL} actions in {MAX_STORY_S:g} s.")
    sensor = SensorConfig().with_values(story.get("sensor") or {})
    edits = edits_of(story.get("edits") or {})
    mapper = LiveMap(
        world_named(story["world"]),
        story["seed"],
        sensor=sensor,
        edits=edits,
        limits=limits,
        mapping=False,  # one map at the end costs less than one that follows
        wanted=wanted,
    )

    def advance_to(step: int) -> None:
        while mapper.simulation.steps < step:
            if not wanted():
                raise WorkCancelledError("story.unwanted", "The story is not wanted any more.")
            mapper.advance(STEP)
            report(mapper.simulation.steps / max(1, steps))

    for at, command in journal or ():
        advance_to(min(at, steps))
        if not wanted():
            raise WorkCancelledError("story.unwanted", "The story is not wanted any more.")
        _retell(mapper, command)
    advance_to(steps)
    if journal is None and story.get("pose") is not None:
        mapper.teleport(*story["pose"])
        mapper.simulation.auto = bool(story.get("auto", True))
    config = mapper.config.with_values(story.get("parameters") or {})
    faults = Faults().with_values(story.get("faults") or {})
    mapper.set_up(config, faults)
    mapper.begin_mapping()
    return mapper


def _retell(mapper: LiveMap, command: dict[str, Any]) -> None:
    if command.get("type") not in ACTIONS:
        raise ConfigError("story.action", f"A story holds no {command.get('type')!r:.80}.")
    try:
        act(mapper, command, TickResult())
    except ProtocolError as error:
        raise MapperError(error.code, error.message) from error


def _changed(config: MappingConfig | SensorConfig | Faults, first: object) -> dict[str, Any]:
    """Return the fields in which two of a kind differ."""
    return {name: getattr(config, name) for name in config.__slots__ if getattr(config, name) != getattr(first, name)}
