"""Limits on concurrent uploads, and the choice of the upload to cancel when others wait.

The speed of an upload is bytes per second of waiting for data; time spent in the store does not count. An upload that
is too slow is cancelled. While others wait for a slot, the limit is higher, and uploads of the address with the most
uploads are cancelled first. An upload in parts can be continued later.
"""

from __future__ import annotations

import asyncio
import math
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

from mapper.core.errors import LimitError

LEAST_BYTES_PER_S = 4096  #: average over ``idle_s`` seconds below which an upload is cancelled
SLOW_BYTES_PER_S = 32_768  #: a slower upload may be cancelled for a waiting one
MEASURED_S = 2.0  #: seconds of waiting over which an upload's speed is measured
WAIT_S = 10.0  #: seconds that an upload waits for a slot
LOOK_EVERY_S = 0.2


class UploadSlot:
    """The slot of one upload. It is cancelled when almost no data arrives for ``idle_s`` seconds."""

    def __init__(self, owner: str, address: str, idle_s: float) -> None:
        self.owner = owner
        self.address = address
        self.is_given_up = False
        self._idle_s = idle_s
        self._clock = asyncio.get_running_loop().time
        self._limit: asyncio.Timeout | None = None  #: of the current wait for data
        self._since_s = 0.0  #: start of that wait
        self._waited_s, self._bytes = 0.0, 0  #: since the speed was last measured
        self._speed = math.inf

    def speed(self) -> float:
        """Return the bytes received per second of waiting; infinity before the first measurement."""
        waited = self._waited_s + (0.0 if self._limit is None else self._clock() - self._since_s)
        return self._bytes / waited if waited >= MEASURED_S else self._speed

    def give_up(self) -> None:
        """Cancel the upload: :meth:`read` raises as soon as possible."""
        self.is_given_up = True
        if self._limit is not None and not self._limit.expired():
            self._limit.reschedule(self._clock())

    async def read(self, chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
        """Yield the chunks. Raises :class:`LimitError` if they arrive too slowly, or :meth:`give_up` was called."""
        waited, come = 0.0, 0
        while True:
            if self.is_given_up:
                raise self._too_slow()
            self._since_s = self._clock()
            try:
                async with asyncio.timeout(self._idle_s - waited) as self._limit:
                    chunk = await anext(chunks)
            except StopAsyncIteration:
                return
            except TimeoutError:
                raise self._too_slow() from None
            finally:
                self._limit = None
            took = self._clock() - self._since_s
            waited, come = waited + took, come + len(chunk)
            if come >= LEAST_BYTES_PER_S * self._idle_s:
                waited, come = 0.0, 0
            self._measure(took, len(chunk))
            yield chunk

    def _too_slow(self) -> LimitError:
        if self.is_given_up:
            message = "The upload is slow and other uploads are waiting; try again in a moment."
            return LimitError("library.busy", message)
        return LimitError("log.stalled", f"Almost no data of the upload arrived in {self._idle_s:g} s.")

    def _measure(self, took: float, size: int) -> None:
        self._waited_s += took
        self._bytes += size
        if self._waited_s >= MEASURED_S:
            self._speed = self._bytes / self._waited_s
            self._waited_s, self._bytes = 0.0, 0


@dataclass(frozen=True, slots=True, eq=False)
class _Waiting:
    owner: str
    address: str
    slot: asyncio.Future[UploadSlot]


class UploadSlots:
    """At most ``most`` concurrent uploads, ``most_of_owner`` of one owner. Used on the event loop only."""

    def __init__(self, most: int, most_of_owner: int, idle_s: float) -> None:
        self._most = most
        self._most_of_owner = most_of_owner
        self._idle_s = idle_s
        self._taken: list[UploadSlot] = []
        self._waiting: list[_Waiting] = []
        self._timer: asyncio.TimerHandle | None = None
        self._is_closed = False
        self._all_free = asyncio.Event()
        self._all_free.set()

    def __len__(self) -> int:
        return len(self._taken)

    def of(self, owner: str) -> int:
        """Return how many uploads of ``owner`` have a slot or wait for one."""
        return [slot.owner for slot in self._taken].count(owner) + [slot.owner for slot in self._waiting].count(owner)

    @asynccontextmanager
    async def take(self, owner: str, address: str) -> AsyncIterator[UploadSlot]:
        """Wait for a slot and hold it during the block. Raises :class:`LimitError` if none becomes free in time."""
        if self._is_closed or self.of(owner) >= self._most_of_owner:
            raise _busy()
        self._all_free.clear()
        waiting = _Waiting(owner, address, asyncio.get_running_loop().create_future())
        self._waiting.append(waiting)
        self._share_out()
        try:
            if not waiting.slot.done():  # if the client disconnects during the wait, its data is lost
                await asyncio.wait([waiting.slot], timeout=WAIT_S)
            if not waiting.slot.done():
                raise _busy()
            yield waiting.slot.result()
        finally:
            if waiting.slot.done():
                self._taken.remove(waiting.slot.result())
            else:
                self._waiting.remove(waiting)
            self._share_out()
            if not self._taken and not self._waiting:
                self._all_free.set()

    async def close(self) -> None:
        """Refuse all further uploads, and wait until the running ones have ended."""
        self._is_closed = True
        await self._all_free.wait()

    def _share_out(self) -> None:
        """Give free slots to waiting uploads, fewest of an address first; for the rest, cancel slow uploads."""
        uploads = Counter(slot.address for slot in self._taken)
        for waiting in sorted(self._waiting, key=lambda slot: uploads[slot.address]):
            if len(self._taken) < self._most:
                slot = UploadSlot(waiting.owner, waiting.address, self._idle_s)
                self._taken.append(slot)
                self._waiting.remove(waiting)
                waiting.slot.set_result(slot)
        leaving = sum(slot.is_given_up for slot in self._taken)
        for waiting in self._waiting[leaving:]:
            slow = [slot for slot in self._taken if self._makes_room(slot, uploads[waiting.address], uploads)]
            if slow:
                min(slow, key=lambda slot: (-uploads[slot.address], slot.speed())).give_up()
        if self._waiting and self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(LOOK_EVERY_S, self._look)

    def _makes_room(self, slot: UploadSlot, newcomers: int, uploads: Counter[str]) -> bool:
        """Return whether to cancel an upload for one from an address with ``newcomers`` uploads."""
        if slot.is_given_up:
            return False
        speed = slot.speed()
        return speed < SLOW_BYTES_PER_S or (speed < math.inf and uploads[slot.address] >= newcomers + 2)

    def _look(self) -> None:
        self._timer = None
        self._share_out()


def _busy() -> LimitError:
    return LimitError("library.busy", "Too many uploads are under way; try again in a moment.")
