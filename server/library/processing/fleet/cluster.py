"""A Dask cluster that maps logs: one connection for all jobs, in a thread with its own event loop.

A log's bytes go to a worker through the scheduler in pieces, and the results come back. The workers need none of the
service's folders, and only the scheduler must be reachable. A lost connection is re-established.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import threading
import time
import uuid
from collections import Counter
from collections.abc import AsyncIterator, Callable, Coroutine
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import structlog

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import MapperError, ReadError
from server.library.processing.fleet.fleet_job import ClusterLostError, FleetJob, MapFacts, WorkerLostError
from server.storage import StorageError, disk_full
from server.version import package_version

if TYPE_CHECKING:
    from distributed import Client

    from server.library.processing.fleet import cluster_tasks as tasks

PIECE_BYTES = 4 << 20  #: of a log in one message
CONNECT_S = 5.0  #: timeout of one attempt to reach the scheduler
ANSWER_S = 10.0  #: timeout of answers of the scheduler and of workers
LOOK_S = 0.5  #: interval of checking the cluster and the running jobs
RENEW_S = 2.0  #: interval of renewing the lease of a job and querying its progress
NO_WORKER_S = 20.0  #: how long a job waits for a worker
CLOSE_S = 2.0
SIBLINGS = ("poses.txt",)  #: files that belong to another one in their folder: the poses of a sonar's readings

_log = structlog.get_logger(__name__)

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class ClusterState:
    """Workers that map logs, and their number of concurrent logs; ``error`` is why there are none or fewer."""

    workers: int = 0
    threads: int = 0
    error: str = ""


class Cluster:
    """The cluster whose scheduler is at ``place``, ``tcp://HOST:PORT`` or ``tls://HOST:PORT``.

    It need not be available: connecting is retried until :meth:`close`. Used from any thread. Raises
    :class:`StorageError` if Dask is not installed.
    """

    def __init__(self, place: str) -> None:
        require_dask()
        self._place = place
        self._client: Client | None = None
        self._threads: dict[str, int] = {}  #: by the address of a worker with this version of the package
        self._others: dict[str, str] = {}  #: why a worker gets no logs, by its address
        self._jobs: Counter[str] = Counter()  #: by the address of their worker
        self._tasks: set[asyncio.Task[Any]] = set()
        self._looked = threading.Event()
        self.state = ClusterState(error="The Dask cluster is not connected yet.")
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="dask cluster", daemon=True)
        self._thread.start()
        self._watching = self._begin(self._watch())

    def await_first_look(self) -> ClusterState:
        """Return the state once the cluster was reached or one attempt has failed. Blocks."""
        self._looked.wait(CONNECT_S + 2 * ANSWER_S)
        return self.state

    def submit(self, job: FleetJob, tell: Callable[[float], None]) -> Future[MapFacts]:
        """Have a log mapped, and its files written here; ``tell`` is called with the completed share.

        The future raises the job's exceptions, :class:`BrokenExecutor` if its process was killed,
        :class:`WorkerLostError` and :class:`ClusterLostError`. Cancelling it ends the job.
        """
        return self._begin(self._mapped(job, tell))

    def close(self) -> None:
        """Cancel running jobs and end the connection. Blocks for a few seconds at most."""
        if not self._thread.is_alive():
            return
        with contextlib.suppress(Exception):  # a scheduler that does not answer is left alone
            asyncio.run_coroutine_threadsafe(self._end(), self._loop).result(3 * CLOSE_S)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(CLOSE_S)
        if not self._thread.is_alive():
            self._loop.close()

    def _begin(self, work: Coroutine[Any, Any, T]) -> Future[T]:
        async def noted() -> T:
            task = asyncio.current_task()
            assert task is not None  # noqa: S101 - for the type checker: this runs in one
            self._tasks.add(task)
            try:
                return await work
            finally:
                self._tasks.discard(task)

        return asyncio.run_coroutine_threadsafe(noted(), self._loop)

    async def _end(self) -> None:
        tasks = [*self._tasks]
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks, timeout=CLOSE_S)
        await self._disconnect()

    # -- the connection -------------------------------------------------------------------------------------------

    async def _watch(self) -> None:
        """Keep the connection and the list of workers up to date."""
        while True:
            try:
                await self._look()
            except Exception as error:  # noqa: BLE001 - Dask raises many kinds, TypeError for tls:// without certificates
                if self.state.threads or not self._looked.is_set():
                    _log.warning("the Dask cluster is not reached", place=self._place, error=_first_line(error))
                await self._disconnect()
                self.state = ClusterState(error=f"The scheduler of the Dask cluster is not reached: {_kind_of(error)}.")
            self._looked.set()
            await asyncio.sleep(LOOK_S)

    async def _look(self) -> None:
        from distributed import Client  # noqa: PLC0415 - only where a cluster is asked for

        if self._client is None:
            client = Client(self._place, asynchronous=True, timeout=CONNECT_S, set_as_default=False)
            try:
                await asyncio.wait_for(client, CONNECT_S)  # its own timeout does not cover a silent peer
            except BaseException:
                await _closed(client)
                raise
            self._client = client
            _log.info("the Dask cluster is reached", place=self._place)
        client = self._client
        if client.status != "running":
            raise ConnectionError(f"the connection is {client.status}")
        workers: dict[str, int] = await asyncio.wait_for(client.nthreads(), ANSWER_S)
        new = [address for address in workers if address not in self._threads and address not in self._others]
        answers = await asyncio.gather(*(self._reason_against(client, address) for address in new))
        self._others = {address: why for address, why in self._others.items() if address in workers}
        self._others |= {address: why for address, why in zip(new, answers, strict=True) if why}
        self._threads = {address: threads for address, threads in workers.items() if address not in self._others}
        error = ""
        if self._others:
            error = f"{len(self._others)} of {len(workers)} workers get no logs: {next(iter(self._others.values()))}."
        elif not workers:
            error = "The Dask cluster has no workers."
        self.state = ClusterState(len(self._threads), sum(self._threads.values()), error)

    async def _reason_against(self, client: Client, address: str) -> str:
        """Return why a new worker gets no logs, empty if it may have some."""
        from server.library.processing.fleet import cluster_tasks as tasks  # noqa: PLC0415 - it needs Dask

        try:
            version = await _answer(client.run(tasks.version, workers=[address]), address)
        except Exception as error:  # noqa: BLE001 - whatever is wrong with it
            return f"Gridbloom cannot be imported there ({_kind_of(error)})"
        own = package_version()
        return "" if version == own else f"Gridbloom is version {version!s:.40} there, here {own}"

    async def _disconnect(self) -> None:
        client, self._client = self._client, None
        self._threads, self._others = {}, {}
        if client is not None:
            await _closed(client)

    # -- a job ----------------------------------------------------------------------------------------------------

    async def _mapped(self, job: FleetJob, tell: Callable[[float], None]) -> MapFacts:
        client, address = await self._free_worker()
        self._jobs[address] += 1
        try:
            outcome = await self._mapped_at(client, address, job, tell)
        except MapperError:
            raise
        except Exception as error:
            if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
                raise ReadError("fleet.no_room", "The worker of the cluster has no room for this log.") from None
            if self._client is not client:
                raise _cluster_lost() from error
            _log.warning("a worker of the Dask cluster failed", worker=address, error=_first_line(error))
            raise WorkerLostError(
                "fleet.worker_lost", "The worker of the cluster that mapped this log is gone."
            ) from error
        finally:
            self._jobs[address] -= 1
        if isinstance(outcome, Exception):
            raise outcome
        await asyncio.to_thread(_write, outcome, job)
        return outcome.facts

    async def _free_worker(self) -> tuple[Client, str]:
        """Return a worker with the most free threads, if there is one. Raises :class:`ClusterLostError`."""
        missing_since = time.monotonic()
        while True:
            free = {address: threads - self._jobs[address] for address, threads in self._threads.items()}
            address = max(free, key=free.__getitem__, default=None)
            if address is not None and self._client is not None:
                missing_since = time.monotonic()
                if free[address] > 0:
                    return self._client, address
            if time.monotonic() - missing_since > NO_WORKER_S:
                raise _cluster_lost()
            await asyncio.sleep(0.1)

    async def _mapped_at(
        self, client: Client, address: str, job: FleetJob, tell: Callable[[float], None]
    ) -> tasks.Mapped | Exception:
        """Send a log to a worker and return the result. Raises if the cluster fails."""
        from server.library.processing.fleet import cluster_tasks as tasks  # noqa: PLC0415 - it needs Dask

        ticket = uuid.uuid4().hex

        async def ask(function: Callable[..., Any], *arguments: object) -> Any:  # noqa: ANN401 - what it returns
            return await _answer(client.run(function, ticket, *arguments, workers=[address]), address)

        try:
            await ask(tasks.begin_job)
            source = Path(job.source)
            async for name, piece in _pieces(source):
                await ask(tasks.write_piece, name, piece)
            key = f"gridbloom-fleet-{ticket}"
            arguments = (ticket, job, source.name)
            future = client.submit(tasks.map_sent_log, *arguments, workers=[address], pure=False, key=key)
            try:
                result: Any = future.result()  # awaitable, because the client is asynchronous
                return await self._awaited(client, address, asyncio.ensure_future(result), ask, tell)
            finally:
                future.release()
        finally:
            with contextlib.suppress(Exception):  # if this fails, the job ends when its lease expires
                await asyncio.shield(asyncio.wait_for(ask(tasks.end_job), CLOSE_S))

    async def _awaited(
        self,
        client: Client,
        address: str,
        done: asyncio.Future[tasks.Mapped | Exception],
        ask: Callable[..., Coroutine[Any, Any, Any]],
        tell: Callable[[float], None],
    ) -> tasks.Mapped | Exception:
        """Return the result of a job, renewing its lease meanwhile. Raises if the cluster fails."""
        from server.library.processing.fleet import cluster_tasks as tasks  # noqa: PLC0415 - it needs Dask

        asked = renewed = time.monotonic()
        try:
            while True:
                await asyncio.wait([done], timeout=LOOK_S)
                if done.done():
                    break
                if self._client is not client or address not in self._threads:
                    raise ConnectionError("the worker is gone")
                if time.monotonic() - asked < RENEW_S:
                    continue
                asked = time.monotonic()
                try:
                    tell(await ask(tasks.renew_lease))
                    renewed = time.monotonic()
                except Exception:
                    if time.monotonic() - renewed > tasks.LEASE_S:
                        raise
        finally:
            done.cancel()
        if done.cancelled():
            raise ConnectionError("the cluster has cancelled the job")
        return done.result()


def require_dask() -> None:
    """Raise :class:`StorageError` if Dask is not installed."""
    try:
        import distributed  # noqa: F401, PLC0415 - only where a cluster is asked for
    except ImportError:
        message = "A Dask cluster needs Dask: pip install 'gridbloom[dask]'."
        raise StorageError("fleet.dask", message) from None


async def _answer(asked: Any, address: str) -> Any:  # noqa: ANN401 - of Dask
    """Return the answer of the worker at ``address``; raises what it raises, and :class:`OSError`."""
    return (await asyncio.wait_for(asked, ANSWER_S))[address]


async def _pieces(source: Path) -> AsyncIterator[tuple[str, bytes]]:
    """Yield the bytes of a log with the name of their file, in order; nothing for a missing one.

    For a log that is a folder, the names start with the folder's. Raises :class:`ReadError`.
    """
    try:
        for name, path in await asyncio.to_thread(_files, source):
            piece = await asyncio.to_thread(_piece, path, 0)
            yield name, piece  # also for an empty file
            at = len(piece)
            while piece := await asyncio.to_thread(_piece, path, at):
                yield name, piece
                at += len(piece)
    except OSError as error:
        raise ReadError("log.unreadable", f"The log cannot be read: {error.strerror}.") from None


def _piece(path: Path, at: int) -> bytes:
    """Return the bytes of a file from ``at`` on. It is opened for each piece, so that cancelling is safe."""
    with path.open("rb") as file:
        file.seek(at)
        return file.read(PIECE_BYTES)


def _files(source: Path) -> list[tuple[str, Path]]:
    if source.is_dir():
        files = sorted(path for path in source.rglob("*") if path.is_file())
        return [(str(path.relative_to(source.parent)), path) for path in files]
    named = [source, *(source.with_name(name) for name in SIBLINGS if name != source.name)]
    return [(path.name, path) for path in named if path.exists()]


def _write(mapped: tasks.Mapped, job: FleetJob) -> None:
    """Write the files produced by a job to their destinations. Raises :class:`StorageError`."""
    picture = Path(job.picture)
    places = {picture.name: picture}
    if job.map is not None:
        maps = [Path(f"{job.map}{ending}") for ending in (".pgm", ".yaml")]  # the image before the file that names it
        places |= {path.name: path for path in maps}
    try:
        for name in [name for name in places if name in mapped.files]:
            with atomic_write(places[name]) as file:
                file.write(mapped.files[name])
    except OSError as error:
        raise disk_full() from error


async def _closed(client: Client) -> None:
    with contextlib.suppress(Exception):  # the scheduler may be gone
        await asyncio.wait_for(client.close(timeout=CLOSE_S), 2 * CLOSE_S)


def _cluster_lost() -> ClusterLostError:
    return ClusterLostError("fleet.cluster_lost", "The Dask cluster is not reached, or has no workers that map logs.")


def _first_line(error: BaseException) -> str:
    return str(error).partition("\n")[0][:200] or type(error).__name__


def _kind_of(error: BaseException) -> str:
    """Return the kind of an error. Its text may contain addresses, which visitors need not know."""
    return type(error).__name__
