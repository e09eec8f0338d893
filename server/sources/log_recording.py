"""The log of a session, with its replay, trajectory and diagnosis."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import numpy as np

from mapper import diagnosis
from mapper.core.errors import LimitError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.core.parameter import changed_values
from mapper.core.se2 import pose_tuple
from mapper.evaluation.same_path import first_pair, stated_before
from mapper.io.export import GrowingMap
from mapper.io.logs.summary import recorded_seconds
from mapper.mapping.parameters import BY_NAME, MappingConfig, recorded_defaults
from mapper.mapping.scan_batch import placed_scan
from mapper.replay import Replay
from mapper.sensors.joint_log import JointLog
from mapper.sensors.planar.options import PARAMETERS as CUT_PARAMETERS
from mapper.sensors.planar.options import PlanarCut, applies
from mapper.sensors.scan import ScanLog, Trajectory
from server.sessions.hosting import ModelHost
from server.sessions.part import MappedScans
from server.sessions.parts import Recording, Viewed
from server.sessions.view import LogView, RobotState
from server.stream.message_parts import Table, rows_of
from server.work.priority import lower_priority
from server.work.scheduler import JobOwner, Scheduler

if TYPE_CHECKING:
    from mapper.diagnosis import Diagnosis
    from mapper.io.contents.model import Series


IDLE_S = 20.0  #: a computation ends when it was not requested for this time

SeriesKey: TypeAlias = tuple[Trajectory, MappingConfig]


class MapSeries:
    """The newest series of a session's map, or its completed share. Used from the event loop."""

    def __init__(self, host: ModelHost) -> None:
        self._host = host
        self._of: SeriesKey | None = None
        self._job: asyncio.Future[Series] | None = None
        self._asked = 0.0
        self._share = 0.0

    def look_up(self, replay: Replay) -> Series | float:
        """Return the series of the log of ``replay``, with its parameters, or the completed share.

        Raises like :func:`mapper.replay.map_series.map_series`.
        """
        self._asked = time.monotonic()
        of = (replay.log.trajectory(replay.trajectory), replay.config)
        job = self._job
        if job is None or self._of is None or self._of[0] is not of[0] or self._of[1] != of[1]:
            return self._begin(replay, of)
        if not job.done():
            return self._share
        if isinstance(job.exception(), WorkCancelledError):
            return self._begin(replay, of)
        return job.result()

    def _begin(self, replay: Replay, of: SeriesKey) -> float:
        host, goes_on = self._host, self._host.in_background()
        log, config, trajectory, limits = replay.log, replay.config, replay.trajectory, host.limits()
        self._of, self._share = of, 0.0

        def progress(share: float) -> None:
            if self._of is of:
                self._share = share

        def may_continue() -> bool:
            return self._of is of and time.monotonic() - self._asked < IDLE_S and goes_on()

        def computed() -> Series:
            from mapper.replay.map_series import map_series  # noqa: PLC0415 - imports SciPy, which few sessions need

            return map_series(log, config, trajectory, limits, progress, may_continue)

        self._job = asyncio.ensure_future(in_turn(host.scheduler, host.job_owner, computed))
        self._job.add_done_callback(lambda done: done.cancelled() or done.exception())  # the next request reports it
        return 0.0


COARSER = (0.1, 0.2, 0.5, 1.0)  #: resolutions to try if a log's map is too large at the default, metres


def first_config(log: ScanLog) -> MappingConfig:
    """Return the initial parameters for a log."""
    row = BY_NAME["range_max"]
    range_max = float(np.clip(min(log.range_max, row.initial), row.low, row.high))
    return MappingConfig().with_values(recorded_defaults(log.beam_width, {"range_max": range_max}))


def first_replay(
    log: ScanLog, view: LogView, limits: Limits, may_continue: Callable[[], bool] = lambda: True
) -> Replay:
    """Return a session's initial replay: as in ``view``, but with larger cells if the map is too large.

    Raises :class:`mapper.core.errors.WorkCancelledError` if ``may_continue`` returns False.
    """
    # The values are complete: a parameter that is newer than the link has the table's value.
    config = first_config(log) if view.values is None else MappingConfig().with_values(view.values)
    for resolution in (*(resolution for resolution in COARSER if resolution > config.resolution), None):
        try:
            replay = Replay(log, config, view.trajectory, limits)
            replay.may_continue = may_continue
        except LimitError:
            if resolution is None:
                raise
            config = replace(config, resolution=resolution)
        else:
            break
    return replay


class _Examination:
    """One examination: the number of waiting requests, and the completed share (None: not started)."""

    def __init__(self) -> None:
        self.future: asyncio.Future[Diagnosis]
        self.waiting = 0
        self.share: float | None = None

    @property
    def is_wanted(self) -> bool:
        """Whether any request waits for it (any thread)."""
        return self.waiting > 0


class LogRecording(Recording, Viewed):
    """A log, and the replay that computes its map.

    ``log_id`` is its id in the library, ``view`` contains its sensor and the options for cutting its scans. ``first``
    are the initial parameters, None for those of the log.
    """

    def __init__(
        self, host: ModelHost, replay: Replay, log_id: str, view: LogView, first: MappingConfig | None = None
    ) -> None:
        self.log_id = log_id
        self.replay = replay
        self.recorded = recorded_seconds(replay.log)  #: (n_scans,) float64, seconds since the first scan
        self._topic, self._cut = view.topic, view.cut
        self._host = host
        self._first = first
        self._examinations: dict[str, _Examination] = {}  #: by trajectory
        self._map_series = MapSeries(host)
        self._same_paths = (replay.log.trajectories, stated_before(replay.log.trajectories))

    @property
    def log(self) -> ScanLog:
        """The log."""
        return self.replay.log

    @property
    def trajectory(self) -> str:
        """The name of the current trajectory."""
        return self.replay.trajectory

    def same_paths(self) -> dict[str, str]:
        """Return, for each trajectory with the same path as an earlier one, the name of the earlier one."""
        trajectories = self.log.trajectories
        if self._same_paths[0] is not trajectories:  # for long logs it takes longer than a message may
            self._same_paths = (trajectories, stated_before(trajectories))
        return self._same_paths[1]

    def compared(self) -> tuple[str, str] | None:
        """Return the same as :func:`mapper.evaluation.first_pair`."""
        return first_pair(self.log.trajectories, self.same_paths())

    def first_config(self) -> MappingConfig:
        """Return the initial parameters for the log."""
        return first_config(self.log) if self._first is None else self._first

    def view(self) -> LogView:
        """Return the current view: sensor, trajectory, parameters, scans in the map."""
        replay = self.replay
        return LogView(self._topic, replay.trajectory, asdict(replay.config), replay.index, self._cut)

    def cut_table(self) -> Table | None:
        """Return the options for cutting the scans, and their values; None for a lidar."""
        names = {part.topic for part in (self.log.parts if isinstance(self.log, JointLog) else (self.log,))}
        kinds = {topic.type for topic in self.log.topics if topic.name in names}
        rows = [row for row in CUT_PARAMETERS if any(applies(row, kind) for kind in kinds)]
        values = PlanarCut.of(self._cut or {}).values
        return Table(rows_of(rows), {row.name: values[row.name] for row in rows}) if rows else None

    def use(self, log: ScanLog, view: LogView) -> None:
        """Restart with another sensor of the log, or with other options for cutting scans (worker thread).

        Parameters are kept, except those that the sensor sets. Raises like :meth:`choose`, without changes.
        """
        old = self.replay
        changed = changed_values(old.config, first_config(self.log))
        trajectory = old.trajectory if old.trajectory in log.trajectories else None
        new_view = replace(view, trajectory=trajectory, values=asdict(first_config(log).with_values(changed)))
        self.replay = first_replay(log, new_view, self._host.limits(), old.may_continue)
        self.recorded = recorded_seconds(log)
        self._topic, self._cut = view.topic, view.cut
        self._examinations.clear()

    def choose(self, trajectory: str) -> None:
        """Restart the map with another trajectory (worker thread). Raises like :class:`Replay`, without changes."""
        self._replay_with(self.log, trajectory)

    def update(self, log: ScanLog) -> bool:
        """Continue with ``log``, the same scans with other trajectories (worker thread); return whether the map is new.

        The current trajectory is kept, even if ``log`` does not contain it. Raises like :meth:`choose`, without
        changes.
        """
        old = self.replay
        name = old.trajectory
        if name not in log.trajectories:
            log = replace(log, trajectories={**log.trajectories, name: self.log.trajectory(name)})
        for trajectory_name, trajectory in log.trajectories.items():
            known = self.log.trajectories.get(trajectory_name)
            if known is None or not np.array_equal(known.known_poses, trajectory.known_poses, equal_nan=True):
                self._examinations.pop(trajectory_name, None)
        if old.adopt(log):
            return False
        self._replay_with(log, name)
        return True

    def show(self, log: ScanLog, trajectory: str) -> bool:
        """Continue with ``log``, the same scans, and a trajectory (worker thread); return whether the map is new.

        Otherwise it is unchanged. Raises like :meth:`choose`, without changes.
        """
        self._examinations.pop(trajectory, None)
        if trajectory == self.trajectory and self.replay.adopt(log):
            return False
        self._replay_with(log, trajectory)
        return True

    def _replay_with(self, log: ScanLog, trajectory: str) -> None:
        """Restart the map of ``log`` with one of its trajectories."""
        old = self.replay
        replay = Replay(log, old.config, trajectory, self._host.limits())
        replay.may_continue = old.may_continue
        self.replay = replay

    def robot_state(self) -> RobotState:
        """Return the newest scan in the map; before the first scan, its pose without readings."""
        index = self.replay.index
        newest = max(index - 1, 0)
        placed = placed_scan(self.log, self.replay.config, self.trajectory, newest)
        scan = placed.scan
        if index == 0:
            scan = replace(scan, ranges=np.full_like(scan.ranges, np.nan))
        sensor = pose_tuple(placed.sensor_pose)
        return RobotState(pose_tuple(placed.base_pose), sensor, sensor, scan, float(self.recorded[newest]))

    def sources(self) -> list[MappedScans]:
        """Return the scans in the map."""
        return [MappedScans(self.log, self.trajectory, self.replay.index, self.recorded)]

    async def growing_map(self) -> tuple[GrowingMap, str]:
        """Return the current map as a sequence of scans, and the name of its trajectory, between two ticks."""
        async with self._host.settled():
            replay = self.replay
            return GrowingMap(replay.grid, replay.config, replay.index), replay.trajectory

    def map_series(self) -> Series | float:
        """Return the series of the map, or the completed share; see :class:`MapSeries`."""
        return self._map_series.look_up(self.replay)

    @property
    def examined_share(self) -> float | None:
        """Completed share of the examination with the current trajectory; None before it has started."""
        known = self._examinations.get(self.trajectory)
        return None if known is None else known.share

    @property
    def diagnosis(self) -> Diagnosis | None:
        """Diagnosis with the current trajectory; None unless an examination has finished without an error."""
        known = self._examinations.get(self.trajectory)
        is_there = known is not None and known.future.done() and not known.future.cancelled()
        return known.future.result() if known and is_there and known.future.exception() is None else None

    async def examined(self) -> Diagnosis:
        """Return the diagnosis of the log with the current trajectory.

        Requests during an examination wait for its result. It ends when the last of them was cancelled, and with the
        session. After a failure or an early end, the next request starts it again. Raises like
        :func:`mapper.diagnosis.diagnose`.
        """
        name = self.trajectory
        known = self._examinations.get(name)
        if known is None or (known.future.done() and known.future.exception() is not None):
            known = self._examinations[name] = self._examination(name)
        known.waiting += 1
        try:
            return await asyncio.shield(known.future)
        finally:
            known.waiting -= 1
            if not known.is_wanted and not known.future.done() and self._examinations.get(name) is known:
                del self._examinations[name]

    def _examination(self, trajectory: str) -> _Examination:
        host, log = self._host, self.log
        goes_on = host.in_background()
        result = _Examination()

        def progress(share: float) -> None:
            result.share = share

        def may_continue() -> bool:
            return result.is_wanted and goes_on()

        result.future = asyncio.ensure_future(
            examination(log, trajectory, host.scheduler, host.job_owner, may_continue, progress)
        )
        result.future.add_done_callback(
            lambda done: done.cancelled() or done.exception()
        )  # so that its exception is not logged as never retrieved
        return result


T = TypeVar("T")

AT_ONCE = 2  #: maximum number of logs that the whole service examines at the same time

_TURNS = Scheduler(AT_ONCE)
_EXAMINERS = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="doctor", initializer=lower_priority)


async def in_turn(scheduler: Scheduler, job_owner: JobOwner, job: Callable[[], T]) -> T:
    """Return the result of ``job``, run on a thread that the scheduler grants. Raises like ``job``."""
    turn = _TURNS.request(job_owner, interactive=False)
    try:
        await asyncio.wrap_future(turn.granted)
        return await scheduler.run(_EXAMINERS, job_owner, job, interactive=False)
    finally:
        _TURNS.release(turn)


async def examination(
    log: ScanLog,
    trajectory: str,
    scheduler: Scheduler,
    job_owner: JobOwner,
    may_continue: Callable[[], bool],
    progress: Callable[[float], None],
) -> Diagnosis:
    """Return the diagnosis of a log. Raises like :func:`mapper.diagnosis.diagnose`, which checks ``may_continue``.

    ``progress`` is called with the completed share, on a worker thread.
    """

    def examined() -> Diagnosis:
        return diagnosis.diagnose(log, trajectory, progress, may_continue=may_continue)

    return await in_turn(scheduler, job_owner, examined)
