"""What happens to a service that runs for long: its database locked, its disk filled, its clock set.

The clock is that of the service's process alone (:data:`tests.hostile.test_clock.PROGRAM`).
"""

from __future__ import annotations

import contextlib
import os
import signal
import sqlite3
import threading
import time
from collections.abc import Callable
from pathlib import Path

from server.storage import RECORDS_FILE

LOCKED_S = 2.0  #: less than the service waits for a lock
FULL_S = 4.0
BLOCK = bytes(1 << 12)


class Disk:
    """Whether the disk was full at some time since a moment."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock = threading.Lock()
        self._fills, self._is_full = 0, False

    def moment(self) -> int:
        """Return the moment, to be asked for again."""
        with self._lock:
            return self._fills - self._is_full

    def was_full(self, since: int) -> bool:
        """Whether it was full at some time since the moment ``since``."""
        with self._lock:
            return self._fills > since

    def fill(self, _pid: int) -> None:
        """Fill it, and make room again after a while."""
        path = self._folder / "filling"
        with self._lock:
            self._fills, self._is_full = self._fills + 1, True
        try:
            with contextlib.suppress(OSError), path.open("wb", buffering=0) as file:
                while True:
                    file.write(BLOCK)
            time.sleep(FULL_S)
        finally:
            path.unlink()
            with self._lock:
                self._is_full = False


def lock(folder: Path) -> Callable[[int], None]:
    """Return what locks the database of records for a while, as another program may."""

    def locked(_pid: int) -> None:
        path = folder / "library" / RECORDS_FILE
        with contextlib.closing(sqlite3.connect(path, timeout=60.0, isolation_level=None)) as records:
            records.execute("BEGIN EXCLUSIVE")
            time.sleep(LOCKED_S)
            records.execute("ROLLBACK")

    return locked


def set_ahead(pid: int) -> None:
    """Set the clock an hour ahead."""
    os.kill(pid, signal.SIGUSR1)


def set_back(pid: int) -> None:
    """Set the clock two hours back."""
    os.kill(pid, signal.SIGUSR2)
