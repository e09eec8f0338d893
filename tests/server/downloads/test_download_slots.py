"""Limits on concurrent downloads: in total, of guests, and per visitor, address and link, with a queue."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator

import pytest

from server.downloads import BusyError, DownloadSlots
from server.downloads.download_slots import MAX_AT_ONCE, MAX_OF_GUESTS, MAX_PER_KEY, MAX_WAITING, Requester, requester
from tests.server.service import eventually


def other(number: int, *, is_guest: bool = False) -> Requester:
    """A requester that shares no key with those of other numbers."""
    return Requester((f"visitor {number}", f"address {number}"), is_guest)


@contextlib.asynccontextmanager
async def held(slots: DownloadSlots, *who: Requester) -> AsyncIterator[None]:
    async with contextlib.AsyncExitStack() as stack:
        for one in who:
            await stack.enter_async_context(slots.hold(one))
        yield


@pytest.mark.parametrize(
    "requesters",
    [
        [requester("ann", f"10.0.0.{n}", None) for n in range(3)],
        [requester(f"visitor{n}", "10.0.0.1", None) for n in range(3)],
        [requester(f"visitor{n}", f"2001:db8::{n}", None) for n in range(3)],
        [requester(f"visitor{n}", ["::ffff:10.0.0.1", "10.0.0.1"][n % 2], None) for n in range(3)],
        [requester(f"visitor{n}", f"10.0.0.{n}", "a link") for n in range(3)],
    ],
    ids=["visitor", "address", "network", "IPv4 in IPv6", "link"],
)
async def test_each_visitor_address_network_and_link_has_two(requesters: list[Requester]) -> None:
    slots = DownloadSlots(wait_s=0.01)
    async with held(slots, *requesters[:MAX_PER_KEY]):
        with pytest.raises(BusyError) as caught:
            async with slots.hold(requesters[2]):
                pass
        assert caught.value.code == "download.too_many"
        async with slots.hold(requester("somebody else", "192.168.0.1", None)):
            assert slots.taken == MAX_PER_KEY + 1
    assert slots.taken == 0
    async with slots.hold(requesters[2]):
        pass


async def test_guests_have_fewer_slots_than_all_visitors() -> None:
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


async def test_waiting_requests_are_served_in_order_except_those_over_their_own_limit() -> None:
    slots = DownloadSlots(wait_s=60.0)
    served: list[str] = []
    release = asyncio.Event()

    async def take(who: Requester, name: str) -> None:
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


async def test_the_waiting_requests_of_one_key_are_limited_and_cancelled_ones_take_no_slot() -> None:
    slots = DownloadSlots(wait_s=60.0)

    async def take(number: int) -> None:
        async with slots.hold(requester(f"visitor{number}", "10.0.0.1", None)):
            pass

    async with held(slots, other(1), other(2)):
        async with held(slots, *[requester("x", "10.0.0.1", None)] * MAX_PER_KEY):
            waiting = [asyncio.create_task(take(number)) for number in range(MAX_WAITING)]
            await asyncio.sleep(0)
            with pytest.raises(BusyError) as caught:
                await take(100)
            assert caught.value.code == "download.too_many"
            for task in waiting[1:]:
                task.cancel()
            await asyncio.gather(*waiting[1:], return_exceptions=True)
            late = asyncio.create_task(take(101))
            await asyncio.sleep(0)
        late.cancel()  # just after it was granted a slot
        await asyncio.gather(*waiting, late, return_exceptions=True)
        assert slots.taken == 2
