"""Waiting for a long job in its process, while its progress is requested."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from concurrent.futures import BrokenExecutor
from typing import TypeVar

from mapper.core.errors import ReadError
from server.jobs.process import WorkerJob
from server.jobs.workers import GRACE_S, Worker

LOOK_S = 0.2  #: how often a running job is looked at

T = TypeVar("T")


async def followed(worker: Worker, job: WorkerJob[T], look: Callable[[], Awaitable[None]], code: str) -> T:
    """Have ``worker`` do ``job``, and call ``look`` every :data:`LOOK_S` seconds while it does.

    Raises what the job raises, its error of time, and :class:`ReadError` with the ``code`` where its process was ended.
    After an error or when it is cancelled the process is ended.
    """
    try:
        done = asyncio.wrap_future(worker.submit(job))
        done.add_done_callback(_read_error)
        deadline = time.monotonic() + job.timeout_s + 1.5 * GRACE_S
        while not done.done():
            await asyncio.wait([done], timeout=LOOK_S)
            await look()
            if time.monotonic() > deadline:
                worker.end()
                raise job.time_error()
        return done.result()
    except BrokenExecutor:
        worker.end()
        message = "The process of this job was ended, most likely because the log needs too much memory."
        raise ReadError(code, message) from None
    except asyncio.CancelledError:
        worker.end()
        raise


def _read_error(done: asyncio.Future[T]) -> None:
    """Read the error of a cancelled job, for which no caller waits; asyncio would report it as not retrieved."""
    if not done.cancelled():
        done.exception()
