"""Uploads from the first byte to the loaded log, access of visitors, and restarts."""

from __future__ import annotations

import asyncio
import gzip
import os
import signal
from collections.abc import Awaitable, Callable
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from mapper.core.errors import LimitError, ReadError
from server.library.library import Library
from server.library.logs.records import LogNotFoundError
from server.settings import Settings
from tests.server.library.kept import files, settled
from tests.server.library.processing import bad_readers
from tests.server.library.small_logs import carmen, in_pieces
from tests.server.service import eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")


def address_space_limit(pid: int) -> str:
    limits = Path(f"/proc/{pid}/limits")
    if not limits.exists():
        pytest.skip("this system has no /proc")
    return next(line for line in limits.read_text().splitlines() if line.startswith("Max address space"))


async def test_an_upload_is_read_and_loaded(library: Library) -> None:
    record = await library.put("ann", "run.log", in_pieces(carmen(5)))
    assert record.state == "queued"
    log = await library.load("ann", record.id)
    assert log.n_scans == 5
    assert log.name == "run.log"
    np.testing.assert_array_equal(log.ranges[0], np.array([1, 2, 3], dtype=np.float32))
    np.testing.assert_array_equal(log.trajectory().poses[:, 0], np.arange(5.0))
    public = library.get("ann", record.id).public()
    assert public.state == "ready"
    assert (public.scans, public.beams, public.duration_s) == (5, 3, 4.0)
    assert public.trajectories[0].name == log.default_trajectory
    assert public.error is None


async def test_a_log_is_read_once_and_unpacked_after_a_restart(make_library: Callable[..., Library]) -> None:
    first = make_library()
    await first.start()
    record = await first.put("ann", "run.log", in_pieces(carmen(7)))
    log = await first.load("ann", record.id)
    assert await first.load("ann", record.id) is log
    await first.close()

    second = make_library(own_reader=True)
    await second.start()
    again = await second.load("ann", record.id)
    assert second._readers.small.worker_pid == 0, "nothing had to be read"
    np.testing.assert_array_equal(again.ranges, log.ranges)
    np.testing.assert_array_equal(again.stamps_ns, log.stamps_ns)


async def test_a_damaged_pack_is_made_again(library: Library, settings: Settings) -> None:
    record = await library.put("ann", "run.log", in_pieces(carmen(5)))
    await library.load("ann", record.id)
    library._cache.drop(record.id)
    library._catalogue.pack(record.id).write_bytes(b"PK\x03\x04 this is no pack")
    assert (await library.load("ann", record.id)).n_scans == 5


async def test_the_same_bytes_are_stored_once(library: Library, settings: Settings) -> None:
    one, two = await asyncio.gather(
        library.put("ann", "a.log", in_pieces(carmen(50))), library.put("ann", "b.log", in_pieces(carmen(50), 7))
    )
    assert one.id == two.id
    other = await library.put("bob", "a.log", in_pieces(carmen(50)))
    assert other.id != one.id
    await settled(library, "ann", one.id)
    await settled(library, "bob", other.id)
    assert len([f for f in files(settings) if f.startswith("library/blobs")]) == 1, "whoever it is"
    await library.delete("ann", one.id)
    assert (await library.load("bob", other.id)).n_scans == 50
    assert len([f for f in files(settings) if f.startswith("library/blobs")]) == 1
    await library.delete("bob", other.id)
    assert files(settings) == []


async def test_two_uploads_at_once_do_not_mix(library: Library) -> None:
    records = await asyncio.gather(
        library.put("ann", "short", in_pieces(carmen(20, start=100), 13)),
        library.put("ann", "long", in_pieces(carmen(30, start=500), 17)),
    )
    logs = [await library.load("ann", record.id) for record in records]
    assert [log.trajectory().poses[0, 0] for log in logs] == [100.0, 500.0]
    assert [log.n_scans for log in logs] == [20, 30]


async def test_another_visitors_log_is_not_there(library: Library) -> None:
    record = await library.put("ann", "run.log", in_pieces(carmen(5)))
    await settled(library, "ann", record.id)
    for log_id in (record.id, "no-such-log", "../records/" + record.id, ""):
        with pytest.raises(LogNotFoundError):
            library.get("bob", log_id)
        with pytest.raises(LogNotFoundError):
            await library.load("bob", log_id)
        with pytest.raises(LogNotFoundError):
            await library.delete("bob", log_id)
    assert record.id not in [r.id for r in await library.list("bob")]
    assert record.id in [r.id for r in await library.list("ann")]


async def test_delete_leaves_nothing_and_open_logs_go_on(library: Library, settings: Settings) -> None:
    record = await library.put("ann", "run.log", in_pieces(carmen(5)))
    log = await library.load("ann", record.id)
    await library.delete("ann", record.id)
    assert files(settings) == []
    assert log.ranges.sum() == 30.0
    with pytest.raises(LogNotFoundError):
        library.get("ann", record.id)


async def test_delete_while_the_log_is_queued_or_read(
    make_library: Callable[..., Library], settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.processing.reading.Job.do", bad_readers.instead(bad_readers.sleep))
    library = make_library(own_reader=True)
    await library.start()
    records = [await library.put("ann", "x", in_pieces(data)) for data in (bad_readers.BAD, carmen(20), carmen(21))]
    waiting = asyncio.create_task(library.load("ann", records[0].id))
    await eventually(lambda: library.get("ann", records[0].id).state == "reading")
    assert [library.get("ann", record.id).state for record in records[1:]] == ["queued", "queued"]
    await asyncio.gather(*(library.delete("ann", record.id) for record in records))
    with pytest.raises(LogNotFoundError):
        await waiting
    assert files(settings) == []
    # The reader is fit for the next log.
    record = await library.put("ann", "y", in_pieces(carmen(3)))
    assert (await library.load("ann", record.id)).n_scans == 3


async def test_no_reading_that_ends_during_a_deletion_or_after_it_brings_the_record_back(library: Library) -> None:
    record = await library.put("ann", "run.log", in_pieces(carmen(5)))
    await library.load("ann", record.id)
    catalogue = library._catalogue
    ready, store = library.get("ann", record.id), catalogue._store
    forget = store.delete

    def read_meanwhile(log_id: str) -> Awaitable[None]:
        asked = forget(log_id)
        catalogue.save(ready)
        return asked

    with patch.object(store, "delete", read_meanwhile):
        await library.delete("ann", record.id)
    catalogue.save(ready)
    assert catalogue.get(record.id) is None
    assert await store.load() == []


# -- what can go wrong in reading ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (bytes(range(256)) * 20, "log.binary"),
        (b"Dear all,\nthe log is attached.\n", "log.unknown_format"),
        (gzip.compress(carmen(500))[:20], "log.truncated"),
        (b"# a comment\nPARAM robot 1\n", "log.no_scans"),
        (carmen(2) + b"FLASER 3 1.0 nonsense 3.0 0 0 0 0 0 0 1 host 1\n" + carmen(1), "log.not_a_number"),
    ],
    ids=["binary", "letter", "truncated gzip", "no scans", "bad line"],
)
async def test_a_file_that_is_no_log_fails_with_a_sentence(
    library: Library, settings: Settings, data: bytes, code: str
) -> None:
    record = await library.put("ann", "bad.log", in_pieces(data))
    with pytest.raises((ReadError, LimitError)) as caught:
        await library.load("ann", record.id)
    failed = library.get("ann", record.id)
    assert failed.state == "failed"
    assert failed.error is not None
    assert (failed.error.code, failed.error.message) == (caught.value.code, caught.value.message)
    assert failed.error.code == code
    assert record.id not in failed.error.message
    assert str(settings.data_dir) not in failed.error.message
    # Nothing else stops.
    good = await library.put("ann", "good.log", in_pieces(carmen(4)))
    assert (await library.load("ann", good.id)).n_scans == 4


async def test_a_truncated_log_is_read_up_to_its_end(library: Library) -> None:
    record = await library.put("ann", "cut.log.gz", in_pieces(gzip.compress(carmen(500))[:1500]))
    log = await library.load("ann", record.id)
    assert 0 < log.n_scans < 500
    assert library.get("ann", record.id).public().notes


async def test_a_gzip_bomb_is_stopped(library: Library) -> None:
    # Many members, one after the other, are one file: 1.2 GB in 1 MB.
    bomb = gzip.compress(carmen(1)) + gzip.compress(b"# \n" * 16_000_000, 9) * 16
    assert len(bomb) < 1_000_000
    record = await library.put("ann", "bomb.gz", in_pieces(bomb, 65536))
    failed = await settled(library, "ann", record.id)
    assert failed.state == "failed"
    assert failed.error is not None
    assert failed.error.code in ("log.too_large", "log.too_many_lines", "log.time")


async def test_a_killed_worker_fails_its_own_job_only(
    make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("server.library.processing.reading.Job.do", bad_readers.instead(bad_readers.sleep))
    library = make_library(own_reader=True)
    await library.start()
    first = await library.put("ann", "first", in_pieces(bad_readers.BAD))
    second = await library.put("ann", "second", in_pieces(carmen(4)))
    await eventually(lambda: library._readers.small.worker_pid > 0)
    assert library.get("ann", first.id).state == "reading"
    os.kill(library._readers.small.worker_pid, signal.SIGKILL)
    failed = await settled(library, "ann", first.id)
    assert failed.error is not None
    assert failed.error.code == "log.reader_died"
    assert (await library.load("ann", second.id)).n_scans == 4
    # The same bytes again: read again, in the place of the failure.
    monkeypatch.undo()
    again = await library.put("ann", "first", in_pieces(bad_readers.BAD))
    assert again.id == first.id
    assert (await library.load("ann", again.id)).n_scans == 2


async def test_a_worker_that_dies_idle_fails_no_job(library: Library) -> None:
    record = await library.put("ann", "a", in_pieces(carmen(2)))
    await library.load("ann", record.id)
    os.kill(library._readers.small.worker_pid, signal.SIGKILL)
    await eventually(lambda: library._readers.small._worker._pool._broken)  # type: ignore[attr-defined]
    record = await library.put("ann", "b", in_pieces(carmen(3)))
    assert (await library.load("ann", record.id)).n_scans == 3


async def test_reading_has_a_time_limit(make_library: Callable[..., Library]) -> None:
    library = make_library(read_timeout_s=0.001)
    record = await library.put("ann", "a", in_pieces(carmen(8000), 100_000))
    failed = await settled(library, "ann", record.id)
    assert failed.error is not None
    assert failed.error.code == "log.time"


async def test_reading_has_a_memory_limit(make_library: Callable[..., Library]) -> None:
    library = make_library(read_memory_bytes=600 << 20)
    record = await library.put("ann", "a", in_pieces(carmen(2)))
    await library.load("ann", record.id)
    assert str(600 << 20) in address_space_limit(library._readers.small.worker_pid)


async def test_a_job_that_a_stop_interrupts_is_done_after_the_next_start(
    make_library: Callable[..., Library], settings: Settings
) -> None:
    first = make_library()
    record = await first.put("ann", "a", in_pieces(carmen(8000), 100_000))
    await first.close()  # the job is cut; its record says "queued" or "reading" on the disk
    (settings.data_dir / "library" / "incoming" / "half.part").write_bytes(b"x")
    (settings.data_dir / "library" / "blobs" / "orphan").write_bytes(b"x")

    second = make_library()
    await second.start()
    assert (await settled(second, "ann", record.id)).state == "ready"
    assert second._catalogue.all()[0].attempts == 0
    left = files(settings)
    assert "library/incoming/half.part" not in left
    assert "library/blobs/orphan" not in left


async def test_old_uploads_leave(make_library: Callable[..., Library], settings: Settings) -> None:
    first = make_library()
    record = await first.put("ann", "a", in_pieces(carmen(2)))
    await first.load("ann", record.id)
    await first.close()
    second = make_library(keep_s=0.0)
    await second.start()
    assert files(settings) == []
