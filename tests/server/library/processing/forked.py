"""What the processes do that test_fork_server.py has forked."""

from __future__ import annotations

import os
import signal
import sys
import time
from multiprocessing.forkserver import _forkserver
from pathlib import Path

from server.jobs.workers import PoolWorker


def loaded(module: str) -> bool:
    """Return whether this process has a module that it has not imported itself."""
    return module in sys.modules


def wait_for(path: Path) -> str:
    """Wait until a file is there."""
    while not path.exists():
        time.sleep(0.01)
    return "done"


def main() -> None:
    """Begin a job that waits for a file; print the processes, then what the job returns; end with standard input."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # as in a service: what began the tests may have it ignored
    worker = PoolWorker(2 << 30)
    assert worker.run(loaded, "mapper.io.logs").result()
    job = worker.run(wait_for, Path(sys.argv[1]))
    print(_forkserver._forkserver_pid, worker.pid, os.getpid(), flush=True)  # type: ignore[attr-defined]
    print(job.result(), flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main()
