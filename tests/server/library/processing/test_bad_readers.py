"""A reader that crashes, loops or uses too much memory ends only its own job, which can be run again."""

from __future__ import annotations

import asyncio
import os
import tempfile
from collections.abc import Callable

import pytest

from server.library.library import Library
from server.library.logs.records import LogNotFoundError, LogReadOnlyError
from server.library.processing.reader import QUICK_S
from server.settings import Settings
from server.work.fair_lock import FairLock
from tests.server.library.kept import settled
from tests.server.library.processing import bad_readers
from tests.server.library.small_logs import carmen, in_pieces
from tests.server.service import PATIENCE_S, eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest.mark.parametrize(
    ("job", "limits", "code"),
    [
        (bad_readers.crash, {}, "log.reader_died"),
        (bad_readers.leave, {}, "log.reader_died"),
        (bad_readers.defect, {}, "log.reader_failed"),
        (bad_readers.sleep, {"read_timeout_s": 2.0}, "log.time"),
        (bad_readers.loop, {"read_timeout_s": 60.0, "read_cpu_s": 0.3}, "log.time"),
        (bad_readers.loop_in_c, {"read_timeout_s": 2.0}, "log.time"),
        (bad_readers.loop_in_c, {"read_timeout_s": 60.0, "read_cpu_s": 0.3}, "log.reader_died"),
        (bad_readers.eat, {"read_memory_bytes": 1 << 30}, "log.memory"),
        (bad_readers.disk_full, {}, "log.storage"),
    ],
    ids=[
        "crash",
        "leave",
        "defect",
        "sleep",
        "loop",
        "loop in C",
        "loop in C, by its processor time",
        "eat memory",
        "full disk",
    ],
)
async def test_a_bad_reader_ends_its_own_job_and_nothing_else(
    make_library: Callable[..., Library], settings: Settings, monkeypatch: pytest.MonkeyPatch, job, limits, code
) -> None:
    monkeypatch.setattr("server.library.processing.reading.Job.do", bad_readers.instead(job))
    monkeypatch.setattr("server.jobs.workers.GRACE_S", 1.0)
    library = make_library(own_reader=True, **limits)
    await library.start()
    bad = await library.put("ann", "bad", in_pieces(bad_readers.BAD))
    has_seconds = limits.get("read_timeout_s") == 2.0
    good = None if has_seconds else await library.put("ben", "good", in_pieces(carmen(4)))
    failed = await settled(library, "ann", bad.id)
    assert failed.error is not None
    assert failed.error.code == code
    assert failed.error.message.endswith(".")
    await eventually(lambda: not list((settings.data_dir / "library" / "incoming").iterdir()))  # removed on a thread
    assert not [name for name in os.listdir(tempfile.gettempdir()) if name.startswith(bad_readers.LEFT)]  # noqa: PTH208
    if good is None:  # on a slow machine it takes longer to begin a process
        library._readers.small._timeout_s = PATIENCE_S
        good = await library.put("ben", "good", in_pieces(carmen(4)))
    assert (await library.load("ben", good.id)).n_scans == 4
    # With a reader that behaves, the same log is read after all.
    monkeypatch.undo()
    assert library.read_again("ann", bad.id).state == "queued"
    assert (await settled(library, "ann", bad.id)).state == "ready"


async def test_a_small_log_that_takes_long_makes_room_for_those_of_others(
    make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.processing.reading.Job.do", bad_readers.instead(bad_readers.loop))
    library = make_library(own_reader=True, read_timeout_s=3000.0, read_cpu_s=3000.0)
    await library.start()
    slow = await library.put("ann", "slow", in_pieces(bad_readers.BAD))
    own = await library.put("ann", "own", in_pieces(carmen(3)))
    small = library._readers.small
    await eventually(lambda: small.cpu_s > QUICK_S)
    assert library.get("ann", slow.id).state == "reading"
    assert library._readers.of(slow) is small  # it keeps nobody else waiting
    others = await library.put("ben", "others", in_pieces(carmen(4)))
    for owner, quick in (("ben", others), ("ann", own)):
        assert (await settled(library, owner, quick.id)).state == "ready"
    await eventually(lambda: library.get("ann", slow.id).state == "reading")
    assert library._readers.of(slow) is library._readers.large
    await library.delete("ann", slow.id)
    assert (await library.load("ben", others.id)).n_scans == 4


async def test_a_job_is_stopped_and_run_again(
    make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.processing.reading.Job.do", bad_readers.instead(bad_readers.sleep))
    library = make_library(own_reader=True)
    await library.start()
    reading = await library.put("ann", "a", in_pieces(bad_readers.BAD))
    queued = await library.put("ann", "b", in_pieces(carmen(3)))
    await eventually(lambda: library.get("ann", reading.id).state == "reading")
    for log in (queued, reading):  # the one that waits, then the one that is read
        stopped = await library.cancel("ann", log.id)
        assert (stopped.state, stopped.error and stopped.error.code) == ("failed", "log.cancelled")
    monkeypatch.undo()
    for log in (queued, reading):
        library.read_again("ann", log.id)
        done = await settled(library, "ann", log.id)
        assert done.state == "ready", done.error
        assert (await library.cancel("ann", log.id)).state == "ready", "what is done stays done"
        assert library.read_again("ann", log.id).state == "ready"


async def test_a_small_log_does_not_wait_for_a_large_one(
    make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.processing.reading.Job.do", bad_readers.instead(bad_readers.sleep))
    monkeypatch.setattr("server.library.processing.reader.SMALL_BYTES", len(bad_readers.BAD) - 1)
    library = make_library(own_reader=True)
    await library.start()
    large = await library.put("ann", "large", in_pieces(bad_readers.BAD))
    await eventually(lambda: library.get("ann", large.id).state == "reading")
    small = await library.put("ben", "small", in_pieces(carmen(1)))
    assert (await settled(library, "ben", small.id)).state == "ready"
    assert library.get("ann", large.id).state == "reading"


async def test_only_ones_own_uploads_are_stopped_or_read_again(library: Library) -> None:
    record = await library.put("ann", "a", in_pieces(carmen(3)))
    with pytest.raises(LogNotFoundError):
        await library.cancel("ben", record.id)
    with pytest.raises(LogNotFoundError):
        library.read_again("ben", record.id)
    with pytest.raises(LogReadOnlyError):
        await library.cancel("ann", "sample-office")


async def test_owners_are_served_in_rotation() -> None:
    turns = FairLock()
    order: list[str] = []

    async def job(owner: str, name: str) -> None:
        async with turns.of(owner):
            order.append(name)
            await asyncio.sleep(0)

    names = [("ann", "a1"), ("ann", "a2"), ("ann", "a3"), ("ben", "b1"), ("cid", "c1"), ("ben", "b2")]
    await asyncio.gather(*(job(owner, name) for owner, name in names))
    assert order == ["a1", "a2", "b1", "c1", "a3", "b2"]


async def test_an_address_has_one_turn_in_a_rotation_under_any_number_of_cookies() -> None:
    turns = FairLock()
    order: list[str] = []

    async def job(owner: str, address: str) -> None:
        async with turns.of(owner, address):
            order.append(owner)
            await asyncio.sleep(0)

    one_client = [job(f"cookie {number}", "192.0.2.7") for number in range(6)]
    await asyncio.gather(*one_client, job("ann", "192.0.2.1"), job("ben", "192.0.2.1"))
    assert order == ["cookie 0", "cookie 1", "ann", "cookie 2", "ben", "cookie 3", "cookie 4", "cookie 5"]


async def test_a_cancelled_request_does_not_block_the_queue() -> None:
    turns = FairLock()
    gate = asyncio.Event()
    done: list[str] = []

    async def job(name: str, wait: bool = False) -> None:
        async with turns.of(name):
            if wait:
                await gate.wait()
            done.append(name)

    first = asyncio.create_task(job("first", wait=True))
    await asyncio.sleep(0)
    leaving, last = asyncio.create_task(job("leaving")), asyncio.create_task(job("last"))
    await asyncio.sleep(0)
    leaving.cancel()
    gate.set()
    await asyncio.gather(first, last)
    # One that is cancelled in the very moment in which its turn has come.
    async with turns.of("me"):
        late, waiting = asyncio.create_task(job("late")), asyncio.create_task(job("waiting"))
        await asyncio.sleep(0)
    late.cancel()
    await waiting
    assert done == ["first", "last", "waiting"]
