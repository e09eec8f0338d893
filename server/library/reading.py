"""Reading a log in a process of its own: what a file can do there, it can do to nobody else.

The worker has a limit of memory, of processor time and of time on the clock; one that dies fails its own job and no
other, because only one job is in its hands at a time and the others wait here.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import math
import multiprocessing
import multiprocessing.connection
import os
import resource
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractAsyncContextManager
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path

from mapper.errors import LimitError, ReadError
from mapper.logs import open_log
from mapper.logs.summary import LogSummary, summarise
from server.library.packed import write_pack
from server.library.turns import Turns

GRACE_S = 10.0  #: how long a job over its time may take to notice before its process is ended

_progress: Synchronized[float] | None = None  #: the worker's end of the shared number


def _start_worker(progress: Synchronized[float], pid: Synchronized[int], memory_bytes: int) -> None:
    """Run once in the new process: its limit of address space, and where it says how far it is."""
    global _progress  # noqa: PLW0603 - a worker process has no other place that outlives a job
    _progress = progress
    pid.value = os.getpid()
    threading.Thread(target=_end_with_server, name="end with the server", daemon=True).start()
    # A person who presses Ctrl-C speaks to the server, which ends its workers itself.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(ValueError, OSError):  # not every system can limit it
        resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))


def _end_with_server() -> None:
    """End this process when the server is gone: killed, it ends nobody, and what it began must not go on."""
    server = multiprocessing.parent_process()
    if server is not None:
        multiprocessing.connection.wait([server.sentinel])
        os._exit(1)


def _note_progress(fraction: float) -> None:
    if _progress is not None:
        _progress.value = min(max(float(fraction), 0.0), 1.0)


class _OutOfTime(BaseException):
    """The job's time is over: no ``Exception``, so that no reader catches it."""


def _out_of_time(number: int, _: object) -> None:
    raise _OutOfTime(number)


@contextlib.contextmanager
def _timed(timeout_s: float, cpu_s: float) -> Iterator[None]:
    """Interrupt what runs in it after so many seconds on the clock, or of processor time.

    What runs in C for long hears no signal: then the kernel ends the process, after as much processor time again.
    """
    alarms = ((signal.SIGALRM, signal.ITIMER_REAL, timeout_s), (signal.SIGPROF, signal.ITIMER_PROF, cpu_s))
    used = resource.getrusage(resource.RUSAGE_SELF)
    with contextlib.suppress(ValueError, OSError):
        last = int(used.ru_utime + used.ru_stime + 2.0 * cpu_s) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (last, resource.getrlimit(resource.RLIMIT_CPU)[1]))
    try:
        for number, timer, seconds in alarms:
            signal.signal(number, _out_of_time)
            signal.setitimer(timer, seconds)
        yield
    except _OutOfTime as over:
        raise _time_error(timeout_s) if over.args[0] == signal.SIGALRM else _cpu_error(cpu_s) from None
    finally:
        for _, timer, _ in alarms:
            signal.setitimer(timer, 0.0)


def read_job(source: str, pack: str | None, timeout_s: float, cpu_s: float, topic: str | None = None) -> LogSummary:
    """Read the log file ``source``, pack it into ``pack`` if there is one and return what it holds. Runs in the worker.

    ``topic`` names the sensor where there are several.

    Raises :class:`ReadError` or :class:`LimitError`, which cross to the server with their codes.
    """
    _note_progress(0.0)
    try:
        with _timed(timeout_s, cpu_s):
            return _read(source, pack, topic)
    except MemoryError:
        raise LimitError("log.memory", "Reading this log needs more memory than the server gives to one log.") from None


def _read(source: str, pack: str | None, topic: str | None) -> LogSummary:
    log = open_log(Path(source), topic=topic, progress=_note_progress)
    if pack is not None:
        try:
            write_pack(log, Path(pack))
        except OSError as error:
            message = "What was read of the log could not be stored; the server's disk may be full."
            raise LimitError("log.storage", message) from error
    return summarise(log)


def _time_error(timeout_s: float) -> LimitError:
    return LimitError("log.time", f"Reading this log takes longer than the {timeout_s:g} s that the server allows.")


def _cpu_error(cpu_s: float) -> LimitError:
    return LimitError("log.time", f"Reading this log takes more than the {cpu_s:g} s of processor time it may have.")


class Reader:
    """One worker process, made when the first log is to be read. Used from the event loop only."""

    def __init__(self, *, timeout_s: float, memory_bytes: int, cpu_s: float = math.inf) -> None:
        self._timeout_s = timeout_s
        self._cpu_s = min(cpu_s, timeout_s)
        self._memory_bytes = memory_bytes
        self._turns = Turns()
        self._pool: ProcessPoolExecutor | None = None
        self._context = multiprocessing.get_context("spawn")  # a fork would copy threads' locks and the sockets
        self._progress: Synchronized[float] | None = None
        self._pid: Synchronized[int] | None = None

    @property
    def progress(self) -> float:
        """How far the log that is being read is, from 0 to 1."""
        return 0.0 if self._progress is None else float(self._progress.value)

    @property
    def worker_pid(self) -> int:
        """The worker's process, 0 before there is one."""
        return 0 if self._pid is None else int(self._pid.value)

    def turn(self, owner: str) -> AbstractAsyncContextManager[None]:
        """Wait until a log of ``owner`` may be read, and hold the turn: only its holder may call :meth:`read`."""
        return self._turns.of(owner)

    async def read(self, source: Path, pack: Path | None, topic: str | None = None) -> LogSummary:
        """Have ``source`` read, and packed into ``pack`` if there is one; the caller holds :meth:`turn`.

        Raises :class:`ReadError` or :class:`LimitError`, also for a worker that died or took too long.
        """
        if self._progress is not None:
            self._progress.value = 0.0
        try:
            job = self._submit(source, pack, topic)
        except BrokenProcessPool:  # the worker died while it had nothing to do: no fault of this log
            self._end_worker()
            job = self._submit(source, pack, topic)
        try:
            return await asyncio.wait_for(job, self._timeout_s + GRACE_S)
        except TimeoutError:
            self._end_worker()
            raise _time_error(self._timeout_s) from None
        except BrokenProcessPool:
            self._end_worker()
            raise ReadError(
                "log.reader_died",
                "The process that read this log was ended, most likely because the log needs too much memory or time.",
            ) from None
        except asyncio.CancelledError:
            self._end_worker()
            raise

    def _submit(self, source: Path, pack: Path | None, topic: str | None) -> asyncio.Future[LogSummary]:
        if self._pool is None:
            # Of its own: a worker that was ended before it began may still note who it is.
            self._progress = self._context.Value(ctypes.c_double, 0.0)
            self._pid = self._context.Value(ctypes.c_int64, 0)
            self._pool = ProcessPoolExecutor(
                1,
                mp_context=self._context,
                initializer=_start_worker,
                initargs=(self._progress, self._pid, self._memory_bytes),
            )
        return asyncio.get_running_loop().run_in_executor(
            self._pool,
            read_job,
            str(source),
            None if pack is None else str(pack),
            self._timeout_s,
            self._cpu_s,
            topic,
        )

    def _end_worker(self) -> ProcessPoolExecutor | None:
        """End the worker at once; the next job gets a new one."""
        pool, self._pool = self._pool, None
        if pool is not None:
            for worker in list((pool._processes or {}).values()):  # noqa: SLF001 - public only from Python 3.14 on
                worker.kill()
            self._progress = self._pid = None
            pool.shutdown(wait=False, cancel_futures=True)
        return pool

    async def close(self) -> None:
        """End the worker and wait until it is gone."""
        pool = self._end_worker()
        if pool is not None:
            await asyncio.to_thread(pool.shutdown, wait=True)
