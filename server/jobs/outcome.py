"""The outcome of a job that a worker does, and its progress."""

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

LOOK_S = 0.2  #: interval of checking a running job

T = TypeVar("T")


async def outcome_of(
    worker: Worker, job: BoundedJob[T], code: str = "log.reader_died", look: Callable[[], Awaitable[None]] | None = None
) -> T:
    """Have ``worker`` do ``job``, and return its result; ``look`` is called every :data:`LOOK_S` seconds meanwhile.

    Raises the job's exceptions, its timeout error, and :class:`ReadError` with the ``code`` if its process was killed.
    After a timeout, or when this is cancelled, the process is ended.
    """
    try:
        await worker.prepare()
        done = asyncio.wrap_future(worker.submit(job))
        done.add_done_callback(_read_error)
        # Its process has as much time to notice its timeout; afterwards the worker is no longer polled.
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
    """Retrieve the error of a cancelled job without a caller; asyncio would report it as not retrieved."""
    if not done.cancelled():
        done.exception()
