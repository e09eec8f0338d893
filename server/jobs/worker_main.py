"""``python -m server.jobs.worker_main``: one job in its own process, for any kind of executor.

Job and lease are read pickled from standard input; the summary or the error is written pickled to standard output.
"""

from __future__ import annotations

import os
import pickle
import sys
import threading
import time
from pathlib import Path

from mapper.core.errors import MapperError
from server.jobs import process
from server.jobs.workers import DIED

LOOK_S = 0.2  #: interval of checking the lease, and shortest interval of writing it


def main() -> None:
    """Do the job."""
    job, lease = pickle.loads(sys.stdin.buffer.read())  # noqa: S301 - by the process that started this one
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # other output must not interfere
    path = Path(lease)
    threading.Thread(target=_end_with_lease, args=(path,), daemon=True).start()
    written = 0.0

    def report(fraction: float) -> None:
        nonlocal written
        if fraction == 1.0 or time.monotonic() - written > LOOK_S:
            written = time.monotonic()
            try:
                with path.open("r+b") as file:  # which must not create it again
                    file.write(b"%.4f" % fraction)
            except FileNotFoundError:
                os._exit(DIED)

    process.begin(job.limits.memory_bytes, report)
    result: object
    try:
        result = job.do()
    except MapperError as error:
        result = error
    except Exception as error:  # noqa: BLE001 - a reader's defect crosses to the server, which logs it
        result = RuntimeError(f"{type(error).__name__}: {error}")
    with out:
        pickle.dump(result, out)


def _end_with_lease(path: Path) -> None:
    """End this process if its lease is removed or its parent process ends, because nobody would receive the result."""
    began = os.getppid()
    while path.exists() and os.getppid() == began:
        time.sleep(LOOK_S)
    os._exit(DIED)


if __name__ == "__main__":
    main()
