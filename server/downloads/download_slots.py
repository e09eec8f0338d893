"""Limits on concurrent downloads: in total, of guests, and per visitor, address and link, with a queue."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

from mapper.core.errors import LimitError
from server.network_address import network_of

MAX_AT_ONCE = 8  #: running downloads of all visitors
MAX_OF_GUESTS = 4  #: running downloads of all guests
MAX_PER_KEY = 2  #: of one visitor, of one address, of one link
MAX_WAITING = 8  #: waiting requests with one key
WAIT_S = 30.0  #: longest wait of a request


class BusyError(LimitError):
    """The limit on concurrent downloads is reached."""


@dataclass(frozen=True, slots=True, eq=False)
class Requester:
    """Requester of a download. The limit holds for each of ``keys`` (a visitor, an address, a link)."""

    keys: tuple[str, ...]
    is_guest: bool


def requester(visitor: str, address: str | None, link: str | None) -> Requester:
    """Return a requester: by visitor and by address, because cookies can be dropped, and for a guest by link."""
    keys = [f"visitor {visitor}"]
    if address is not None:
        keys.append(f"address {network_of(address)}")
    if link is not None:
        keys.append(f"link {link}")
    return Requester(tuple(keys), link is not None)


class DownloadSlots:
    """The download slots of the service. Used on the event loop only."""

    def __init__(self, wait_s: float = WAIT_S) -> None:
        self._wait_s = wait_s
        self._taken: Counter[str] = Counter()
        self._all = self._guests = 0
        self._waiting: list[tuple[Requester, asyncio.Future[None]]] = []

    @property
    def taken(self) -> int:
        """Number of downloads that hold a slot."""
        return self._all

    @asynccontextmanager
    async def hold(self, who: Requester) -> AsyncIterator[None]:
        """Wait for a slot (first come, first served) and hold it during the block.

        Raises :class:`BusyError` if none becomes free in time, or too many requests with one of its keys are already
        waiting.
        """
        if self._fits(who):
            self._take(who)
        else:
            await self._wait(who)
        try:
            yield
        finally:
            self._release(who)

    async def _wait(self, who: Requester) -> None:
        for key in who.keys:
            if sum(key in other.keys for other, _ in self._waiting) >= MAX_WAITING:
                raise BusyError(
                    "download.too_many",
                    f"{MAX_WAITING} of your downloads are waiting already; try again when they are finished.",
                )
        entry = (who, asyncio.get_running_loop().create_future())
        self._waiting.append(entry)
        try:
            await asyncio.wait([entry[1]], timeout=self._wait_s)
        except asyncio.CancelledError:
            if entry[1].done():
                self._release(who)
            raise
        finally:
            if entry in self._waiting:
                self._waiting.remove(entry)
        if not entry[1].done():
            raise self._refusal(who)

    def _refusal(self, who: Requester) -> BusyError:
        if any(self._taken[key] >= MAX_PER_KEY for key in who.keys):
            return BusyError(
                "download.too_many",
                f"{MAX_PER_KEY} downloads by you, from your address or by this link are running, the maximum; "
                "try again when one of them is finished.",
            )
        return BusyError("download.busy", "Too many downloads are running; try again in a minute.")

    def _fits(self, who: Requester) -> bool:
        return (
            self._all < MAX_AT_ONCE
            and not (who.is_guest and self._guests >= MAX_OF_GUESTS)
            and all(self._taken[key] < MAX_PER_KEY for key in who.keys)
        )

    def _take(self, who: Requester) -> None:
        self._all += 1
        self._guests += who.is_guest
        self._taken.update(who.keys)

    def _release(self, who: Requester) -> None:
        self._all -= 1
        self._guests -= who.is_guest
        self._taken -= Counter(who.keys)  # removes keys with none left
        for entry in (*self._waiting,):
            waiting, turn = entry
            if self._fits(waiting):
                self._take(waiting)
                turn.set_result(None)
                self._waiting.remove(entry)
