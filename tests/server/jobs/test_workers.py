"""Logs read on an external executor: the same guarantees, with one process for each log."""

from __future__ import annotations

import asyncio
import errno
import subprocess
import sys
import threading
from collections.abc import AsyncIterator
from concurrent.futures import Future, ThreadPoolExecutor
from multiprocessing.popen_forkserver import Popen
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import pytest_asyncio

from mapper.core.errors import LimitError, ReadError
from server.jobs.outcome import outcome_of
from server.jobs.process import bounded
from server.jobs.workers import ExecutorWorker, PoolWorker, worker_at
from server.library.processing import reader as log_reader
from server.library.processing.reader import Reader
from server.storage import StorageError
from tests.server.library.processing.forked import Task, loaded
from tests.server.library.processing.slam_stand_ins import ThreadWorker
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")
ROOT = Path(__file__).parents[3]


@pytest_asyncio.fixture(loop_scope="module")
async def reader(tmp_path: Path) -> AsyncIterator[Reader]:
    (tmp_path / "leases").mkdir()
    worker = ExecutorWorker(ThreadPoolExecutor(1), tmp_path / "leases")
    reader = Reader(timeout_s=PATIENCE_S, memory_bytes=2 << 30, worker=worker)
    yield reader
    await reader.close()
    assert list((tmp_path / "leases").iterdir()) == []


def log(folder: Path, data: bytes) -> Path:
    path = folder / "a.log"
    path.write_bytes(data)
    return path


async def test_a_log_is_read_and_packed(reader: Reader, tmp_path: Path) -> None:
    summary = await reader.read(log(tmp_path, carmen(7)), tmp_path / "a.npz")
    assert (summary.scans, summary.beams) == (7, 3)
    assert (tmp_path / "a.npz").exists()
    with pytest.raises(ReadError) as caught:
        await reader.read(log(tmp_path, b"Dear all,\n"), None)
    assert caught.value.code == "log.unknown_format"


class Finished(ThreadWorker):
    """A worker whose jobs end at once, and that keeps their progress until the next one, as a process does."""

    progress = 0.9

    def submit(self, job: Any) -> Future[Any]:
        done: Future[Any] = Future()
        done.set_result(None)
        return done


async def test_a_log_whose_turn_it_is_shows_nothing_of_the_one_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 1000.0
    monkeypatch.setattr(log_reader, "time", SimpleNamespace(monotonic=lambda: now))
    reader = Reader(timeout_s=60.0, memory_bytes=2 << 30, worker=Finished())
    async with reader.turn("a"):
        await reader.read(log(tmp_path, carmen(7)), None)
        assert reader.progress == 0.9
    now += 265.0
    async with reader.turn("b"):
        assert (reader.progress, reader.elapsed_s) == (0.0, 0.0)
        now += 2.0
        assert reader.elapsed_s == 2.0
    await reader.close()


async def test_a_job_reports_progress_and_can_be_cancelled(reader: Reader, tmp_path: Path) -> None:
    source = tmp_path / "long.log"
    source.write_bytes(carmen(500) * 600)
    reading = asyncio.ensure_future(reader.read(source, tmp_path / "a.npz"))
    await eventually(lambda: 0.0 < reader.progress < 1.0)
    reading.cancel()
    with pytest.raises(asyncio.CancelledError):
        await reading
    assert not list((tmp_path / "leases").iterdir())
    assert (await reader.read(log(tmp_path, carmen(3)), None)).scans == 3, "its process has left the thread"
    assert not (tmp_path / "a.npz").exists()


async def test_a_job_is_limited_in_memory_and_time(tmp_path: Path) -> None:
    worker = ExecutorWorker(ThreadPoolExecutor(1), tmp_path)
    source = log(tmp_path, carmen(500) * 100)
    short = Reader(timeout_s=0.01, memory_bytes=2 << 30, worker=worker)
    with pytest.raises(LimitError) as caught:
        await short.read(source, None)
    assert caught.value.code == "log.time"
    small = Reader(timeout_s=PATIENCE_S, memory_bytes=100 << 20, worker=worker)
    with pytest.raises((LimitError, ReadError)) as told:
        await small.read(source, None)
    assert told.value.code in ("log.memory", "log.reader_died")
    await small.close()


async def test_a_process_begins_beside_the_event_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever asks for a process waits until the fork server has forked it."""
    begin, threads = Popen.__init__, list[threading.Thread]()

    def noted(popen: Popen, process: Any) -> None:
        threads.append(threading.current_thread())
        begin(popen, process)

    monkeypatch.setattr(Popen, "__init__", noted)
    worker = PoolWorker(2 << 30)
    for _ in range(2):
        assert await outcome_of(worker, Task(loaded, "sys"))
        worker.end()
    assert len(threads) == 2
    assert threading.current_thread() not in threads
    await asyncio.to_thread(worker.close)


async def test_a_missing_executor_gives_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(StorageError) as caught:
        await asyncio.to_thread(worker_at, "tcp://127.0.0.1:1", 1 << 30, tmp_path)
    assert caught.value.code == "library.executor"
    assert caught.value.message.endswith(".")


@pytest.mark.parametrize(("given_gib", "wanted_gib"), [(3, 5), (5, 3)])
async def test_the_lower_limit_of_memory_holds(given_gib: int, wanted_gib: int) -> None:
    """That of ``ulimit -v`` for the service, or its own for a worker; root could raise the first."""
    program = f"""
import resource
from server.jobs.process import begin
resource.setrlimit(resource.RLIMIT_AS, ({given_gib} << 30, {given_gib} << 30))
begin({wanted_gib} << 30, print)
print(*(limit >> 30 for limit in resource.getrlimit(resource.RLIMIT_AS)))
"""
    command = [sys.executable, "-c", program]
    done = await asyncio.to_thread(subprocess.run, command, capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout == "3 3\n"


@pytest.mark.parametrize(
    ("error", "wanted"),
    [
        (MemoryError(), "log.memory"),
        (ImportError("cannot map the library"), "log.memory"),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), "log.memory"),
        (OSError(errno.EIO, "Input/output error"), "OSError"),
        (ModuleNotFoundError("no module"), "ModuleNotFoundError"),
    ],
)
async def test_running_out_of_memory_in_an_import_is_the_limit_of_memory(error: Exception, wanted: str) -> None:
    def work() -> None:
        raise error

    with pytest.raises((LimitError, OSError, ImportError)) as told:
        bounded(60.0, 60.0, work)
    assert getattr(told.value, "code", type(error).__name__) == wanted


async def test_a_process_with_little_time_can_still_say_that_it_is_over() -> None:
    """The kernel ends a process at a whole second of processor time, which may be near when the job begins."""
    program = """
import os, time
from mapper.core.errors import LimitError
from server.jobs.process import bounded
numbers = range(20_000_000)  # the sum takes some 0.2 s in C, where no signal is heard
while time.process_time() % 1.0 < 0.9:
    pass
try:
    bounded(60.0, 0.01, lambda: sum(numbers))
except LimitError as error:
    print(error.code, flush=True)
"""
    command = [sys.executable, "-c", program]
    done = await asyncio.to_thread(subprocess.run, command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert (done.returncode, done.stdout) == (0, "log.time\n"), done.stderr


async def test_a_limit_holds_where_python_ignores_what_the_first_signal_raises() -> None:
    """In the callback of a weak reference, as imports have them, and in finalizers."""
    program = """
import time, weakref
from mapper.core.errors import LimitError
from server.jobs.process import bounded
class Thing:
    pass
def spin(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass
def work():
    thing = Thing()
    reference = weakref.ref(thing, lambda _: spin(0.3))
    del thing  # the signal after 0.1 s comes in the callback
    spin(60.0)
try:
    bounded(0.1, 60.0, work)
except LimitError as error:
    print(error.code, flush=True)
"""
    command = [sys.executable, "-c", program]
    done = await asyncio.to_thread(subprocess.run, command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert (done.returncode, done.stdout) == (0, "log.time\n"), done.stderr
