"""Slots for downloads: so many of all, of guests and of each party; the others wait in line, or are refused."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator

import pytest

from server.downloads import BusyError, DownloadSlots
from server.downloads.download_slots import MAX_AT_ONCE, MAX_LINE, MAX_OF_GUESTS, MAX_OF_PARTY, Asker, asker
from tests.server.service import eventually


def other(number: int, *, is_guest: bool = False) -> Asker:
    """Somebody who shares nothing with others of another number."""
    return Asker((f"visitor {number}", f"address {number}"), is_guest)


@contextlib.asynccontextmanager
async def held(slots: DownloadSlots, *who: Asker) -> AsyncIterator[None]:
    async with contextlib.AsyncExitStack() as stack:
        for one in who:
            await stack.enter_async_context(slots.hold(one))
        yield


@pytest.mark.parametrize(
    "askers",
    [
        [asker("ann", f"10.0.0.{n}", None) for n in range(3)],
        [asker(f"visitor{n}", "10.0.0.1", None) for n in range(3)],
        [asker(f"visitor{n}", f"2001:db8::{n}", None) for n in range(3)],
        [asker(f"visitor{n}", ["::ffff:10.0.0.1", "10.0.0.1"][n % 2], None) for n in range(3)],
        [asker(f"visitor{n}", f"10.0.0.{n}", "a link") for n in range(3)],
    ],
    ids=["visitor", "address", "network", "IPv4 in IPv6", "link"],
)
async def test_each_party_has_two(askers: list[Asker]) -> None:
    slots = DownloadSlots(wait_s=0.01)
    async with held(slots, *askers[:MAX_OF_PARTY]):
        with pytest.raises(BusyError) as caught:
            async with slots.hold(askers[2]):
                pass
        assert caught.value.code == "download.too_many"
        async with slots.hold(asker("somebody else", "192.168.0.1", None)):
            assert slots.taken == MAX_OF_PARTY + 1
    assert slots.taken == 0
    async with slots.hold(askers[2]):
        pass


async def test_all_have_only_so_many_and_guests_fewer() -> None:
    slots = DownloadSlots(wait_s=0.01)
    guests = [other(n, is_guest=True) for n in range(MAX_OF_GUESTS + 1)]
    async with held(slots, *guests[:-1]):
        with pytest.raises(BusyError) as caught:
            async with slots.hold(guests[-1]):
                pass
        assert caught.value.code == "download.busy"
        async with held(slots, *[other(100 + n) for n in range(MAX_AT_ONCE - MAX_OF_GUESTS)]):
            with pytest.raises(BusyError):
                async with slots.hold(other(200)):
                    pass


async def test_who_waits_comes_first_served_and_passes_those_whose_own_places_are_taken() -> None:
    slots = DownloadSlots(wait_s=60.0)
    served: list[str] = []
    release = asyncio.Event()

    async def take(who: Asker, name: str) -> None:
        async with slots.hold(who):
            served.append(name)
            await release.wait()

    async with held(slots, other(1), other(1)):
        async with held(slots, *[other(2 + n // 2) for n in range(MAX_AT_ONCE - 2)]):
            waiting = []
            for who, name in ((other(1), "greedy"), (other(50), "first"), (other(51), "second")):
                waiting.append(asyncio.create_task(take(who, name)))
                await asyncio.sleep(0)
            assert served == []
        await eventually(lambda: served == ["first", "second"])
    await eventually(lambda: served == ["first", "second", "greedy"])
    release.set()
    await asyncio.gather(*waiting)
    assert slots.taken == 0


async def test_the_line_of_one_party_is_bounded_and_who_leaves_it_takes_nothing() -> None:
    slots = DownloadSlots(wait_s=60.0)

    async def take(number: int) -> None:
        async with slots.hold(asker(f"visitor{number}", "10.0.0.1", None)):
            pass

    async with held(slots, other(1), other(2)):
        async with held(slots, *[asker("x", "10.0.0.1", None)] * MAX_OF_PARTY):
            waiting = [asyncio.create_task(take(number)) for number in range(MAX_LINE)]
            await asyncio.sleep(0)
            with pytest.raises(BusyError) as caught:
                await take(100)
            assert caught.value.code == "download.too_many"
            for task in waiting[1:]:
                task.cancel()
            await asyncio.gather(*waiting[1:], return_exceptions=True)
            late = asyncio.create_task(take(101))
            await asyncio.sleep(0)
        late.cancel()  # a place was given to it at this very moment
        await asyncio.gather(*waiting, late, return_exceptions=True)
        assert slots.taken == 2
