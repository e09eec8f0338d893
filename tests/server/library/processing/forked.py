"""What the processes do that test_fork_server.py has forked."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.forkserver import _forkserver
from pathlib import Path
from typing import Any

from server.jobs.process import BoundedJob, JobLimits
from server.jobs.workers import PoolWorker


def loaded(module: str) -> bool:
    """Return whether this process has a module that it has not imported itself."""
    return module in sys.modules


def wait_for(path: Path) -> str:
    """Wait until a file is there."""
    while not path.exists():
        time.sleep(0.01)
    return "done"


LIMITS = JobLimits(60.0, 60.0, 2 << 30)


@dataclass(frozen=True, slots=True)
class Task(BoundedJob[object]):
    """Call a function of this module."""

    function: Callable[[Any], object]
    argument: object
    limits: JobLimits = LIMITS

    def compute(self) -> object:
        """Call it."""
        return self.function(self.argument)


def main() -> None:
    """Begin a job that waits for a file; print the processes, then what the job returns; end with standard input."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # as in a service: what began the tests may have it ignored
    worker = PoolWorker(2 << 30)
    assert worker.submit(Task(loaded, "mapper.io.logs")).result()
    job = worker.submit(Task(wait_for, Path(sys.argv[1])))
    print(_forkserver._forkserver_pid, worker.pid, os.getpid(), flush=True)  # type: ignore[attr-defined]
    print(job.result(), flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main()
