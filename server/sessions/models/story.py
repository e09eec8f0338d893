"""The story of a simulation: all that is needed to make its world, its recording and its map again."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from mapper.core.errors import ConfigError, LimitError, MapperError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import Faults, SensorConfig
from mapper.simulation.live_map import LiveMap, world_named
from mapper.simulation.simulation import STEP
from server.sessions.hosting import ModelHost
from server.sessions.models.simulation_commands import ACTIONS, act, edits_of
from server.sessions.models.story_cost import story_seconds
from server.sessions.playback import Playback
from server.sessions.tick import TickResult
from server.stream.protocol import ProtocolError

MAX_JOURNAL = 1000  #: actions that a story holds
MAX_STORY_S = 600.0  #: seconds of the world's time that are replayed


class SimulationStory:
    """The story of a session: that of its world, whether it plays, and how fast. ``max_s`` as in :func:`story_of`."""

    def __init__(self, host: ModelHost, mapper: LiveMap, playback: Playback, max_s: float) -> None:
        self._host, self._mapper, self._playback, self._most_s = host, mapper, playback, max_s

    async def current(self) -> dict[str, Any]:
        """Return it as it is between two ticks."""
        async with self._host.locked():
            story = story_of(self._mapper, self._most_s)
            return story | {"speed": self._playback.speed, "playing": self._playback.playing}


def story_of(mapper: LiveMap, max_s: float = math.inf) -> dict[str, Any]:
    """Return the story of a simulation; :func:`replayed` makes it again.

    ``journal`` is None where the story is too long, or would take more than ``max_s`` seconds to replay; the world
    then only begins as it stands now.
    """
    short = len(mapper.journal) <= MAX_JOURNAL and mapper.simulation.steps * STEP <= MAX_STORY_S
    whole = {"sensor": asdict(mapper.first_sensor), "steps": mapper.simulation.steps, "journal": mapper.journal}
    short = short and story_seconds(whole) <= max_s
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


def replayed(
    story: dict[str, Any],
    limits: Callable[[], Limits] = Limits,
    wanted: Callable[[], bool] = lambda: True,
    report: Callable[[float], None] = lambda _: None,
) -> LiveMap:
    """Return the map to which everything in a story has happened again.

    ``world`` and ``seed`` are there, the rest may be left out. ``wanted`` is asked about every hundredth of a second,
    and ``report`` is called with the share of the world's time that has passed. Raises :class:`LimitError` for a story
    that is too long, :class:`mapper.core.errors.WorkCancelledError` where it is not wanted any more, and as the
    mapper does for one that cannot be replayed.
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
        mapping=False,  # one map at the end costs less than one after each scan
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
        _replay(mapper, command)
    advance_to(steps)
    if journal is None and story.get("pose") is not None:
        mapper.teleport(*story["pose"])
        mapper.simulation.auto = bool(story.get("auto", True))
    config = mapper.config.with_values(story.get("parameters") or {})
    faults = Faults().with_values(story.get("faults") or {})
    mapper.set_up(config, faults)
    mapper.begin_mapping()
    return mapper


def _replay(mapper: LiveMap, command: dict[str, Any]) -> None:
    if command.get("type") not in ACTIONS:
        raise ConfigError("story.action", f"A story holds no {command.get('type')!r:.80}.")
    try:
        act(mapper, command, TickResult())
    except ProtocolError as error:
        raise MapperError(error.code, error.message) from error


def _changed(config: MappingConfig | SensorConfig | Faults, first: object) -> dict[str, Any]:
    """Return the fields in which two of a kind differ."""
    return {name: getattr(config, name) for name in config.__slots__ if getattr(config, name) != getattr(first, name)}
