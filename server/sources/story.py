"""The story of a simulation: its recorded history, from which its world, recording and map can be reproduced."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from mapper.core.errors import ConfigError, LimitError, MapperError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from mapper.simulation import Edits, Faults, SensorConfig
from mapper.simulation.kernels.driving import STEP
from mapper.simulation.live_map import LiveMap, world_named
from mapper.simulation.pose_correction import Corrector
from mapper.simulation.robot import PoseTuple
from mapper.simulation.sonar import rays_of_cone
from server.parts.wire import command_of
from server.sessions.hosting import ModelHost
from server.sessions.part import Part
from server.sessions.parts import Story
from server.sessions.playback import Playback
from server.sessions.tick import TickResult
from server.sources.simulation_commands import Action, act
from server.stream.protocol import ProtocolError, type_of

# Processor time in seconds, measured in the largest world on one core of a small server.
STEP_S = 1.2e-4  #: one step of the simulation
SCAN_S = 6e-4  #: one scan, whatever its readings
BEAM_S = 1.1e-6  #: one beam of a lidar
RAY_S = 2.6e-6  #: one ray of a sonar's cone, with its part of the map
ACTION_S = 8e-3  #: one action after which the robot plans its path again
SOLID_S = 1e-4  #: one wall or box of an edit
_PLANNED_ANEW = ("teleport", "edit", "auto")
MAX_JOURNAL = 1000  #: most actions in a story
MAX_STORY_S = 600.0  #: longest simulated time that is replayed, seconds


def story_seconds(story: dict[str, Any]) -> float:
    """Return the estimated processor time, in seconds, of :func:`server.sources.story.replayed`.

    Invalid values are ignored: they are refused when the story is replayed.
    """
    steps = max(0, story.get("steps") or 0)
    sensor = _with_values(SensorConfig(), story.get("sensor"))
    total, at = STEP_S * steps, 0
    for step, command in story.get("journal") or ():
        until = min(max(step, at), steps)
        total += _scans_s(sensor, until - at)
        at = until
        if command.get("type") in _PLANNED_ANEW:
            total += ACTION_S
        if command.get("type") == "edit":
            added = command.get("added")
            total += SOLID_S * (len(added) if isinstance(added, list) else 0)
        if command.get("type") == "sensor":
            sensor = _with_values(sensor, command.get("values"))
    return total + _scans_s(sensor, steps - at)


def check_story(story: dict[str, Any], max_s: float) -> float:
    """Return :func:`story_seconds`. Raises :class:`LimitError` if that is more than ``max_s``."""
    seconds = story_seconds(story)
    if seconds > max_s:
        raise LimitError(
            "story.costly",
            f"Replaying this world would take about {seconds:.0f} s of computing, more than the {max_s:g} s that this "
            "service allows (setting GRIDBLOOM_MAX_STORY_S).",
        )
    return seconds


def _with_values(sensor: SensorConfig, values: object) -> SensorConfig:
    try:
        return sensor.with_values(values) if isinstance(values, dict) else sensor
    except MapperError:
        return sensor


def _scans_s(sensor: SensorConfig, steps: int) -> float:
    if sensor.kind == "sonar_ring":
        readings_s = RAY_S * sensor.n_sonars * len(rays_of_cone(sensor.beam_width))
    else:
        readings_s = BEAM_S * sensor.n_beams
    return steps * STEP * sensor.scan_rate * (SCAN_S + readings_s)


class SimulationStory(Part, Story):
    """The story of a session: that of its simulation, playing, speed, the costmap. ``max_s`` as in :func:`story_of`.

    ``navigation`` returns the commands that begin the costmap and set its goal.
    """

    def __init__(
        self,
        host: ModelHost,
        mapper: LiveMap,
        playback: Playback,
        max_s: float,
        navigation: Callable[[], list[dict[str, Any]]] = list,
    ) -> None:
        self._host, self._mapper, self._playback, self._most_s = host, mapper, playback, max_s
        self._navigation = navigation

    async def current(self) -> dict[str, Any]:
        """Return the story, between two ticks, of all that was asked of the session before."""
        await self._host.carried_out()
        async with self._host.locked():
            story = story_of(self._mapper, self._most_s)
            playback = {"speed": self._playback.speed, "playing": self._playback.playing}
            return story | playback | {"navigation": self._navigation()}


def story_of(mapper: LiveMap, max_s: float = math.inf) -> dict[str, Any]:
    """Return the story of a simulation, the argument of :func:`replayed`.

    ``journal`` is None if the story is too long or would take more than ``max_s`` seconds to replay; a replay then
    only begins with the present world and pose.
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
    """Replay a story, and return its map.

    ``world`` and ``seed`` are required. ``wanted`` is called about every hundredth of a second, ``report`` with the
    share of the simulated time that has passed. Raises :class:`LimitError` for a story that is too long,
    :class:`mapper.core.errors.WorkCancelledError` if ``wanted`` returns False, and as the mapper does for a story that
    cannot be replayed.
    """
    journal, steps = story.get("journal"), story.get("steps", 0)
    if len(journal or ()) > MAX_JOURNAL or not 0 <= steps * STEP <= MAX_STORY_S:
        raise LimitError("story.long", f"A story has at most {MAX_JOURNAL} actions in {MAX_STORY_S:g} s.")
    sensor = SensorConfig().with_values(story.get("sensor") or {})
    given = story.get("edits") or {}
    edits = Edits.of(given.get("added", []), given.get("erased", []))
    mapper = LiveMap(
        world_named(story["world"]),
        story["seed"],
        sensor=sensor,
        edits=edits,
        limits=limits,
        mapping=False,  # mapping once at the end costs less than after each scan
        wanted=wanted,
        make_corrector=_corrector,
    )

    def advance_to(step: int) -> None:
        while mapper.simulation.steps < step:
            if not wanted():
                raise WorkCancelledError("story.unwanted", "The replay was cancelled.")
            mapper.advance(STEP)
            report(mapper.simulation.steps / max(1, steps))

    for at, command in journal or ():
        advance_to(min(at, steps))
        if not wanted():
            raise WorkCancelledError("story.unwanted", "The replay was cancelled.")
        act(mapper, action_of(command), TickResult())
    advance_to(steps)
    if journal is None and story.get("pose") is not None:
        mapper.teleport(*story["pose"])
        mapper.simulation.auto = bool(story.get("auto", True))
    config = mapper.config.with_values(story.get("parameters") or {})
    faults = Faults().with_values(story.get("faults") or {})
    mapper.set_up(config, faults)
    mapper.begin_mapping()
    return mapper


def _corrector(log: ScanLog, start: PoseTuple) -> Corrector | None:
    from server.parts.slam.live_slam import live_slam  # noqa: PLC0415 - imports SLAM, which few sessions need

    return live_slam(log, start)


def action_of(fields: dict[str, Any]) -> Action:
    """Return an action of a journal. Raises :class:`MapperError` for what is none."""
    try:
        command = command_of(fields)
    except ProtocolError as error:
        raise MapperError(error.code, error.message) from error
    if not isinstance(command, Action):
        raise ConfigError("story.action", f"A story cannot contain the action {type_of(command)!r:.80}.")
    return command


def _changed(config: MappingConfig | SensorConfig | Faults, first: object) -> dict[str, Any]:
    """Return the fields in which two tables of one type differ."""
    return {name: getattr(config, name) for name in config.__slots__ if getattr(config, name) != getattr(first, name)}
