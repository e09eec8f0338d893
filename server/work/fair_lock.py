"""A lock that is granted to its waiting owners in rotation, so that no owner's queue starves another's."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager


class FairLock:
    """A lock that ``places`` may hold at once, with a queue for each owner. Used from one event loop only."""

    def __init__(self, places: int = 1) -> None:
        self._free = places
        self._waiting: dict[str, deque[asyncio.Future[None]]] = {}  #: by owner, the next one first

    @asynccontextmanager
    async def of(self, owner: str) -> AsyncIterator[None]:
        """Acquire the lock for ``owner`` and hold it during the block."""
        if self._free == 0:
            request: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._waiting.setdefault(owner, deque()).append(request)
            try:
                await request
            except asyncio.CancelledError:
                if request.done() and not request.cancelled():
                    self._grant_next()  # the lock was granted while this task was being cancelled
                raise
        else:
            self._free -= 1
        try:
            yield
        finally:
            self._grant_next()

    def _grant_next(self) -> None:
        """Grant the lock to the first owner's oldest request, and put that owner last."""
        while self._waiting:
            owner = next(iter(self._waiting))
            queue = self._waiting.pop(owner)
            request = queue.popleft()
            if queue:
                self._waiting[owner] = queue
            if not request.done():
                request.set_result(None)
                return
        self._free += 1
