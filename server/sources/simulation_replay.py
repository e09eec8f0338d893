"""Recording and replaying the history of a simulation, which reproduces its world, recording and map."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict

from msgspec import UNSET, Struct, structs

from mapper.core.errors import LimitError, MapperError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.core.parameter import Values
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from mapper.simulation import Edits, Faults, SensorConfig
from mapper.simulation.kernels.driving import STEP
from mapper.simulation.lidar import rays_of_cone
from mapper.simulation.live_map import LiveMap, world_named
from mapper.simulation.pose_correction import Corrector
from mapper.simulation.robot import PoseTuple
from server.sessions.hosting import ModelHost
from server.sessions.part import Part
from server.sessions.tick import TickResult
from server.sessions.view import Playback
from server.sources.history import MAX_JOURNAL, Action, History, Replayable, SimulationHistory, WorldEdits
from server.stream.commands import AutoCommand, DriveCommand, EditCommand, SensorCommand, TeleportCommand


def act(mapper: LiveMap, command: Action, result: TickResult) -> None:
    """Carry out an action. Raises like the mapper, without changes."""
    simulation = mapper.simulation
    steps = simulation.steps
    match command:
        case TeleportCommand(x=x, y=y, yaw=yaw):
            change, message = mapper.teleport(x, y, yaw)
            result.add(change)
            if message is not None:
                result.notice("teleport.moved", message)
        case DriveCommand(linear=linear, angular=angular):
            simulation.drive(linear, angular)
        case AutoCommand(value=value):
            simulation.auto = value
        case SensorCommand(values=values):
            result.new_grid |= mapper.set_sensor(simulation.sensor.with_values(values))
        case EditCommand(added=added, erased=erased, watch=watch):
            if mapper.edit(Edits.of(added, erased), watch=bool(watch)):
                result.notice("edit.moved", "The robot stood where you drew, so it was moved aside.")
    if isinstance(command, EditCommand):
        command = structs.replace(command, watch=UNSET)
    mapper.journal.append((steps, command))


# Processor time in seconds, measured in the largest world on one core of a small server.
STEP_S = 1.2e-4  #: one step of the simulation
SCAN_S = 6e-4  #: one scan, whatever its readings
BEAM_S = 1.1e-6  #: one beam of a lidar
RAY_S = 2.6e-6  #: one ray of a sonar's cone, including its share of mapping
ACTION_S = 8e-3  #: one action after which the robot replans its path
SOLID_S = 1e-4  #: one wall or box of an edit
MAX_STORY_S = 600.0  #: longest simulated time to replay, seconds


def replay_seconds(history: History) -> float:
    """Return the estimated processor time, in seconds, of :func:`server.sources.simulation_replay.replayed`.

    Invalid values of the sensor are ignored here, because the replay rejects them.
    """
    steps = history.steps
    sensor = _with_values(SensorConfig(), history.sensor)
    total, at = STEP_S * steps, 0
    for step, command in history.journal or ():
        until = min(max(step, at), steps)
        total += _scans_s(sensor, until - at)
        at = until
        if isinstance(command, TeleportCommand | EditCommand | AutoCommand):  # the robot replans its path
            total += ACTION_S
        if isinstance(command, EditCommand):
            total += SOLID_S * len(command.added)
        if isinstance(command, SensorCommand):
            sensor = _with_values(sensor, command.values)
    return total + _scans_s(sensor, steps - at)


def check_cost(history: History, max_s: float) -> float:
    """Return :func:`replay_seconds`. Raises :class:`LimitError` if it is more than ``max_s``."""
    seconds = replay_seconds(history)
    if seconds > max_s:
        raise LimitError(
            "story.costly",
            f"Replaying this world would take about {seconds:.0f} s of computing, more than the {max_s:g} s that this "
            "service allows (setting GRIDBLOOM_MAX_STORY_S).",
        )
    return seconds


def _with_values(sensor: SensorConfig, values: Values) -> SensorConfig:
    try:
        return sensor.with_values(values)
    except MapperError:
        return sensor


def _scans_s(sensor: SensorConfig, steps: int) -> float:
    if sensor.kind == "sonar_ring":
        readings_s = RAY_S * sensor.n_sonars * len(rays_of_cone(sensor.beam_width))
    else:
        readings_s = BEAM_S * sensor.n_beams
    return steps * STEP * sensor.scan_rate * (SCAN_S + readings_s)


class SimulationReplay(Part, Replayable):
    """The history of a session: that of its simulation, playing, speed, the costmap.

    ``max_s`` is passed to :func:`history_of`; ``navigation`` returns the commands that begin the costmap and set its
    goal.
    """

    is_on = False  # it only answers

    def __init__(
        self,
        host: ModelHost,
        mapper: LiveMap,
        playback: Playback,
        max_s: float,
        navigation: Callable[[], list[Struct]] = list,
    ) -> None:
        self._host, self._mapper, self._playback, self._most_s = host, mapper, playback, max_s
        self._navigation = navigation

    async def present_history(self) -> SimulationHistory:
        """Return the history, between two ticks, of all earlier requests to the session."""
        await self._host.carried_out()
        async with self._host.locked():
            session = {
                "speed": self._playback.speed,
                "playing": self._playback.playing,
                "navigation": self._navigation(),
            }
            return history_of(self._mapper, self._most_s).model_copy(update=session)


def history_of(mapper: LiveMap, max_s: float = math.inf) -> SimulationHistory:
    """Return the history of a simulation, the argument of :func:`replayed`.

    ``journal`` is None if the history is too long or would take more than ``max_s`` seconds to replay; a replay then
    only begins with the present world and pose.
    """
    simulation = mapper.simulation
    is_short = len(mapper.journal) <= MAX_JOURNAL and simulation.steps * STEP <= MAX_STORY_S
    if is_short:
        whole = History(sensor=asdict(mapper.first_sensor), steps=simulation.steps, journal=mapper.journal)
        is_short = replay_seconds(whole) <= max_s
    added, erased = (mapper.first_edits if is_short else mapper.edits).as_lists()
    sensor = mapper.first_sensor if is_short else simulation.sensor
    x, y, yaw = (round(v, 3) for v in simulation.pose)
    return SimulationHistory(
        world=mapper.plan.name,
        seed=mapper.seed,
        sensor=_changed(sensor, SensorConfig()),
        edits=WorldEdits(added=added, erased=erased),
        steps=simulation.steps if is_short else 0,
        journal=mapper.journal if is_short else None,
        pose=(x, y, yaw),
        auto=simulation.auto,
        parameters=_changed(mapper.config, LiveMap.first_config(sensor)),
        faults=_changed(mapper.faults, Faults()),
    )


def replayed(
    history: SimulationHistory,
    limits: Callable[[], Limits] = Limits,
    may_continue: Callable[[], bool] = lambda: True,
    report: Callable[[float], None] = lambda _: None,
) -> LiveMap:
    """Replay a history, and return its map.

    ``may_continue`` is called about every hundredth of a second, ``report`` with the completed share of the simulated
    time. Raises :class:`LimitError` for a history that is too long, :class:`mapper.core.errors.WorkCancelledError` if
    ``may_continue`` returns False, and like the mapper for a history that cannot be replayed.
    """
    steps = history.steps
    if steps * STEP > MAX_STORY_S:
        raise LimitError("story.long", f"A story has at most {MAX_JOURNAL} actions in {MAX_STORY_S:g} s.")
    mapper = LiveMap(
        world_named(history.world),
        history.seed,
        sensor=SensorConfig().with_values(history.sensor),
        edits=Edits.of(history.edits.added, history.edits.erased),
        limits=limits,
        mapping=False,  # mapping once at the end is cheaper than after each scan
        may_continue=may_continue,
        make_corrector=_corrector,
    )

    def advance_to(step: int) -> None:
        while mapper.simulation.steps < step:
            if not may_continue():
                raise WorkCancelledError("story.unwanted", "The replay was cancelled.")
            mapper.advance(STEP)
            report(mapper.simulation.steps / max(1, steps))

    for at, command in history.journal or ():
        advance_to(min(at, steps))
        if not may_continue():
            raise WorkCancelledError("story.unwanted", "The replay was cancelled.")
        act(mapper, command, TickResult())
    advance_to(steps)
    if history.journal is None and history.pose is not None:
        mapper.teleport(*history.pose)
        mapper.simulation.auto = history.auto
    mapper.set_up(mapper.config.with_values(history.parameters), Faults().with_values(history.faults))
    mapper.begin_mapping()
    return mapper


def _corrector(log: ScanLog, start: PoseTuple) -> Corrector | None:
    from server.parts.slam.live_slam import live_slam  # noqa: PLC0415 - imports SLAM, which few sessions need

    return live_slam(log, start)


def _changed(config: MappingConfig | SensorConfig | Faults, first: object) -> Values:
    """Return the fields in which two tables of one type differ."""
    return {name: getattr(config, name) for name in config.__slots__ if getattr(config, name) != getattr(first, name)}
