"""A recorded log: it plays, and its map fills in."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.grid import OccupancyGrid
from mapper.io.export import GrowingMap
from mapper.io.logs.summary import recorded_seconds
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.mapping.sensor_defaults import sensor_defaults
from mapper.replay import Replay
from mapper.replay.incremental import CheckpointPrefetcher
from mapper.sensors.scan import ScanLog
from server.sessions.compared import ComparableSession
from server.sessions.diagnosing import examination
from server.sessions.session import Session
from server.sessions.tick import TickResult
from server.sessions.view import LogView, RobotState, as_pose
from server.sessions.why import Source
from server.stream.protocol import ProtocolError, integer, text

if TYPE_CHECKING:
    from mapper.diagnosis import Finding

FILL_S = 30.0  #: a log plays at first so fast that its map is full after about this many seconds
MAX_GAP_S = 2.0  #: a longer pause between two scans is played as one of this length
DEFAULT_GAP_S = 0.1  #: between two scans whose stamps do not tell
MAX_PATH_POINTS = 20_000  #: of the trajectory message
COARSER = (0.1, 0.2, 0.5, 1.0)  #: resolutions to try where a log's map is too large at the default one


def play_times(stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return when each scan is due (n,), in seconds of play from the first, never decreasing.

    Stamps may be anything: a step back, none at all or a leap of years. A step back takes no time, a pause at most
    :data:`MAX_GAP_S`; a log whose stamps tell nothing plays at :data:`DEFAULT_GAP_S` a scan.
    """
    # Differences in floats: those of absurd stamps do not fit into 64 bits.
    gaps = np.diff(stamps_ns.astype(np.float64)) * 1e-9
    gaps = np.clip(gaps, 0.0, MAX_GAP_S)
    if not gaps.any():
        gaps = np.full(len(gaps), DEFAULT_GAP_S)
    return np.concatenate([[0.0], np.cumsum(gaps)])


def first_config(log: ScanLog) -> MappingConfig:
    """Return the parameters that a log is mapped with at first."""
    row = BY_NAME["range_max"]
    range_max = float(np.clip(min(log.range_max, row.initial), row.low, row.high))
    return MappingConfig().with_values(sensor_defaults(log.beam_width, {"range_max": range_max}))


def first_replay(log: ScanLog, view: LogView, limits: Limits, wanted: Callable[[], bool] = lambda: True) -> Replay:
    """Return the replay that a session begins with: what ``view`` says, coarser where the map is too large.

    Raises :class:`mapper.core.errors.WorkCancelledError` where ``wanted``, asked now and then, says False.
    """
    config = first_config(log).with_values(view.values or {})
    for resolution in (*(one for one in COARSER if one > config.resolution), None):
        try:
            replay = Replay(log, config, view.trajectory, limits)
            replay.wanted = wanted
            replay.advance_to(min(view.index, log.n_scans))
        except LimitError:
            if resolution is None:
                raise
            config = replace(config, resolution=resolution)
        else:
            break
    return replay


class LogSession(ComparableSession):
    """A session of one log."""

    kind: ClassVar[Literal["simulation", "log"]] = "log"

    def __init__(
        self,
        replay: Replay,
        *,
        log_id: str,
        topic: str | None = None,
        title: str,
        owner: str,
        pool: Executor,
        limits: Callable[[Session | None], Limits],
    ) -> None:
        self._replay = replay
        replay.wanted = self.goes_on
        self.log_id = log_id
        self._topic = topic
        self._sensor_poses = replay.log.sensor_poses(replay.trajectory)
        self._times = play_times(replay.log.stamps_ns)
        self._recorded = recorded_seconds(replay.log)
        self._time = 0.0  #: seconds of play
        self._target = 0  #: the index that commands ask for
        self._examinations: dict[str, asyncio.Future[list[Finding]]] = {}  #: by trajectory
        duration = float(self._times[-1])
        self._speeds = (0.1, max(100.0, duration / 5.0))
        speed = float(np.clip(float(f"{duration / FILL_S:.2g}"), 0.1, self._speeds[1]))
        super().__init__(
            owner=owner, title=title, grid=replay.grid, config=replay.config, speed=speed, pool=pool, limits=limits
        )
        if replay.index:
            self.playing = False
            self._go_to(replay.index)

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""
        return self._replay.grid

    @property
    def replay(self) -> Replay:
        """What the map is made by."""
        return self._replay

    @property
    def log(self) -> ScanLog:
        """The log."""
        return self._replay.log

    @property
    def trajectory(self) -> str:
        """The name of the trajectory in use."""
        return self._replay.trajectory

    def seen(self) -> LogView:
        """Return what is shown now."""
        return LogView(self._topic, self.trajectory, asdict(self.config), self._replay.index)

    async def examined(self) -> list[Finding]:
        """Return what the doctor finds in the log with the trajectory of the moment.

        Whoever asks while it is being examined waits for the same answer; an examination that failed is made anew for
        the next who asks, and the end of the session ends it. Raises as :func:`mapper.diagnosis.examine`.
        """
        name = self.trajectory
        known = self._examinations.get(name)
        if known is None or (known.done() and known.exception() is not None):
            known = asyncio.ensure_future(self._examine(name))
            known.add_done_callback(lambda done: done.cancelled() or done.exception())  # nobody may wait any more
            self._examinations[name] = known
        return await asyncio.shield(known)

    async def growing_map(self) -> tuple[GrowingMap, str]:
        """Return how the map that is shown is made, and the name of its trajectory, between two ticks."""
        async with self._lock:
            replay = self._replay
            return GrowingMap(replay.grid, replay.config, replay.index), replay.trajectory

    async def _examine(self, trajectory: str) -> list[Finding]:
        return await examination(self.log, trajectory, self.scheduler, self.party, self.is_open)

    @property
    def fraction(self) -> float | None:
        """How much of the way through the log is done that is being computed."""
        return self._replay.fraction

    @property
    def speeds(self) -> tuple[float, float]:
        """Seconds of the log's time in a second."""
        return self._speeds

    @property
    def progress(self) -> tuple[int, int]:
        """Scans in the map, scans of the log."""
        return (self._replay.index, self.log.n_scans)

    def robot_state(self) -> RobotState:
        """The scan that came last into the map; before the first, its place without readings."""
        log, index = self.log, self._replay.index
        newest = max(index - 1, 0)
        scan = log.scan(newest)
        if index == 0:
            scan = replace(scan, ranges=np.full(log.n_beams, np.nan, dtype=np.float32))
        base = as_pose(log.trajectory(self.trajectory).poses[newest])
        sensor = as_pose(self._sensor_poses[newest])
        return RobotState(base, sensor, sensor, scan, float(self._recorded[newest]))

    def sources(self) -> list[Source]:
        """The log, as far as it is in the map."""
        return [Source(self.log, self.trajectory, self._replay.index, self._recorded)]

    def initial_config(self) -> MappingConfig:
        """Those that suit the log's sensor."""
        return first_config(self.log)

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return who leaves the checkpoints that lie ahead."""
        return self._replay.prefetcher()

    def particulars(self) -> dict[str, Any]:
        """The log and its trajectories."""
        log = self.log
        return {
            "log": {
                "id": self.log_id,
                "trajectory": self.trajectory,
                "trajectories": [{"name": k, "description": t.description} for k, t in log.trajectories.items()],
                "n_beams": log.n_beams,
                "n_scans": log.n_scans,
                "duration_s": float(self._recorded[-1]),
                "format": log.format,
                "notes": list(log.notes),
            }
        }

    def slots(self) -> list[dict[str, Any]]:
        """The trajectory, besides what every session says."""
        return [*super().slots(), self._trajectory_message()]

    def _trajectory_message(self) -> dict[str, Any]:
        poses = self.log.trajectory(self.trajectory).poses
        every = -(-len(poses) // MAX_PATH_POINTS)
        path = np.round(poses[::every, :2], 3).tolist()
        stamps = np.round(self._recorded[::every], 1).tolist()
        return {"type": "trajectory", "name": self.trajectory, "every": every, "poses": path, "stamps": stamps}

    def remake(self, config: MappingConfig, outcome: TickResult) -> None:
        """Make the map anew at the same scan."""
        self.follow(config, outcome)

    def advance(self, dt: float, outcome: TickResult) -> None:
        """Play on, or go to where a command wants to be."""
        replay, count = self._replay, self.log.n_scans
        if dt > 0.0 and self._target < count:
            self._time += dt * self.speed
            self._target = max(self._target, int(np.searchsorted(self._times, self._time, side="right")))
        if self._target != replay.index:
            with self.giving_up():
                outcome.add(replay.advance_to(self._target))
        if self.playing and self._target == count:
            self.playing = False
            outcome.changed = True
            outcome.notice("log.end", "The log has come to its end: all of its scans are in the map.")

    def obey(self, command: dict[str, Any], outcome: TickResult) -> None:
        """Carry out a command. Where to go is only noted: of many seeks that came meanwhile the last one counts."""
        count = self.log.n_scans
        match command["type"]:
            case "seek":
                index = integer(command, "index")
                if not 0 <= index <= count:
                    raise ProtocolError("command.index", f"The log has {count} scans; there is no map after {index}.")
                self._go_to(index)
            case "step":
                self.playing = False
                self._go_to(min(max(self._target + integer(command, "scans", 1), 0), count))
            case "restart":
                self._go_to(0)
                self.playing = True
            case "trajectory":
                self._choose(text(command, "name"), outcome)
            case "compare":
                raise ProtocolError(
                    "log.compare", "What a log is compared with is set with PUT /api/sessions/{id}/compare."
                )
            case "teleport" | "drive" | "auto" | "world" | "sensor" as kind:
                raise ProtocolError(
                    "log.recorded", f"What a log recorded cannot be changed: {kind} is for live worlds."
                )
            case other:
                raise ProtocolError("command.unknown", f"A log session knows no command {other!r:.80}.")

    def play(self) -> None:
        """Play on, from the start where the end was reached."""
        if self._target == self.log.n_scans:
            self._go_to(0)
        super().play()

    def _go_to(self, index: int) -> None:
        self._target = index
        self._time = float(self._times[max(index - 1, 0)])

    def _choose(self, trajectory: str, outcome: TickResult) -> None:
        old = self._replay
        replay = Replay(self.log, self.config, trajectory, self.limits())
        replay.wanted = old.wanted
        replay.advance_to(old.index)
        self._sensor_poses = self.log.sensor_poses(trajectory)
        self._replay = replay
        outcome.new_grid = True
        outcome.slot(self._trajectory_message())
