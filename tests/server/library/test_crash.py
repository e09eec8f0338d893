"""A disk that is full at the n-th write, a process that is killed there, for each n: an upload is stored whole or
not at all.
"""

from __future__ import annotations

import asyncio
import hashlib
import multiprocessing
from collections.abc import Callable
from typing import Any

import pytest

from mapper.core.errors import LimitError
from server.library.library import Library
from server.library.logs.records import Record
from server.library.processing import reading_jobs as jobs
from server.library.processing.reader import Reader
from server.library.processing.reading_jobs import MOST_ATTEMPTS
from server.settings import Settings
from server.storage import StorageError
from tests.server.library import writes
from tests.server.library.small_logs import carmen, in_pieces
from tests.server.service import eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")
OLD, NEW = carmen(5), carmen(900)
MOST_WRITES = 40


async def ready(library: Library, log_id: str) -> Record:
    await eventually(lambda: library.get("ann", log_id).state not in ("queued", "reading"))
    return library.get("ann", log_id)


def kept(settings: Settings) -> set[str]:
    """The files of the library, save those of the database and the picture of the sample."""
    root = settings.data_dir / "library"
    found = {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}
    return {
        name
        for name in found
        if not name.startswith(("library.db", "pictures/sample-office.", "pictures/.sample-office."))
    }


_READ = (("packs", "npz"), ("pictures", "png"))


def files_of(*logs: tuple[str, bytes]) -> set[str]:
    """The files that there are for logs that were read."""
    blobs = {f"blobs/{hashlib.sha256(data).hexdigest()}" for _, data in logs}
    return blobs | {f"{folder}/{log_id}.{kind}" for log_id, _ in logs for folder, kind in _READ}


async def test_a_disk_that_is_full_at_the_nth_write(library: Library, settings: Settings) -> None:
    old = await library.put("ann", "old.log", in_pieces(OLD))
    await library.load("ann", old.id)
    refused = 0
    with writes.counted(writes.full) as counted:
        for before in range(MOST_WRITES):
            counted.left = before
            (new,) = await asyncio.gather(library.put("ann", "new.log", in_pieces(NEW, 10_000)), return_exceptions=True)
            if isinstance(new, Record):
                break
            assert isinstance(new, StorageError)
            assert (new.code, new.message[-1]) == ("log.storage", ".")
            refused += 1
            # The disk is as full as before, and everything else goes on.
            assert kept(settings) == files_of((old.id, OLD)), before
            library._cache.drop(old.id)
            assert (await library.load("ann", old.id)).n_scans == 5
            assert [r.name for r in await library.list("ann") if r.source == "upload"] == ["old.log"]
        # The new log is stored, though its state can no longer be written: it counts until the next start.
        assert isinstance(new, Record)
        assert (await ready(library, new.id)).state == "ready"
        counted.left = 0
        with pytest.raises(StorageError):
            await library.delete("ann", old.id)
    assert refused >= 9, "each piece, its end, its place and its record"
    assert (await library.load("ann", new.id)).n_scans == 900
    assert kept(settings) == files_of((old.id, OLD), (new.id, NEW))
    await library.delete("ann", new.id)
    assert kept(settings) == files_of((old.id, OLD))


async def test_a_process_that_is_killed_before_its_nth_write(
    make_library: Callable[..., Library], reader: Reader, settings: Settings
) -> None:
    first = make_library()
    old = await first.put("ann", "old.log", in_pieces(OLD))
    await first.load("ann", old.id)
    await first.close()
    server = multiprocessing.get_context("forkserver")  # a process of one thread, to fork from
    server.set_forkserver_preload(["tests.server.library.writes"])
    seen = set()
    for before in range(MOST_WRITES):
        process = server.Process(target=writes.upload_and_be_killed, args=(settings.data_dir, NEW, before))
        process.start()
        await asyncio.to_thread(process.join)
        library = make_library()
        await library.start()
        assert (await library.load("ann", old.id)).n_scans == 5
        logs = {r.name: r for r in await library.list("ann") if r.source == "upload"}
        assert set(logs) in ({"old.log"}, {"old.log", "new.log"}), before
        if "new.log" in logs:
            new = await ready(library, logs["new.log"].id)
            assert new.state == "ready"
            assert (await library.load("ann", new.id)).n_scans == 900
            await library.delete("ann", new.id)
        assert kept(settings) == files_of((old.id, OLD)), before
        await library.close()
        seen.add((process.exitcode, "new.log" in logs))
        if process.exitcode == 0:
            break
    assert seen == {(-9, False), (-9, True), (0, True)}


async def test_a_log_that_crashes_the_service_is_not_read_again_and_again(
    make_library: Callable[..., Library], settings: Settings
) -> None:
    first = make_library()
    record = await first.put("ann", "bad.log", in_pieces(NEW))
    await first.close()
    server = multiprocessing.get_context("forkserver")
    for _ in range(MOST_ATTEMPTS):
        process = server.Process(target=writes.be_killed_by_a_reading, args=(settings.data_dir,))
        process.start()
        await asyncio.to_thread(process.join)
        assert process.exitcode == -9
    for _ in range(2):
        library = make_library()
        await library.start()
        failed = library.get("ann", record.id)
        assert failed.error is not None
        assert (failed.state, failed.error.code) == ("failed", "log.interrupted")
        assert failed.error.message.startswith("The service ended 3 times while it read this log")
        await library.close()
    library = make_library()
    await library.start()
    library.read_again("ann", record.id)
    assert (await ready(library, record.id)).state == "ready", "its owner may ask for it"


async def test_a_reading_without_disk_is_repeated_by_itself(
    library: Library, make_library: Callable[..., Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Twice in the same run, and once more after a restart."""
    failures = [
        OSError(28, "No space left on device"),  # no process begins
        LimitError("log.storage", "The log cannot be read now: the server’s disk may be full."),
    ]
    read = Reader.read

    async def full_at_first(self: Reader, *arguments: Any, **named: Any) -> Any:
        if failures:
            raise failures.pop(0)
        return await read(self, *arguments, **named)

    monkeypatch.setattr(Reader, "read", full_at_first)
    monkeypatch.setattr(jobs, "RETRY_S", 0.05)
    again = await library.put("ann", "again.log", in_pieces(OLD))
    await eventually(lambda: library.get("ann", again.id).state == "ready")
    assert failures == []

    monkeypatch.setattr(jobs, "RETRY_S", 1e6)
    failures.append(LimitError("log.storage", "The log cannot be read now: the server’s disk may be full."))
    later = await library.put("ann", "later.log", in_pieces(NEW))
    failed = await ready(library, later.id)
    assert failed.error is not None
    assert (failed.state, failed.error.code) == ("failed", "log.storage")
    await library.close()
    restarted = make_library()
    await restarted.start()
    assert (await ready(restarted, later.id)).state == "ready"
