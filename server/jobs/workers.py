"""Workers that do the jobs of logs on a ``concurrent.futures.Executor``, each job in its own process.

The default is a pool of one process on this machine, which stays warm between logs. Any other executor, such as that of
a Dask cluster, starts a process for each log on a machine of its choice, which sees the data folder at the same path.
"""

from __future__ import annotations

import asyncio
import ctypes
import multiprocessing
import os
import pickle
import subprocess
import sys
import threading
import uuid
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path
from typing import Any, Protocol, TypeVar

from server.jobs import process
from server.jobs.process import BoundedJob
from server.process_folder import process_folder
from server.storage import StorageError

GRACE_S = 10.0  #: how long a job may take to notice its timeout before its process is killed
DIED = 70  #: exit status of a process whose job was cancelled


T = TypeVar("T")


class Worker(Protocol):
    """Does jobs, one at a time."""

    @property
    def progress(self) -> float:
        """Progress of the current job, from 0 to 1."""

    @property
    def pid(self) -> int:
        """Id of the reading process, 0 if there is none on this machine."""

    async def prepare(self) -> None:
        """Start the process of the next job without blocking the event loop, if it runs on this machine."""

    def submit(self, job: BoundedJob[T]) -> Future[T]:
        """Have a job done in its own process, which enforces the job's limits of memory and time.

        The future raises the job's exceptions, such as :class:`ReadError` or :class:`LimitError`, and
        :class:`BrokenExecutor` if the process was killed. Neither affects the next job.
        """

    def end(self) -> None:
        """Cancel the running job, if any; later jobs are not affected."""

    def close(self) -> None:
        """Cancel the running job and wait until its process has ended."""


class PoolWorker:
    """One process of this machine, created when the first log is read."""

    def __init__(self, memory_bytes: int) -> None:
        self._memory_bytes = memory_bytes
        # Forks of a separate process, because one of the service would copy its threads' locks and its sockets.
        self._context = multiprocessing.get_context("forkserver")
        # The folder of its socket. One created by multiprocessing would remain if this process is killed.
        multiprocessing.current_process()._config["tempdir"] = str(process_folder())  # type: ignore[attr-defined]  # noqa: SLF001
        self._context.set_forkserver_preload(["server.library.processing.fork_server"])
        self._beginning = threading.Lock()
        self._pool: ProcessPoolExecutor | None = None
        self._progress: Synchronized[float] | None = None
        self._pid: Synchronized[int] | None = None

    @property
    def progress(self) -> float:
        """Progress of the log being read."""
        return 0.0 if self._progress is None else float(self._progress.value)

    @property
    def pid(self) -> int:
        """Id of the process."""
        return 0 if self._pid is None else int(self._pid.value)

    async def prepare(self) -> None:
        """Start the process on a thread: the first one of a service takes a second, each further one about 20 ms."""
        if self._pool is None:
            await asyncio.to_thread(self._begun)

    def submit(self, job: BoundedJob[T]) -> Future[T]:
        """Submit a job."""
        if self._progress is not None:
            self._progress.value = 0.0
        try:
            return self._begun().submit(job.do)
        except BrokenExecutor:  # the process died while idle, which is not the fault of this log
            self.end()
            return self._begun().submit(job.do)

    def _begun(self) -> ProcessPoolExecutor:
        """Return the pool after starting its process (any thread)."""
        with self._beginning:
            pool = self._pool
            if pool is None:
                # New ones, because a process that was killed before it started may still write its id.
                progress, pid = self._context.Value(ctypes.c_double, 0.0), self._context.Value(ctypes.c_int64, 0)
                pool = ProcessPoolExecutor(
                    1,
                    mp_context=self._context,
                    initializer=process.start_worker,
                    initargs=(progress, pid, self._memory_bytes),
                )
                pool.submit(os.getpid)  # a pool starts its process with its first job
                self._progress, self._pid, self._pool = progress, pid, pool
            return pool

    def end(self) -> None:
        """End the process."""
        self._ended()

    def _ended(self) -> ProcessPoolExecutor | None:
        pool, self._pool = self._pool, None
        if pool is not None:
            for process in list((pool._processes or {}).values()):  # noqa: SLF001 - public only from Python 3.14 on
                process.kill()
            self._progress = self._pid = None
            pool.shutdown(wait=False, cancel_futures=True)
        return pool

    def close(self) -> None:
        """End the process and wait until it is gone."""
        with self._beginning:
            pool = self._ended()
        if pool is not None:
            pool.shutdown(wait=True)


class ExecutorWorker:
    """A worker of ``executor`` that starts a process for each log; all see ``folder`` at the same path.

    A file in it is the job's lease: it contains the job's progress, and without it the job ends.
    """

    pid = 0

    def __init__(self, executor: Executor, folder: Path) -> None:
        self._executor = executor
        self._folder = folder
        self._lease: Path | None = None
        self._job: Future[Any] | None = None

    @property
    def progress(self) -> float:
        """Progress of the log being read."""
        try:
            return float(self._lease.read_bytes() or 0.0) if self._lease is not None else 0.0
        except (OSError, ValueError):
            return 0.0

    async def prepare(self) -> None:
        """Do nothing, because the executor manages its workers."""

    def submit(self, job: BoundedJob[T]) -> Future[T]:
        """Submit a job."""
        self.end()
        lease = self._lease = self._folder / f"{uuid.uuid4().hex}.lease"
        lease.write_bytes(b"0")
        done: Future[Any] = self._executor.submit(do_in_process, job, str(lease))
        self._job = done
        done.add_done_callback(lambda _: lease.unlink(missing_ok=True))
        return done

    def end(self) -> None:
        """Remove the lease."""
        if self._lease is not None:
            self._lease.unlink(missing_ok=True)
        if self._job is not None:
            self._job.cancel()
        self._lease = self._job = None

    def close(self) -> None:
        """Remove the lease, and release the executor."""
        self.end()
        self._executor.shutdown(wait=True)


def do_in_process(job: BoundedJob[T], lease: str) -> T:
    """Do a job in its own process, and raise its exceptions; :class:`BrokenExecutor` if it was killed."""
    command = [sys.executable, "-m", "server.jobs.worker_main"]
    try:
        done = subprocess.run(  # noqa: S603 - nothing of it is anybody's input
            command,
            input=pickle.dumps((job, lease)),
            stdout=subprocess.PIPE,
            timeout=job.limits.timeout_s + GRACE_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise job.time_error() from None
    if done.returncode != 0:
        raise BrokenExecutor(f"the process of a job ended with {done.returncode}")
    result: T | Exception = pickle.loads(done.stdout)  # noqa: S301 - by our own process, as a pool's are
    if isinstance(result, Exception):
        raise result
    return result


def worker_at(place: str | None, memory_bytes: int, folder: Path) -> Worker:
    """Return the worker at ``place``: None is this machine, ``tcp://HOST:PORT`` the scheduler of a Dask cluster.

    With ``tls`` instead of ``tcp``, Dask's own settings name the certificates (``distributed.comm.tls``). Blocks until
    it is available. Raises :class:`StorageError` if there is none.
    """
    if place is None:
        return PoolWorker(memory_bytes)
    try:
        from distributed import Client  # noqa: PLC0415 - only where it is asked for
    except ImportError:
        raise StorageError("library.executor", "Reading on Dask needs it: pip install 'gridbloom[dask]'.") from None
    try:
        return ExecutorWorker(Client(place, timeout=10, set_as_default=False).get_executor(), folder)
    except (OSError, TypeError) as error:  # TypeError: tls:// without the certificates
        raise StorageError("library.executor", f"The Dask scheduler at {place} cannot be reached: {error}.") from error
