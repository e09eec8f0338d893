"""Places of uploads: slow ones make room for those that wait, and one address leaves the others theirs."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator

import pytest

from mapper.core.errors import LimitError
from server.library.places import Places
from tests.server.service import PATIENCE_S, eventually

IDLE_S = 30.0


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measure speeds sooner, and give up waiting sooner."""
    monkeypatch.setattr("server.library.places.MEASURED_S", 0.1)
    monkeypatch.setattr("server.library.places.LOOK_EVERY_S", 0.02)
    monkeypatch.setattr("server.library.places.WAIT_S", 1.0)


async def coming(size: int, every_s: float) -> AsyncIterator[bytes]:
    """An upload of which ``size`` bytes come every so many seconds, without end."""
    while True:
        yield b"x" * size
        await asyncio.sleep(every_s)


async def upload(places: Places, owner: str, address: str, size: int, every_s: float = 0.01) -> None:
    async with places.take(owner, address) as place:
        async for _ in place.read(coming(size, every_s)):
            pass


async def begun(places: Places, n: int, address: str, size: int) -> list[asyncio.Task[None]]:
    """``n`` uploads that have their place, and whose speed is known."""
    tasks = [asyncio.create_task(upload(places, f"{address} {k}", address, size)) for k in range(n)]
    await eventually(
        lambda: (
            all(places.of(f"{address} {k}") for k in range(n))
            and all(one.speed() < math.inf for one in places._taken)
            and not places._waiting
        )
    )
    assert not any(task.done() for task in tasks)
    return tasks


async def ended(tasks: list[asyncio.Task[None]]) -> list[str]:
    """The codes of those that were given up; the others are ended."""
    codes = [error.code for task in tasks if task.done() and isinstance(error := task.exception(), LimitError)]
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    return codes


async def test_the_slowest_upload_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.places.SLOW_BYTES_PER_S", 10_000)
    places = Places(3, 3, IDLE_S)
    tasks = [*await begun(places, 1, "a", 30), *await begun(places, 1, "b", 3), *await begun(places, 1, "c", 30_000)]
    async with places.take("new", "d"):
        assert [task.done() for task in tasks] == [False, True, False]
        assert len(places) == 3
    assert await ended(tasks) == ["library.busy"]
    assert len(places) == 0


async def test_fast_uploads_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.places.SLOW_BYTES_PER_S", 100)
    places = Places(2, 2, IDLE_S)
    tasks = await begun(places, 2, "a", 3000)
    # The speeds are known. On a busy machine a pause of this process must not count as a wait of a slow upload.
    monkeypatch.setattr("server.library.places.MEASURED_S", 600.0)
    with pytest.raises(LimitError) as caught:
        async with asyncio.timeout(PATIENCE_S):
            await upload(places, "new", "a", 3000)
    assert caught.value.code == "library.busy"
    assert await ended(tasks) == []


async def test_an_address_with_more_uploads_makes_room_for_one_with_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.places.SLOW_BYTES_PER_S", 100)
    places = Places(3, 3, IDLE_S)
    tasks = await begun(places, 3, "a", 3000)
    new = await begun(places, 1, "b", 3000)  # takes the place of one of them
    assert await ended(new) == []
    assert await ended(tasks) == ["library.busy"]


async def test_who_goes_while_waiting_leaves_nothing() -> None:
    places = Places(1, 4, IDLE_S)
    async with places.take("ann", "a"):
        waiting = [asyncio.create_task(upload(places, "eve", "b", 3000)) for _ in range(4)]
        await eventually(lambda: places.of("eve") == 4)
        with pytest.raises(LimitError):
            await upload(places, "eve", "b", 3000)
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        assert (places.of("eve"), places.of("ann")) == (0, 1)
    async with places.take("eve", "b"):
        assert len(places) == 1
