"""Examination of logs on a few threads of lower priority than those of sessions."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, TypeVar

from mapper import diagnosis
from mapper.sensors.scan import ScanLog
from server.work.priority import lower_priority
from server.work.scheduler import Scheduler
from server.work.waiting_turns import JobOwner

if TYPE_CHECKING:
    from mapper.diagnosis import Diagnosis

T = TypeVar("T")

AT_ONCE = 2  #: logs that the whole service examines at the same time

_TURNS = Scheduler(AT_ONCE)
_EXAMINERS = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="doctor", initializer=lower_priority)


async def in_turn(scheduler: Scheduler, job_owner: JobOwner, job: Callable[[], T]) -> T:
    """Return what ``job`` returns, on a thread that it gets in the order of the scheduler. Raises as ``job``."""
    turn = _TURNS.request(job_owner, interactive=False)
    try:
        await asyncio.wrap_future(turn.granted)
        return await scheduler.run(_EXAMINERS, job_owner, job, interactive=False)
    finally:
        _TURNS.release(turn)


async def examination(
    log: ScanLog,
    trajectory: str,
    scheduler: Scheduler,
    job_owner: JobOwner,
    wanted: Callable[[], bool],
    progress: Callable[[float], None],
) -> Diagnosis:
    """Return the diagnosis of a log. Raises as :func:`mapper.diagnosis.diagnose`, which checks ``wanted``.

    ``progress`` is called with the share that is done, on a worker thread.
    """

    def examined() -> Diagnosis:
        return diagnosis.diagnose(log, trajectory, progress, wanted=wanted)

    return await in_turn(scheduler, job_owner, examined)
