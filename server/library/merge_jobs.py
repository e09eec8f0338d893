"""Jobs that bring two logs of one place into one frame: one at a time, owners in rotation, each kept until it is done.

What a job has made is a trajectory of each of the two logs, and one more log with the scans of both. A job that the end
of the service interrupts is begun again at the next start. All methods run on the event loop.
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import shutil
import time
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import structlog

from mapper.core.errors import ConfigError, LimitError, MapperError
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import ScanLog
from server.library.database import Database
from server.library.following import followed
from server.library.job_record import load_job_records, put_job_record
from server.library.leases import Lease, Leases, Once
from server.library.merge_job import BOTH, ENDINGS, GRAPH, LOG, NAME, STAGE, MergeJob
from server.library.merge_record import MergeRecord
from server.library.pose_job_kind import JobLimits, Logs
from server.library.pose_jobs import MOST_ATTEMPTS, emptied, packed
from server.library.records import Failure, Record
from server.library.slam_job import NAME as SLAM
from server.library.storage import StorageError, private_folder
from server.library.tables import merge_jobs
from server.library.trajectories import NewTrajectory
from server.library.workers import Worker
from server.work.fair_lock import FairLock

MOST_OF_OWNER = 1  #: unfinished jobs of one visitor
MOST = 20  #: of all visitors
PIECE = 1 << 20  #: bytes of the merged log that are stored at once

_log = structlog.get_logger(__name__)


class Uploads(Logs, Protocol):
    """What the jobs need of the library."""

    async def put(self, owner: str, name: str, chunks: AsyncIterator[bytes]) -> Record:
        """Store a log."""


@dataclass(slots=True, eq=False)
class _Running:
    """A job while it is queued or runs; ``done`` are called when it has ended."""

    task: asyncio.Task[None]
    done: list[Callable[[], None]]
    began: float
    stage: str | None = None


class MergeJobs:
    """All jobs; ``folder`` is one for their files that worker processes see."""

    def __init__(
        self, database: Database, leases: Leases, logs: Uploads, worker: Callable[[], Worker], folder: Path
    ) -> None:
        self._leases = leases
        self._database, self._logs, self._make_worker, self._folder = database, logs, worker, folder
        self._worker: Worker | None = None
        self._limits = JobLimits()
        self._records: dict[tuple[str, str], MergeRecord] = {}  #: by owner and first log
        self._running: dict[tuple[str, str], _Running] = {}
        self._turns = FairLock()
        self._closing = False

    async def start(self) -> None:
        """Load the records, and begin again what an earlier run of the service did not finish.

        Raises :class:`StorageError`.
        """
        await asyncio.to_thread(emptied, self._folder)
        for record in await self._load():
            self._records[record.owner, record.log_id] = record
            if record.is_unfinished and self._leases.is_shared:
                self._queue(record, adopted=True)  # another service may be at it
            elif record.is_unfinished and record.attempts < MOST_ATTEMPTS:
                self._queue(replace(record, state="queued"))
            elif record.is_unfinished:
                self._save(_interrupted(record))

    def _load(self) -> asyncio.Future[Sequence[MergeRecord]]:
        return self._database.run(lambda connection: load_job_records(connection, merge_jobs, MergeRecord))

    async def follow(self, _: object = None) -> None:
        """Take over what other services have changed. Raises :class:`StorageError`."""
        found = {(one.owner, one.log_id): one for one in await self._load()}
        for key in [key for key in self._records if key not in found]:
            await self._stop(key)
        self._records = found
        for key, record in found.items():
            if record.is_unfinished and key not in self._running:
                self._queue(record, adopted=True)
            elif not record.is_unfinished:
                await self._stop(key)

    async def _stop(self, key: tuple[str, str]) -> None:
        running = self._running.get(key)
        if running is not None:
            running.task.cancel()
            await asyncio.wait([running.task])

    async def begin(
        self,
        owner: str,
        first: tuple[str, str | None],
        second: tuple[str, str | None],
        done: Callable[[], None] = lambda: None,
        *,
        cuts: tuple[dict[str, float] | None, dict[str, float] | None] = (None, None),
    ) -> dict[str, Any]:
        """Queue a merge of two logs, each with the topic of its sensor, and return its state.

        ``cuts`` say how the scans of each are cut out of clouds and depth images, None as by default. ``done`` is
        called when it has ended. Raises :class:`LimitError` for one job too many, :class:`ConfigError` for a log with
        itself and for a cut that is none, :class:`StorageError`, and as the library for logs that the owner may not
        open.
        """
        for cut in cuts:
            PlanarCut.of(cut or {})
        log = self._logs.get(owner, first[0])
        self._logs.get(owner, second[0])
        if first[0] == second[0]:
            raise ConfigError("merge.same", "These are one log: choose another one to merge it with.")
        if sum(one == owner for one, _ in self._running) >= MOST_OF_OWNER:
            raise LimitError("merge.too_many", "You have a merge under way: wait, or cancel it.")
        if len(self._running) >= MOST:
            raise LimitError("merge.busy", "Too many merges are under way; try again later.")
        record = MergeRecord(
            log_id=first[0], owner=owner, topic=first[1], other=second[0], other_topic=second[1], state="queued",
            created_s=time.time(), cut=cuts[0], other_cut=cuts[1],
        )  # fmt: skip
        self._queue(record).done.append(done)
        try:
            await self._database.run(lambda connection: put_job_record(connection, merge_jobs, log, record))
        except StorageError:
            await self.cancel(owner, first[0])
            raise
        return self.state(owner, first[0])

    def state(self, owner: str, log_id: str) -> dict[str, Any]:
        """Return what the HTTP interface shows of the newest merge of a log; state "none": there was none."""
        self._logs.get(owner, log_id)
        record = self._records.get((owner, log_id)) or MergeRecord(log_id=log_id, owner=owner)
        running = self._running.get((owner, log_id))
        worker = self._worker if record.state == "running" else None
        return record.public() | {
            "fraction": 0.0 if worker is None else round(worker.progress, 4),
            "stage": None if running is None else running.stage,
            "elapsed_s": None if running is None else round(time.monotonic() - running.began, 1),
        }

    async def cancel(self, owner: str, log_id: str) -> dict[str, Any]:
        """Stop a merge, if it is queued or running; return its state."""
        await self._stop((owner, log_id))
        return self.state(owner, log_id)

    async def forget_log(self, log_id: str) -> None:
        """Stop the jobs of a log that was deleted, as first or as second log, and forget those that it was first of."""
        for key, record in [*self._records.items()]:
            if key[1] == log_id:
                del self._records[key]
            if log_id in (record.log_id, record.other):
                await self._stop(key)

    def _queue(self, record: MergeRecord, *, adopted: bool = False) -> _Running:
        key = (record.owner, record.log_id)
        self._records[key] = record
        task = asyncio.create_task(self._run(record, adopted=adopted), name="merge")
        self._running[key] = running = _Running(task, [], time.monotonic())
        return running

    async def _run(self, record: MergeRecord, *, adopted: bool) -> None:
        key = (record.owner, record.log_id)

        def is_open() -> bool:
            known = self._records.get(key)
            return known is not None and known.is_unfinished

        async def is_due() -> bool:
            self._records |= {(one.owner, one.log_id): one for one in await self._load() if one.log_id == key[1]}
            return is_open()

        once = Once(f"merge {key[1]} {key[0]}", lambda: self._turns.of(record.owner), is_open, is_due)
        try:
            await self._leases.done_once(once, lambda lease: self._run_here(self._records[key], lease), adopted=adopted)
        except asyncio.CancelledError:
            if not self._closing and is_open():  # else it is begun again at the next start
                self._save(replace(self._records[key], state="cancelled", attempts=0))
            raise
        except StorageError:  # the database of several services is away
            _log.warning("merge not done now", log=key[1])
        finally:
            for tell in self._running.pop(key).done:
                tell()

    async def _run_here(self, record: MergeRecord, lease: Lease) -> None:
        key = (record.owner, record.log_id)
        if self._leases.is_shared and record.attempts >= MOST_ATTEMPTS:
            await self._finish(_interrupted(record), lease)
            return
        record = replace(record, state="running", attempts=record.attempts + 1)
        self._save(record)
        try:
            result = await self._merged(record, self._running[key])
            done = replace(record, state="done", result=result, attempts=0)
        except MapperError as error:
            done = replace(record, state="failed", error=Failure(error.code, error.message), attempts=0)
        except Exception:  # noqa: BLE001 - whatever it is, it is logged whole and fails this job alone
            failure = Failure("merge.failed", "Merging these logs failed.")
            done = replace(record, state="failed", error=failure, attempts=0)
            _log.exception("merge failed")
        if key in self._records:  # not deleted meanwhile
            await self._finish(done, lease)

    async def _finish(self, record: MergeRecord, lease: Lease) -> None:
        """Store what came of a job, and end its lease; as :meth:`_save`. Raises :class:`LeaseLostError`."""
        if not self._leases.is_shared:
            self._save(record)
            return
        log = self._logs.get(record.owner, record.log_id)
        with contextlib.suppress(StorageError):
            await lease.finish(lambda connection: put_job_record(connection, merge_jobs, log, record))
        self._records[record.owner, record.log_id] = record

    async def _merged(self, record: MergeRecord, running: _Running) -> dict[str, Any]:
        """Run the job, add a trajectory to each log and a log of both, and return what is shown of the result."""
        owner, ids = record.owner, (record.log_id, record.other)
        logs: list[ScanLog] = []
        topics, cuts = (record.topic, record.other_topic), (record.cut, record.other_cut)
        for log_id, topic, cut in zip(ids, topics, cuts, strict=True):
            logs.append(await self._logs.load(owner, log_id, topic, PlanarCut.of(cut or {})))
        folder = self._folder / secrets.token_hex(10)
        await asyncio.to_thread(private_folder, folder)
        try:
            packs = [folder / "first.npz", folder / "second.npz"]
            for log, pack in zip(logs, packs, strict=True):
                await asyncio.to_thread(packed, log, pack)
            out, limits = folder / "merged", self._limits
            job = MergeJob(str(packs[0]), str(packs[1]), str(out), limits.timeout_s, limits.cpu_s, limits.memory_bytes)
            worker = self._worker = self._worker or self._make_worker()

            async def look() -> None:
                running.stage = await asyncio.to_thread(_text_of, out.with_name(out.name + STAGE))

            outcome = await followed(worker, job, look, "merge.died")
            texts = [await asyncio.to_thread(out.with_name(out.name + ending).read_bytes) for ending in ENDINGS]
            names = [self._logs.get(owner, log_id).name for log_id in ids]
            for log_id, log, text, other in zip(ids, logs, texts, reversed(names), strict=True):
                said = f"poses in one frame with those of {other}, with {outcome.loops} loops between the two logs"
                new = NewTrajectory(NAME, text, "slam", said)
                await self._logs.trajectories.put(owner, self._logs.get(owner, log_id), log, new)
            both = await self._logs.put(owner, _name_of_both(names), _pieces(out.with_name(out.name + LOG)))
            text, graph = [await asyncio.to_thread(out.with_name(out.name + one).read_bytes) for one in (BOTH, GRAPH)]
            said = f"SLAM of {names[0]} and {names[1]}, with {outcome.loops} loops between the two logs"
            log = await self._logs.load(owner, both.id, outcome.topic)
            await self._logs.trajectories.put(owner, both, log, NewTrajectory(SLAM, text, "slam", said, graph))
        finally:
            await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)
        return {"trajectory": NAME, "log": both.id, "name": both.name, **asdict(outcome)}

    def _save(self, record: MergeRecord) -> None:
        """Store a changed record; if it cannot be written, it is valid until the next start."""
        self._records[record.owner, record.log_id] = record
        with contextlib.suppress(MapperError):  # the log is gone
            log = self._logs.get(record.owner, record.log_id)
            written = self._database.run(lambda connection: put_job_record(connection, merge_jobs, log, record))
            written.add_done_callback(lambda one: None if one.cancelled() else one.exception() and None)

    async def close(self) -> None:
        """End the running job, which the next start begins again, and the process."""
        self._closing = True
        for running in [*self._running.values()]:
            running.task.cancel()
        await asyncio.gather(*(one.task for one in self._running.values()), return_exceptions=True)
        if self._worker is not None:
            await asyncio.to_thread(self._worker.close)


def _interrupted(record: MergeRecord) -> MergeRecord:
    message = f"The service ended {record.attempts} times during this job; it is not begun again by itself."
    return replace(record, state="failed", error=Failure("merge.interrupted", message))


def _name_of_both(names: list[str]) -> str:
    """Return the name of the log of both, with at most 60 characters of each."""
    first, second = (name.split(".", 1)[0][:60] or "log" for name in names)
    return f"{first} and {second}, merged.mcap"


async def _pieces(path: Path) -> AsyncIterator[bytes]:
    with await asyncio.to_thread(path.open, "rb") as file:
        while piece := await asyncio.to_thread(file.read, PIECE):
            yield piece


def _text_of(path: Path) -> str | None:
    try:
        return path.read_text(encoding="ascii")
    except OSError:
        return None
