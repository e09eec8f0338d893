"""A lock that is granted to its waiting owners in rotation, so that no owner's queue starves another's."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager


class FairLock:
    """A lock that ``places`` may hold at once, with a queue for each owner. Used from one event loop only."""

    def __init__(self, places: int = 1) -> None:
        self._places = self._free = places  #: free is negative where more hold it than may
        self._waiting: dict[str, deque[asyncio.Future[None]]] = {}  #: by owner, the next one first

    def resize(self, places: int) -> None:
        """Let ``places`` hold it at once; who holds it keeps it."""
        self._free += places - self._places
        self._places = places
        self._grant()

    @asynccontextmanager
    async def of(self, owner: str) -> AsyncIterator[None]:
        """Acquire the lock for ``owner`` and hold it during the block."""
        if self._free <= 0:
            request: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._waiting.setdefault(owner, deque()).append(request)
            try:
                await request
            except asyncio.CancelledError:
                if request.done() and not request.cancelled():
                    self._release()  # the lock was granted while this task was being cancelled
                raise
        else:
            self._free -= 1
        try:
            yield
        finally:
            self._release()

    def _release(self) -> None:
        self._free += 1
        self._grant()

    def _grant(self) -> None:
        """Grant what is free to the first owner's oldest request, and put that owner last."""
        while self._free > 0 and self._waiting:
            owner = next(iter(self._waiting))
            queue = self._waiting.pop(owner)
            request = queue.popleft()
            if queue:
                self._waiting[owner] = queue
            if not request.done():
                self._free -= 1
                request.set_result(None)
