"""Where logs are examined: on a few threads that step back behind those for which somebody waits."""

from __future__ import annotations

import asyncio
import os
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from mapper.scan import ScanLog

if TYPE_CHECKING:
    from mapper.doctor import Finding

AT_ONCE = 2  #: logs, in the whole service
_NICENESS = 10  # more than the service has


def _step_back() -> None:
    # Linux gives each thread a niceness of its own. Elsewhere the number would mean another process, or this whole one.
    if sys.platform == "linux":
        thread = threading.get_native_id()
        os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, thread) + _NICENESS)


_EXAMINERS = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="doctor", initializer=_step_back)


def begin_examination(log: ScanLog, trajectory: str, wanted: Callable[[], bool]) -> asyncio.Future[list[Finding]]:
    """Have the doctor examine a log; raises in the future as :func:`mapper.doctor.examine`, which asks ``wanted``."""

    def examined() -> list[Finding]:
        from mapper.doctor import examine  # noqa: PLC0415 - SciPy, which most visitors do without

        return examine(log, trajectory, wanted=wanted)

    return asyncio.get_running_loop().run_in_executor(_EXAMINERS, examined)
