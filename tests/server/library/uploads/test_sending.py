"""Uploads that stop, stall, are very slow or too large; and names that are only shown."""

from __future__ import annotations

import asyncio
import gzip
from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest

from mapper.core.errors import LimitError, MapperError
from server.library.library import Library
from server.library.processing.reader import Reader
from server.settings import Settings
from tests.server.library.kept import files, settled
from tests.server.library.small_logs import carmen, in_pieces
from tests.server.service import eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")


async def test_an_upload_that_stops_half_way_leaves_nothing(library: Library, settings: Settings) -> None:
    async def broken() -> AsyncIterator[bytes]:
        yield carmen(2000)
        raise ConnectionResetError

    with pytest.raises(ConnectionResetError):
        await library.put("ann", "run.log", broken())
    assert files(settings) == []
    assert [r.source for r in await library.list("ann")] == ["sample"]


async def test_an_upload_that_is_cancelled_leaves_nothing(library: Library, settings: Settings) -> None:
    started = asyncio.Event()

    async def endless() -> AsyncIterator[bytes]:
        yield b"x" * 500_000
        started.set()
        await asyncio.Event().wait()

    task = asyncio.create_task(library.put("ann", "run.log", endless()))
    await started.wait()
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert files(settings) == []


async def test_an_upload_that_stalls_is_cancelled(make_library: Callable[..., Library], settings: Settings) -> None:
    library = make_library(idle_s=0.05)

    async def stalls() -> AsyncIterator[bytes]:
        yield b"x"
        await asyncio.sleep(30)

    with pytest.raises(LimitError, match="Almost no data") as caught:
        await library.put("ann", "run.log", stalls())
    assert caught.value.code == "log.stalled"
    assert files(settings) == []


async def test_a_very_slow_upload_is_cancelled(make_library: Callable[..., Library], settings: Settings) -> None:
    """A byte now and then would hold one of the few places for ever."""
    library = make_library(idle_s=0.5)

    async def trickles() -> AsyncIterator[bytes]:
        for _ in range(3000):
            yield b"x"
            await asyncio.sleep(0.01)

    with pytest.raises(LimitError, match="Almost no data") as caught:
        await library.put("ann", "run.log", trickles())
    assert caught.value.code == "log.stalled"
    assert files(settings) == []


async def test_one_visitors_uploads_leave_places_and_room_to_others(make_library: Callable[..., Library]) -> None:
    library = make_library(max_uploads_at_once=4, max_uploads_of_owner=2, max_owner_bytes=4000)
    go_on = asyncio.Event()

    async def waits(n: int) -> AsyncIterator[bytes]:
        yield carmen(n)
        await go_on.wait()

    async def refused(owner: str, data: AsyncIterator[bytes], size: int | None = None) -> tuple[str, str]:
        with pytest.raises(LimitError) as caught:
            await library.put(owner, "run.log", data, size)
        return caught.value.code, caught.value.message

    slow = [asyncio.create_task(library.put("eve", "slow", waits(5 + n))) for n in range(2)]
    await eventually(lambda: library._slots.of("eve") == 2)
    assert (await refused("eve", in_pieces(carmen(9))))[0] == "library.busy"
    assert (await library.put("ann", "run.log", in_pieces(carmen(10)))).state == "queued"
    go_on.set()
    await asyncio.gather(*slow)
    assert len(library._slots) == 0
    assert await refused("eve", in_pieces(carmen(9)), 3900) == (
        "library.too_many",
        "Your logs fill the space of one visitor: delete one.",
    )
    assert (await library.put("bob", "run.log", in_pieces(carmen(10)), 3900)).state == "queued"


async def test_caps(make_library: Callable[..., Library], settings: Settings) -> None:
    library = make_library(max_logs_per_owner=1, max_total_bytes=1_100_000)

    async def refused(owner: str, data: AsyncIterator[bytes], size: int | None = None) -> str:
        with pytest.raises(MapperError) as caught:
            await library.put(owner, "run.log", data, size)
        return caught.value.code

    unread = in_pieces(carmen(5))
    assert await refused("ann", unread, 2 << 30) == "log.too_large"
    assert await anext(unread), "a log that is declared too large is refused before its first byte"
    assert await refused("ann", in_pieces(b"x" * 1_000_001, 65536), 10) == "log.too_large"
    assert await refused("ann", in_pieces(b"")) == "log.empty"
    assert files(settings) == []
    await library.put("ann", "run.log", in_pieces(carmen(5)))
    assert await refused("ann", in_pieces(carmen(6))) == "library.too_many"
    await library.put("bob", "x", in_pieces(b"x" * 1_000_000, 65536))
    assert await refused("eve", in_pieces(b"y"), 200_000) == "library.full"


async def test_packs_count_towards_the_quota(
    make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A small upload may hold a thousand times its bytes in readings."""
    library = make_library(max_total_bytes=20_000)
    packed = [gzip.compress(carmen(2000, start)) for start in range(3)]
    are_here, read = asyncio.Event(), Reader.read

    async def read_once_all_are_here(reader: Reader, *args: Any, **named: Any) -> Any:
        await are_here.wait()
        return await read(reader, *args, **named)

    monkeypatch.setattr(Reader, "read", read_once_all_are_here)
    records = [await library.put("ann", f"{n}.log.gz", in_pieces(data[:6000])) for n, data in enumerate(packed)]
    are_here.set()
    ends = [await settled(library, "ann", record.id) for record in records]
    assert ends[0].state == "ready"
    assert ends[2].error is not None
    assert ends[2].error.code == "library.full"
    with pytest.raises(LimitError) as caught:
        await library.put("bob", "b.log", in_pieces(carmen(2)))
    assert caught.value.code == "library.full"
    await library.delete("ann", records[0].id)
    small = await library.put("bob", "b.log", in_pieces(carmen(2)))
    assert (await settled(library, "bob", small.id)).state == "ready"


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("run.log", "run.log"),
        ("../../etc/passwd", "passwd"),
        ("C:\\logs\\run.log", "run.log"),
        ("a\x00b\x1b[31m\n\tc\u202egnp.exe", "ab[31m cgnp.exe"),
        ("", "log"),
        ("../..", "log"),
        ("\ud800x", "x"),
        ("Straße/Café 地図.log.gz", "Café 地図.log.gz"),
        ("n" * 500, "n" * 119 + "…"),
    ],
)
async def test_names_are_only_shown(library: Library, settings: Settings, name: str, shown: str) -> None:
    record = await library.put("ann", name, in_pieces(carmen(2)))
    assert record.name == shown
    await settled(library, "ann", record.id)
    assert not [f for f in files(settings) if "passwd" in f or "run.log" in f]
