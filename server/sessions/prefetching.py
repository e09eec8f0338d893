"""Prepares seeks in idle time: stores the checkpoints of logs that were not played to their end.

One log at a time in the whole service, on one thread of its own, at most half of the time, and only while no session
computes or has commands. A command to the session ends it at once; it begins again once the session had no command for
:data:`QUIET_S`.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol
from weakref import WeakSet

import structlog

from mapper.replay.incremental import CheckpointPrefetcher

LOOK_EVERY_S = 0.25
QUIET_S = 1.0  #: without a command to a session before its log is prepared
PAUSE_S = 0.02

_log = structlog.get_logger(__name__)


class Prefetchable(Protocol):
    """What prefetching needs of a session."""

    closed: bool
    commanded_at: float

    @property
    def cells(self) -> int:
        """Cells of its maps."""

    @property
    def watched(self) -> bool:
        """Whether a client or a 3D view shows it."""

    @property
    def is_busy(self) -> bool:
        """Whether it computes, or has commands."""

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return what stores its missing checkpoints; None where there is nothing to do."""


class CheckpointPrefetching:
    """Prepares the sessions that ``sessions`` returns, where there ``is_room`` for another map of that size."""

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
        """Prepare whatever there is, until cancelled."""
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
            if not any(one.is_busy for one in self._sessions()):
                prefetcher = prefetcher or session.prefetcher()
                if prefetcher is None or not await self._step(session, prefetcher):
                    return
            await asyncio.sleep(max(PAUSE_S, self._clock() - began))

    async def _step(self, session: Prefetchable, prefetcher: CheckpointPrefetcher) -> bool:
        try:
            return await asyncio.get_running_loop().run_in_executor(self._thread, prefetcher.step)
        except Exception:  # noqa: BLE001 - a defect in prefetching must not stop the service
            _log.exception("a log could not be prepared")
            self._failed.add(session)
            return False

    def _may(self, session: Prefetchable) -> bool:
        is_idle = session.watched and not session.closed and self._clock() - session.commanded_at >= QUIET_S
        return is_idle and session not in self._failed and self._is_room(session)
