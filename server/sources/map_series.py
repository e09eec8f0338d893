"""The series of a session's map for plots, computed when it is asked for."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, TypeAlias

from mapper.core.errors import WorkCancelledError
from mapper.mapping.parameters import MappingConfig
from mapper.replay import Replay
from mapper.sensors.scan import Trajectory
from server.sessions.hosting import ModelHost
from server.sources.diagnosing import in_turn

if TYPE_CHECKING:
    from mapper.io.contents.model import Series

IDLE_S = 20.0  #: a computation that nobody asks for during this time ends

Of: TypeAlias = tuple[Trajectory, MappingConfig]


class MapSeries:
    """The newest series of a session's map, and the share that is done while it is computed. For the event loop."""

    def __init__(self, host: ModelHost) -> None:
        self._host = host
        self._of: Of | None = None
        self._job: asyncio.Future[Series] | None = None
        self._asked = 0.0
        self._share = 0.0

    def look_up(self, replay: Replay) -> Series | float:
        """Return the series of the log of ``replay``, with its parameters, or the share that is done.

        Raises as :func:`mapper.replay.map_series.map_series`.
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

    def _begin(self, replay: Replay, of: Of) -> float:
        host, goes_on = self._host, self._host.in_background()
        log, config, trajectory, limits = replay.log, replay.config, replay.trajectory, host.limits()
        self._of, self._share = of, 0.0

        def progress(share: float) -> None:
            if self._of is of:
                self._share = share

        def wanted() -> bool:
            return self._of is of and time.monotonic() - self._asked < IDLE_S and goes_on()

        def computed() -> Series:
            from mapper.replay.map_series import map_series  # noqa: PLC0415 - imports SciPy, which few sessions need

            return map_series(log, config, trajectory, limits, progress, wanted)

        self._job = asyncio.ensure_future(in_turn(host.scheduler, host.job_owner, computed))
        self._job.add_done_callback(lambda done: done.cancelled() or done.exception())  # it is told when asked for
        return 0.0
