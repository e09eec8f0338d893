"""A fleet of logs: each is given to one worker, and has one result in a folder, which a later run goes on from.

The results are files ``results/KEY.json``, written whole by this process alone (it holds the folder): a log has one
however often its worker dies. The key is a digest of the log's path, size and time of its last change.
"""

from __future__ import annotations

import hashlib
import json
import os
import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError, MapperError
from server.fleet.job import FleetJob, FleetLimits
from server.library.storage import StorageError, claimed
from server.library.workers import ExecutorWorker, PoolWorker, Worker

RUNS = 2  #: of a log whose process was ended: the machine may be at fault
AHEAD = 1  #: logs that wait at the cluster beside those that its threads do, so that none waits for a log


@dataclass(frozen=True, slots=True)
class Result:
    """What came of one log: ``facts`` as :func:`server.fleet.job.do_fleet_job` returns them, or an error."""

    key: str
    log: str
    seconds: float
    runs: int
    facts: dict[str, Any] | None = None
    code: str = ""
    message: str = ""

    @property
    def failed(self) -> bool:
        """Whether there is no map of it."""
        return self.facts is None

    def public(self) -> dict[str, Any]:
        """Return what its file holds."""
        error = {"code": self.code, "message": self.message} if self.failed else None
        return {"log": self.log, "seconds": self.seconds, "runs": self.runs, "error": error, "facts": self.facts}


class Fleet:
    """The logs at ``paths`` and their results in ``folder``; used by one process at a time, see :meth:`held`."""

    def __init__(self, paths: Sequence[Path], folder: Path, limits: FleetLimits | None = None) -> None:
        self.folder = folder
        self.logs = {key_of(path): path.absolute() for path in paths}
        self._limits = limits or FleetLimits()
        self._lock = threading.Lock()
        self.results: dict[str, Result] = {}

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the folder and read the results of earlier runs. Raises :class:`ConfigError`."""
        try:
            for name in ("results", "maps", "leases"):
                (self.folder / name).mkdir(parents=True, exist_ok=True)
            with claimed(self.folder):
                for key in self.logs:
                    self._read(key)
                yield
        except StorageError:
            raise ConfigError("fleet.held", "Another run writes into this folder: wait for its end.") from None
        except OSError as error:
            raise ConfigError("fleet.folder", f"The results cannot be written: {error.strerror}.") from None

    def _read(self, key: str) -> None:
        try:
            found = json.loads((self.folder / "results" / f"{key}.json").read_text(encoding="utf-8"))
            error = found["error"] or {"code": "", "message": ""}
            self.results[key] = Result(key, found["log"], found["seconds"], found["runs"], found["facts"], **error)
        except (OSError, ValueError, KeyError, TypeError):
            return  # none yet

    def run(self, workers: Sequence[Worker], done: Callable[[Result], None], *, again: bool = False) -> None:
        """Have every log done that has no result yet, by all workers at once; ``again``: also those that failed.

        ``done`` is called after each, by one thread at a time. An interrupt ends the workers; what is done stays.
        Raises :class:`ConfigError` where a result cannot be written.
        """
        waiting: queue.SimpleQueue[str] = queue.SimpleQueue()
        for key in self.logs:
            if key not in self.results or (again and self.results[key].failed):
                self.results.pop(key, None)
                waiting.put(key)
        errors: list[BaseException] = []
        ended = threading.Event()

        def serve(worker: Worker) -> None:
            try:
                while not ended.is_set():
                    result = self._done(waiting.get_nowait(), worker, ended)
                    if result is not None:
                        with self._lock:
                            self._write(result)
                            done(result)
            except queue.Empty:
                return
            except BaseException as error:  # noqa: BLE001 - raised in the thread that waits
                errors.append(error)
                ended.set()

        threads = [threading.Thread(target=serve, args=(worker,), daemon=True) for worker in workers]
        for thread in threads:
            thread.start()
        try:
            for thread in threads:
                while thread.is_alive():
                    thread.join(0.2)
        finally:
            ended.set()
            for worker in workers:
                worker.end()
        if errors:
            raise errors[0]

    def _done(self, key: str, worker: Worker, ended: threading.Event) -> Result | None:
        """Have a log done; None where the run was ended meanwhile."""
        path, limits, began = self.logs[key], self._limits, time.monotonic()
        out = str((self.folder / "maps" / key).absolute())
        job = FleetJob(str(path), out, limits.timeout_s, limits.cpu_s, limits.memory_bytes)
        failure = ("fleet.died", "The process of this log was ended, most likely because it needs too much memory.")
        for run in range(1, RUNS + 1):
            try:
                facts = worker.submit(job).result()
                return Result(key, str(path), round(time.monotonic() - began, 3), run, facts)
            except BrokenExecutor:
                worker.end()
                if ended.is_set():
                    return None
                continue
            except MapperError as error:
                failure = (error.code, error.message)
            except Exception as error:  # noqa: BLE001 - a defect in one log's job fails this log alone
                if ended.is_set():
                    return None
                failure = ("fleet.failed", f"The job failed: {type(error).__name__}.")
            break
        return Result(key, str(path), round(time.monotonic() - began, 3), run, None, *failure)

    def _write(self, result: Result) -> None:
        try:
            with atomic_write(self.folder / "results" / f"{result.key}.json") as file:
                file.write(json.dumps(result.public()).encode())
        except OSError as error:
            raise ConfigError("fleet.folder", f"The results cannot be written: {error.strerror}.") from None
        self.results[result.key] = result


def key_of(path: Path) -> str:
    """Return what names a log and its contents in a folder of results."""
    try:
        found = path.stat()
        what = f"{path.absolute()}\n{found.st_size}\n{found.st_mtime_ns}"
    except OSError:  # its result says that it is missing
        what = f"{path.absolute()}"
    return hashlib.sha256(what.encode("utf-8", "surrogateescape")).hexdigest()[:20]


@contextmanager
def workers_at(place: str | None, count: int | None, folder: Path, memory_bytes: int) -> Iterator[list[Worker]]:
    """Yield workers: processes of this machine, or of the Dask cluster whose scheduler is at ``place``.

    ``count`` is how many logs are done at once; None: a log for each core or thread of a worker. All see ``folder`` at
    the same path. Raises :class:`ConfigError` where there is no cluster.
    """
    workers: list[Worker]
    if place is None:
        workers = [PoolWorker(memory_bytes) for _ in range(count or os.cpu_count() or 1)]
        try:
            yield workers
        finally:
            for worker in workers:
                worker.close()
        return
    try:
        from distributed import Client  # noqa: PLC0415 - only where it is asked for
    except ImportError:
        raise ConfigError("fleet.dask", "A Dask cluster needs Dask: pip install 'gridbloom[dask]'.") from None
    try:
        client = Client(place, timeout=10, set_as_default=False)
    except (OSError, TypeError) as error:
        raise ConfigError("fleet.dask", f"The Dask scheduler at {place} cannot be reached: {error}.") from None
    with client:
        threads = sum(client.nthreads().values())
        executor = client.get_executor(pure=False)
        yield [ExecutorWorker(executor, folder) for _ in range(count or max(1, threads + AHEAD))]
