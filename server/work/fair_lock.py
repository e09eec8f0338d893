"""A lock that is granted in rotation to the waiting addresses, and to the waiting owners of each.

No owner's queue can therefore starve another's, nor can the owners that a client creates by dropping its cookie.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager


class FairLock:
    """A lock with ``places`` simultaneous holders, and a queue for each owner of each address.

    Used from one event loop only.
    """

    def __init__(self, places: int = 1) -> None:
        self._places = self._free = places  #: free is negative while there are more holders than places
        #: by address and owner, the next ones first
        self._waiting: dict[str, dict[str, deque[asyncio.Future[None]]]] = {}

    def resize(self, places: int) -> None:
        """Set the number of holders to ``places``. Current holders keep it."""
        self._free += places - self._places
        self._places = places
        self._grant()

    @asynccontextmanager
    async def of(self, owner: str, address: str = "") -> AsyncIterator[None]:
        """Acquire the lock for ``owner``, a client at this network ``address``, and hold it during the block."""
        if self._free <= 0:
            request: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._waiting.setdefault(address, {}).setdefault(owner, deque()).append(request)
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

    def keeps_waiting(self, owner: str) -> bool:
        """Return whether anyone other than ``owner`` waits for the lock."""
        return any(waits != owner for owners in self._waiting.values() for waits in owners)

    def _release(self) -> None:
        self._free += 1
        self._grant()

    def _grant(self) -> None:
        """Grant free places to the oldest request of the first owner of the first address, and move both to the end."""
        while self._free > 0 and self._waiting:
            address = next(iter(self._waiting))
            owners = self._waiting.pop(address)
            owner = next(iter(owners))
            queue = owners.pop(owner)
            request = queue.popleft()
            if queue:
                owners[owner] = queue
            if owners:
                self._waiting[address] = owners
            if not request.done():
                self._free -= 1
                request.set_result(None)
