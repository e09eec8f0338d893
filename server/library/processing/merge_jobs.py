"""Jobs that bring two logs of one place into one frame: one at a time, owners in rotation, each kept until it is done.

What a job has made is a trajectory of each of the two logs, and one more log with the scans of both. All methods run on
the event loop.
"""

from __future__ import annotations

import asyncio
import secrets
import shutil
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol

from mapper.core.errors import ConfigError, LimitError
from mapper.sensors.planar.options import PlanarCut
from mapper.sensors.scan import ScanLog
from server.jobs.following import followed
from server.jobs.leases import Leases
from server.jobs.workers import Worker
from server.library.annotations.trajectories import NewTrajectory
from server.library.logs.records import Record
from server.library.processing.job_queue import JobQueue, QueueKind, Running
from server.library.processing.merge_job import BOTH, ENDINGS, GRAPH, LOG, NAME, STAGE, MergeJob
from server.library.processing.merge_record import MergeRecord
from server.library.processing.pose_job_kind import JobLimits, Logs
from server.library.processing.pose_jobs import emptied, packed
from server.library.processing.slam_job import NAME as SLAM
from server.library.store.database import Database
from server.library.store.tables import merge_jobs
from server.storage import private_folder

MOST_OF_OWNER = 1  #: unfinished jobs of one visitor
MOST = 20  #: of all visitors
PIECE = 1 << 20  #: bytes of the merged log that are stored at once


class Uploads(Logs, Protocol):
    """Interface of the library that the jobs use."""

    async def put(self, owner: str, name: str, chunks: AsyncIterator[bytes]) -> Record:
        """Store a log."""


class MergeJobs:
    """All jobs; ``folder`` is one for their files that worker processes see."""

    def __init__(
        self, database: Database, leases: Leases, logs: Uploads, worker: Callable[[], Worker], folder: Path
    ) -> None:
        self._logs, self._make_worker, self._folder = logs, worker, folder
        self._worker: Worker | None = None
        self._limits = JobLimits()
        kind = QueueKind("merge", "Merging", merge_jobs, MergeRecord)
        self._queue: JobQueue[MergeRecord, str] = JobQueue(database, leases, logs.get, kind, self._merged)
        self.follow = self._queue.follow

    async def start(self) -> None:
        """Load the records, and begin again what an earlier run of the service did not finish.

        Raises :class:`StorageError`.
        """
        await asyncio.to_thread(emptied, self._folder)
        await self._queue.start()

    async def close(self) -> None:
        """End the running job, which the next start begins again, and the process."""
        await self._queue.close()
        if self._worker is not None:
            await asyncio.to_thread(self._worker.close)

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
        itself and for an invalid cut, :class:`StorageError`, and as the library for logs that the owner may not
        open.
        """
        for cut in cuts:
            PlanarCut.of(cut or {})
        self._logs.get(owner, first[0])
        self._logs.get(owner, second[0])
        if first[0] == second[0]:
            raise ConfigError("merge.same", "These are one log: choose another one to merge it with.")
        if sum(one == owner for one, _ in self._queue.running) >= MOST_OF_OWNER:
            raise LimitError("merge.too_many", "You have a merge under way: wait, or cancel it.")
        if len(self._queue.running) >= MOST:
            raise LimitError("merge.busy", "Too many merges are under way; try again later.")
        record = MergeRecord(
            log_id=first[0], owner=owner, topic=first[1], other=second[0], other_topic=second[1], state="queued",
            created_s=time.time(), cut=cuts[0], other_cut=cuts[1],
        )  # fmt: skip
        await self._queue.begin([record])
        self._queue.listen((owner, first[0]), lambda stage: done() if stage is None else None)
        return self.state(owner, first[0])

    def state(self, owner: str, log_id: str) -> dict[str, Any]:
        """Return what the HTTP interface shows of the newest merge of a log; state "none": there was none."""
        self._logs.get(owner, log_id)
        key = (owner, log_id)
        record = self._queue.records.get(key) or MergeRecord(log_id=log_id, owner=owner)
        running = self._queue.running.get(key)
        return record.public() | self._queue.under_way(key) | {"stage": None if running is None else running.newest}

    async def cancel(self, owner: str, log_id: str) -> dict[str, Any]:
        """Stop a merge, if it is queued or running; return its state."""
        await self._queue.stop((owner, log_id))
        return self.state(owner, log_id)

    async def forget_log(self, log_id: str) -> None:
        """Stop the jobs of a log that was deleted, as first or as second log, and forget those that it was first of."""
        await self._queue.forget_log(log_id)
        for key, record in [*self._queue.records.items()]:
            if log_id == record.other:
                await self._queue.stop(key)

    async def _merged(self, record: MergeRecord, running: Running[str]) -> dict[str, Any]:
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
                stage = await asyncio.to_thread(_text_of, out.with_name(out.name + STAGE))
                if stage is not None:
                    running.tell(stage, worker.progress)

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
