"""Compute checkpoints of logs in idle time, so that later seeks are fast.

Only one log of the whole service is processed at a time, on a separate thread, for at most half of the time, and only
while no session computes or has commands. A command to the session interrupts it; it resumes after :data:`QUIET_S`
without commands.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Protocol
from weakref import WeakSet

import structlog

if TYPE_CHECKING:
    from mapper.replay.replay import CheckpointPrefetcher

LOOK_EVERY_S = 0.25
QUIET_S = 1.0  #: seconds without a command to a session before prefetching
PAUSE_S = 0.02

_log = structlog.get_logger(__name__)


class Prefetchable(Protocol):
    """The interface of a session that prefetching uses."""

    closed: bool
    commanded_at: float

    @property
    def cells(self) -> int:
        """Cells of the session's maps."""

    @property
    def watched(self) -> bool:
        """Whether the session has a client or a 3D view."""

    @property
    def is_busy(self) -> bool:
        """Whether the session is computing or has queued commands."""

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return the prefetcher of missing checkpoints; None if none is missing."""


class CheckpointPrefetching:
    """Task that prefetches for the sessions that ``sessions`` returns, if ``is_room`` for another map of that size."""

    def __init__(
        self,
        sessions: Callable[[], Sequence[Prefetchable]],
        is_room: Callable[[Prefetchable], bool],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._sessions, self._is_room, self._clock = sessions, is_room, clock
        self._failed: WeakSet[Prefetchable] = WeakSet()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="prefetch")

    async def run(self) -> None:
        """Prefetch until cancelled."""
        try:
            while True:
                await asyncio.sleep(LOOK_EVERY_S)
                for session in self._sessions():
                    await self._prefetch(session)
        finally:
            self._thread.shutdown(wait=False, cancel_futures=True)

    async def _prefetch(self, session: Prefetchable) -> None:
        prefetcher: CheckpointPrefetcher | None = None
        while self._may(session):
            began = self._clock()
            if not any(session.is_busy for session in self._sessions()):
                prefetcher = prefetcher or session.prefetcher()
                # Checking for room comes last because it goes through all sessions of the service.
                if prefetcher is None or not self._is_room(session) or not await self._step(session, prefetcher):
                    return
            await asyncio.sleep(max(PAUSE_S, self._clock() - began))

    async def _step(self, session: Prefetchable, prefetcher: CheckpointPrefetcher) -> bool:
        try:
            return await asyncio.get_running_loop().run_in_executor(self._thread, prefetcher.step)
        except Exception:  # noqa: BLE001 - a defect in prefetching must not stop the service
            _log.exception("prefetching failed")
            self._failed.add(session)
            return False

    def _may(self, session: Prefetchable) -> bool:
        is_idle = session.watched and not session.closed and self._clock() - session.commanded_at >= QUIET_S
        return is_idle and session not in self._failed
