"""A fleet of log files: each is mapped by one worker, and has one result in a folder, from which a later run continues.

The results are files ``results/KEY.json``, written atomically and only by this process (it holds the folder), so that a
log has one result however often its worker dies. The key is a digest of the log's path, size and time of its last
change.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import msgspec

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError, MapperError
from server.jobs.process import JobLimits
from server.jobs.workers import PoolWorker, Worker
from server.library.processing.fleet.cluster import Cluster
from server.library.processing.fleet.cluster_worker import ClusterWorker
from server.library.processing.fleet.fleet_job import (
    DIED,
    LIMITS,
    RUNS,
    ClusterLostError,
    FleetJob,
    LogOptions,
    MapFacts,
    fleet_facts,
)
from server.storage import StorageError, claimed


@dataclass(frozen=True, slots=True)
class Result:
    """Result of one log: ``facts`` about it, or an error."""

    key: str
    log: str
    seconds: float
    runs: int
    facts: MapFacts | None = None
    code: str = ""
    message: str = ""

    @property
    def failed(self) -> bool:
        """Whether it has no map."""
        return self.facts is None

    def public(self) -> dict[str, object]:
        """Return the contents of its file."""
        error = {"code": self.code, "message": self.message} if self.failed else None
        facts = None if self.facts is None else asdict(self.facts)
        return {"log": self.log, "seconds": self.seconds, "runs": self.runs, "error": error, "facts": facts}


class Fleet:
    """The logs at ``paths`` and their results in ``folder``; used by one process at a time, see :meth:`held`.

    All logs are read with the same ``options``. Other options yield other results.
    """

    def __init__(
        self, paths: Sequence[Path], folder: Path, limits: JobLimits = LIMITS, options: LogOptions | None = None
    ) -> None:
        self.folder = folder
        self._options = options or LogOptions()
        self.logs = {key_of(path, self._options): path.absolute() for path in paths}
        self._limits = limits
        self.results: dict[str, Result] = {}

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the folder and read the results of earlier runs. Raises :class:`ConfigError`."""
        try:
            for name in ("results", "maps"):
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
            stored = json.loads((self.folder / "results" / f"{key}.json").read_text(encoding="utf-8"))
            error = stored["error"] or {"code": "", "message": ""}
            facts = msgspec.convert(stored["facts"], MapFacts | None)
            self.results[key] = Result(key, stored["log"], stored["seconds"], stored["runs"], facts, **error)
        except (OSError, ValueError, KeyError, TypeError, msgspec.ValidationError):
            return  # none yet

    def run(self, workers: Sequence[Worker], done: Callable[[Result], None], *, again: bool = False) -> None:
        """Map every log without a result, with all workers in parallel; ``again``: also those that failed.

        ``done`` is called after each. An interrupt ends the workers; finished results are kept. Raises
        :class:`ConfigError` if a result cannot be written, and if the cluster is lost.
        """
        waiting: deque[str] = deque()
        for key in self.logs:
            if key not in self.results or (again and self.results[key].failed):
                self.results.pop(key, None)
                waiting.append(key)

        async def serve(worker: Worker) -> None:
            while waiting:
                result = await self._done(waiting.popleft(), worker)
                self._write(result)
                done(result)

        async def serve_all() -> None:
            async with asyncio.TaskGroup() as group:
                for worker in workers:
                    group.create_task(serve(worker))

        try:
            asyncio.run(serve_all())
        except ExceptionGroup as group:
            raise group.exceptions[0] from None
        finally:
            for worker in workers:
                worker.end()

    async def _done(self, key: str, worker: Worker) -> Result:
        """Map one log."""
        path, began = self.logs[key], time.monotonic()
        out = (self.folder / "maps" / key).absolute()
        job = FleetJob(str(path), str(out), str(out.with_name(f"{key}.png")), self._limits, options=self._options)
        try:
            facts, runs = await fleet_facts(worker, job)
            return Result(key, str(path), round(time.monotonic() - began, 3), runs, facts)
        except ClusterLostError:
            message = "The Dask cluster is gone. What is done stays: run this again to go on."
            raise ConfigError("fleet.cluster_lost", message) from None
        except MapperError as error:
            failure = (error.code, error.message)
        except Exception as error:  # noqa: BLE001 - a defect in one log's job fails this log alone
            failure = ("fleet.failed", f"The job failed: {type(error).__name__}.")
        return Result(
            key, str(path), round(time.monotonic() - began, 3), RUNS if failure[0] == DIED else 1, None, *failure
        )

    def _write(self, result: Result) -> None:
        try:
            with atomic_write(self.folder / "results" / f"{result.key}.json") as file:
                file.write(json.dumps(result.public()).encode())
        except OSError as error:
            raise ConfigError("fleet.folder", f"The results cannot be written: {error.strerror}.") from None
        self.results[result.key] = result


def key_of(path: Path, options: LogOptions) -> str:
    """Return the key of a log, its contents and the options of reading it, for a folder of results."""
    try:
        status = path.stat()
        what = f"{path.absolute()}\n{status.st_size}\n{status.st_mtime_ns}"
    except OSError:  # its result reports that it is missing
        what = f"{path.absolute()}"
    if options != LogOptions():
        what += "\n" + json.dumps(asdict(options), sort_keys=True)
    return hashlib.sha256(what.encode("utf-8", "surrogateescape")).hexdigest()[:20]


@contextmanager
def workers_at(place: str | None, count: int | None, memory_bytes: int) -> Iterator[list[Worker]]:
    """Yield workers: processes of this machine, or of the Dask cluster whose scheduler is at ``place``.

    ``count`` is the number of logs mapped in parallel; None: one for each core or thread of a worker, which is the
    maximum for a cluster. Raises :class:`ConfigError` if there is no cluster, or none of its workers can map logs.
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
        cluster = Cluster(place)
    except StorageError as error:
        raise ConfigError(error.code, error.message) from None
    try:
        state = cluster.await_first_look()
        if not state.threads:
            raise ConfigError("fleet.dask", f"{state.error} It was looked for at {place}.")
        yield [ClusterWorker(cluster) for _ in range(min(count or state.threads, state.threads))]
    finally:
        cluster.close()
