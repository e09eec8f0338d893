"""A job that is followed: what is left of it after a cancellation."""

from __future__ import annotations

import asyncio
import gc
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from typing import Any, cast

import pytest

from server.jobs.outcome import outcome_of
from server.jobs.process import BoundedJob, JobLimits
from server.jobs.workers import Worker


class Process:
    """A worker whose process never ends a job: the job fails when the process is ended, as in a process pool."""

    def __init__(self) -> None:
        self.job: Future[Any] = Future()
        self.job.set_running_or_notify_cancel()

    async def prepare(self) -> None:
        """It is there."""

    def submit(self, _: object) -> Future[Any]:
        return self.job

    def end(self) -> None:
        self.job.set_exception(BrokenProcessPool("ended"))


class Job:
    limits = JobLimits()


async def test_the_end_of_a_cancelled_jobs_process_is_no_error_of_the_loop() -> None:
    reported: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: reported.append(context))
    process, looked = Process(), asyncio.Event()

    async def look() -> None:
        looked.set()

    following = asyncio.ensure_future(
        outcome_of(cast("Worker", process), cast("BoundedJob[None]", Job()), "read", look)
    )
    await looked.wait()
    following.cancel()
    with pytest.raises(asyncio.CancelledError):
        await following
    del following
    await asyncio.sleep(0)  # the loop hears of the job's end
    await asyncio.sleep(0)
    process.job = Future()
    gc.collect()
    assert reported == []
