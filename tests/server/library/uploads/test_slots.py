"""Upload slots: slow uploads are cancelled for waiting ones, and one address does not use all slots."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator

import pytest

from mapper.core.errors import LimitError
from server.library.uploads.slots import UploadSlots
from tests.server.service import PATIENCE_S, eventually

IDLE_S = 30.0


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measure speeds sooner, and give up waiting sooner."""
    monkeypatch.setattr("server.library.uploads.slots.MEASURED_S", 0.1)
    monkeypatch.setattr("server.library.uploads.slots.LOOK_EVERY_S", 0.02)
    monkeypatch.setattr("server.library.uploads.slots.WAIT_S", 1.0)


async def coming(size: int, every_s: float) -> AsyncIterator[bytes]:
    """An upload of which ``size`` bytes come every so many seconds, without end."""
    while True:
        yield b"x" * size
        await asyncio.sleep(every_s)


async def upload(slots: UploadSlots, owner: str, address: str, size: int, every_s: float = 0.01) -> None:
    async with slots.take(owner, address) as slot:
        async for _ in slot.read(coming(size, every_s)):
            pass


async def begun(slots: UploadSlots, n: int, address: str, size: int) -> list[asyncio.Task[None]]:
    """``n`` uploads that have their slot, and whose speed is known."""
    tasks = [asyncio.create_task(upload(slots, f"{address} {k}", address, size)) for k in range(n)]
    await eventually(
        lambda: (
            all(slots.of(f"{address} {k}") for k in range(n))
            and all(one.speed() < math.inf for one in slots._taken)
            and not slots._waiting
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
    monkeypatch.setattr("server.library.uploads.slots.SLOW_BYTES_PER_S", 10_000)
    slots = UploadSlots(3, 3, IDLE_S)
    tasks = [*await begun(slots, 1, "a", 30), *await begun(slots, 1, "b", 3), *await begun(slots, 1, "c", 30_000)]
    async with slots.take("new", "d"):
        assert [task.done() for task in tasks] == [False, True, False]
        assert len(slots) == 3
    assert await ended(tasks) == ["library.busy"]
    assert len(slots) == 0


async def test_fast_uploads_are_not_cancelled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.uploads.slots.SLOW_BYTES_PER_S", 100)
    slots = UploadSlots(2, 2, IDLE_S)
    tasks = await begun(slots, 2, "a", 3000)
    # The speeds are known. On a busy machine a pause of this process must not count as a wait of a slow upload.
    monkeypatch.setattr("server.library.uploads.slots.MEASURED_S", 600.0)
    with pytest.raises(LimitError) as caught:
        async with asyncio.timeout(PATIENCE_S):
            await upload(slots, "new", "a", 3000)
    assert caught.value.code == "library.busy"
    assert await ended(tasks) == []


async def test_an_address_with_more_uploads_makes_room_for_one_with_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.uploads.slots.SLOW_BYTES_PER_S", 100)
    slots = UploadSlots(3, 3, IDLE_S)
    tasks = await begun(slots, 3, "a", 3000)
    new = await begun(slots, 1, "b", 3000)  # takes the slot of one of them
    assert await ended(new) == []
    assert await ended(tasks) == ["library.busy"]


async def test_an_upload_cancelled_while_waiting_takes_no_slot() -> None:
    slots = UploadSlots(1, 4, IDLE_S)
    async with slots.take("ann", "a"):
        waiting = [asyncio.create_task(upload(slots, "eve", "b", 3000)) for _ in range(4)]
        await eventually(lambda: slots.of("eve") == 4)
        with pytest.raises(LimitError):
            await upload(slots, "eve", "b", 3000)
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        assert (slots.of("eve"), slots.of("ann")) == (0, 1)
    async with slots.take("eve", "b"):
        assert len(slots) == 1
