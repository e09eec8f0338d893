"""Jobs that bring two logs of one place into one frame: one at a time, visitors in rotation.

What a job has made is a trajectory of each of the two logs. A job ends with the service; it is not begun again.
"""

from __future__ import annotations

import asyncio
import secrets
import shutil
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import structlog

from mapper.core.errors import ConfigError, LimitError, MapperError, ReadError
from mapper.sensors.scan import ScanLog
from server.library.merge_job import ENDINGS, NAME, MergeJob, MergeOutcome
from server.library.pose_jobs import JobLimits, Logs, packed
from server.library.storage import private_folder
from server.library.trajectories import NewTrajectory
from server.library.workers import GRACE_S, Worker
from server.work.fair_lock import FairLock

MOST_OF_OWNER = 1  #: unfinished jobs of one visitor
MOST = 20  #: of all visitors
LOOK_S = 0.2  #: how often the service looks whether a job takes too long

_log = structlog.get_logger(__name__)


@dataclass(slots=True)
class _Merge:
    """The newest job of a visitor on a log."""

    other: str
    began: float = field(default_factory=time.monotonic)
    state: str = "queued"
    error: dict[str, str] | None = None
    result: dict[str, Any] | None = None
    task: asyncio.Task[None] | None = None


class MergeJobs:
    """All jobs; ``folder`` is one for their files that worker processes see. Used from the event loop only."""

    def __init__(self, logs: Logs, worker: Callable[[], Worker], folder: Path) -> None:
        self._logs, self._make_worker, self._folder = logs, worker, folder
        self._worker: Worker | None = None
        self._limits = JobLimits()
        self._merges: dict[tuple[str, str], _Merge] = {}  #: by owner and first log
        self._turns = FairLock()

    def begin(
        self,
        owner: str,
        first: tuple[str, str | None],
        second: tuple[str, str | None],
        done: Callable[[], None] = lambda: None,
    ) -> dict[str, Any]:
        """Queue a merge of two logs, each with the topic of its sensor, and return its state.

        ``done`` is called when it has ended. Raises :class:`LimitError` for one job too many, :class:`ConfigError` for
        a log with itself, and as the library for logs that the owner may not open.
        """
        for log_id, _ in (first, second):
            self._logs.get(owner, log_id)
        if first[0] == second[0]:
            raise ConfigError("merge.same", "These are one log: choose another one to merge it with.")
        running = [key for key, one in self._merges.items() if one.task is not None]
        if sum(key[0] == owner for key in running) >= MOST_OF_OWNER:
            raise LimitError("merge.too_many", "You have a merge under way: wait, or cancel it.")
        if len(running) >= MOST:
            raise LimitError("merge.busy", "Too many merges are under way; try again later.")
        merge = self._merges[owner, first[0]] = _Merge(second[0])
        merge.task = asyncio.create_task(self._run(owner, first, second, merge, done))
        return self.state(owner, first[0])

    def state(self, owner: str, log_id: str) -> dict[str, Any]:
        """Return what the HTTP interface shows of the newest merge of a log; state "none": there was none."""
        self._logs.get(owner, log_id)
        merge = self._merges.get((owner, log_id))
        if merge is None:
            return {"state": "none", "other": None, "fraction": 0.0, "elapsed_s": None, "error": None, "result": None}
        is_running = merge.state == "running" and self._worker is not None
        return {
            "state": merge.state,
            "other": merge.other,
            "fraction": round(self._worker.progress, 4) if is_running and self._worker is not None else 0.0,
            "elapsed_s": None if merge.task is None else round(time.monotonic() - merge.began, 1),
            "error": merge.error,
            "result": merge.result,
        }

    async def cancel(self, owner: str, log_id: str) -> dict[str, Any]:
        """Stop a merge, if it is queued or running; return its state."""
        merge = self._merges.get((owner, log_id))
        if merge is not None and merge.task is not None:
            merge.task.cancel()
            await asyncio.wait([merge.task])
        return self.state(owner, log_id)

    async def _run(
        self,
        owner: str,
        first: tuple[str, str | None],
        second: tuple[str, str | None],
        merge: _Merge,
        done: Callable[[], None],
    ) -> None:
        try:
            async with self._turns.of(owner):
                merge.state = "running"
                merge.result = await self._merged(owner, first, second)
            merge.state = "done"
        except MapperError as error:
            merge.state, merge.error = "failed", {"code": error.code, "message": error.message}
        except asyncio.CancelledError:
            merge.state = "cancelled"
            raise
        except Exception:  # noqa: BLE001 - whatever it is, it is logged whole and fails this job alone
            merge.state, merge.error = "failed", {"code": "merge.failed", "message": "Merging these logs failed."}
            _log.exception("merge failed")
        finally:
            merge.task = None
            done()

    async def _merged(
        self, owner: str, first: tuple[str, str | None], second: tuple[str, str | None]
    ) -> dict[str, Any]:
        """Run the job, add a trajectory to each log, and return what is shown of the result."""
        logs: list[ScanLog] = []
        for log_id, topic in (first, second):
            logs.append(await self._logs.load(owner, log_id, topic))
        folder = self._folder / secrets.token_hex(10)
        await asyncio.to_thread(private_folder, folder)
        try:
            packs = [folder / "first.npz", folder / "second.npz"]
            for log, pack in zip(logs, packs, strict=True):
                await asyncio.to_thread(packed, log, pack)
            out, limits = folder / "merged", self._limits
            job = MergeJob(str(packs[0]), str(packs[1]), str(out), limits.timeout_s, limits.cpu_s, limits.memory_bytes)
            outcome = await self._followed(job)
            texts = [await asyncio.to_thread(out.with_name(out.name + ending).read_bytes) for ending in ENDINGS]
        finally:
            await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)
        ids = first[0], second[0]
        for at, (log_id, log, text) in enumerate(zip(ids, logs, texts, strict=True)):
            name = self._logs.get(owner, ids[1 - at]).name
            said = f"poses in one frame with those of {name}, with {outcome.loops} loops between the two logs"
            new = NewTrajectory(NAME, text, "slam", said)
            await self._logs.trajectories.put(owner, self._logs.get(owner, log_id), log, new)
        return {"trajectory": NAME, **asdict(outcome)}

    async def _followed(self, job: MergeJob) -> MergeOutcome:
        """Wait for the job in its process."""
        worker = self._worker = self._worker or self._make_worker()
        try:
            done = asyncio.ensure_future(asyncio.wrap_future(worker.submit(job)))
            deadline = time.monotonic() + job.timeout_s + 1.5 * GRACE_S
            while not done.done():
                await asyncio.wait([done], timeout=LOOK_S)
                if time.monotonic() > deadline:
                    worker.end()
                    raise job.time_error()
            return done.result()
        except BrokenExecutor:
            worker.end()
            message = "The process of this job was ended, most likely because the logs need too much memory."
            raise ReadError("merge.died", message) from None
        except asyncio.CancelledError:
            worker.end()
            raise

    async def close(self) -> None:
        """End what runs, and the process."""
        tasks = [one.task for one in self._merges.values() if one.task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        if self._worker is not None:
            await asyncio.to_thread(self._worker.close)
