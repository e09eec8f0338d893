"""Waiting for a long job in the process of a worker."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from concurrent.futures import BrokenExecutor
from typing import TypeVar

from mapper.core.errors import ReadError
from server.library.job import WorkerJob
from server.library.workers import GRACE_S, Worker

T = TypeVar("T")
LOOK_S = 0.2  #: how often a running job is looked at


async def followed(
    worker: Worker, job: WorkerJob[T], about: str, look: Callable[[], Awaitable[None]] | None = None
) -> T:
    """Have a worker do a job; return its result. ``look`` is awaited several times a second until then.

    The process is ended where the job takes longer than it may, and where the caller is cancelled. Raises what the job
    raises, and :class:`ReadError` with the code ``about``.died where its process was ended from elsewhere.
    """
    try:
        done = asyncio.ensure_future(asyncio.wrap_future(worker.submit(job)))
        deadline = time.monotonic() + job.timeout_s + 1.5 * GRACE_S
        while not done.done():
            await asyncio.wait([done], timeout=LOOK_S)
            if look is not None:
                await look()
            if time.monotonic() > deadline:
                worker.end()
                raise job.time_error()
        return done.result()
    except BrokenExecutor:
        worker.end()
        message = "The process of this job was ended, most likely because the job needs too much memory."
        raise ReadError(f"{about}.died", message) from None
    except asyncio.CancelledError:
        worker.end()
        raise
