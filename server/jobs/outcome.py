"""The outcome of a job that a worker does, and its progress meanwhile."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from concurrent.futures import BrokenExecutor
from typing import TypeVar

from mapper.core.errors import ReadError
from server.jobs import workers
from server.jobs.process import BoundedJob
from server.jobs.workers import Worker

LOOK_S = 0.2  #: how often a running job is looked at

T = TypeVar("T")


async def outcome_of(
    worker: Worker, job: BoundedJob[T], code: str = "log.reader_died", look: Callable[[], Awaitable[None]] | None = None
) -> T:
    """Have ``worker`` do ``job``, and return its result; ``look`` is called every :data:`LOOK_S` seconds while it does.

    Raises what the job raises, its error of time, and :class:`ReadError` with the ``code`` where its process was ended.
    After an error of time, or when this is cancelled, the process is ended.
    """
    try:
        await worker.prepare()
        done = asyncio.wrap_future(worker.submit(job))
        done.add_done_callback(_read_error)
        # Its process has as long to notice that its time is over; then the worker is not asked any more.
        deadline = time.monotonic() + job.limits.timeout_s + 1.5 * workers.GRACE_S
        while not done.done():
            left = deadline - time.monotonic()
            if left <= 0.0:
                worker.end()
                raise job.time_error()
            await asyncio.wait([done], timeout=left if look is None else min(left, LOOK_S))
            if look is not None:
                await look()
        return done.result()
    except BrokenExecutor:
        worker.end()
        message = "The process of this job was ended, most likely because the log needs too much memory or time."
        raise ReadError(code, message) from None
    except asyncio.CancelledError:
        worker.end()
        raise


def _read_error(done: asyncio.Future[T]) -> None:
    """Read the error of a cancelled job, for which no caller waits; asyncio would report it as not retrieved."""
    if not done.cancelled():
        done.exception()
