"""Limits on concurrent downloads: in total, of guests, and per visitor, address and link, with a queue."""

from __future__ import annotations

import asyncio
import ipaddress
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

from mapper.core.errors import LimitError

MAX_AT_ONCE = 8  #: running downloads of all visitors
MAX_OF_GUESTS = 4  #: running downloads of all guests
MAX_OF_PARTY = 2  #: of one visitor, of one address, of one link
MAX_LINE = 8  #: requests of one party that wait for a slot
WAIT_S = 30.0  #: a request waits no longer than this


class BusyError(LimitError):
    """The limit on concurrent downloads is reached."""


@dataclass(frozen=True, slots=True, eq=False)
class Asker:
    """The requester of a download. The limit holds for each of ``parties`` (a visitor, an address, a link)."""

    parties: tuple[str, ...]
    is_guest: bool


def asker(visitor: str, address: str | None, link: str | None) -> Asker:
    """Return a requester: by visitor and by address, since cookies can be dropped, and for a guest by link."""
    parties = [f"visitor {visitor}"]
    if address is not None:
        parties.append(f"address {_network(address)}")
    if link is not None:
        parties.append(f"link {link}")
    return Asker(tuple(parties), link is not None)


def _network(address: str) -> str:
    """Return an address, for IPv6 its /64 network: one machine can use all addresses of it."""
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if found.version == 4:
        return str(found)
    mapped = found.ipv4_mapped
    return str(mapped or ipaddress.ip_network((found, 64), strict=False))


class DownloadSlots:
    """The download slots of the service. Used on the event loop only."""

    def __init__(self, wait_s: float = WAIT_S) -> None:
        self._wait_s = wait_s
        self._taken: Counter[str] = Counter()
        self._all = self._guests = 0
        self._line: list[tuple[Asker, asyncio.Future[None]]] = []

    @property
    def taken(self) -> int:
        """Downloads that hold a slot."""
        return self._all

    @asynccontextmanager
    async def hold(self, who: Asker) -> AsyncIterator[None]:
        """Wait for a slot (first come, first served) and hold it during the block.

        Raises :class:`BusyError` if none becomes free in time, or too many requests of one party wait already.
        """
        if self._fits(who):
            self._take(who)
        else:
            await self._wait(who)
        try:
            yield
        finally:
            self._give_back(who)

    async def _wait(self, who: Asker) -> None:
        for party in who.parties:
            if sum(party in other.parties for other, _ in self._line) >= MAX_LINE:
                raise BusyError(
                    "download.too_many",
                    f"{MAX_LINE} of your downloads are waiting already; try again when they are finished.",
                )
        entry = (who, asyncio.get_running_loop().create_future())
        self._line.append(entry)
        try:
            await asyncio.wait([entry[1]], timeout=self._wait_s)
        except asyncio.CancelledError:
            if entry[1].done():
                self._give_back(who)
            raise
        finally:
            if entry in self._line:
                self._line.remove(entry)
        if not entry[1].done():
            raise self._refusal(who)

    def _refusal(self, who: Asker) -> BusyError:
        if any(self._taken[party] >= MAX_OF_PARTY for party in who.parties):
            return BusyError(
                "download.too_many",
                f"{MAX_OF_PARTY} downloads of yours, of your address or by this link run, as many as may at one time; "
                "try again when one of them is done.",
            )
        return BusyError("download.busy", "Too many downloads are running; try again in a minute.")

    def _fits(self, who: Asker) -> bool:
        return (
            self._all < MAX_AT_ONCE
            and not (who.is_guest and self._guests >= MAX_OF_GUESTS)
            and all(self._taken[party] < MAX_OF_PARTY for party in who.parties)
        )

    def _take(self, who: Asker) -> None:
        self._all += 1
        self._guests += who.is_guest
        self._taken.update(who.parties)

    def _give_back(self, who: Asker) -> None:
        self._all -= 1
        self._guests -= who.is_guest
        self._taken -= Counter(who.parties)  # drops parties with none left
        for entry in (*self._line,):
            waiting, turn = entry
            if self._fits(waiting):
                self._take(waiting)
                turn.set_result(None)
                self._line.remove(entry)
