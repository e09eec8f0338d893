"""Room on the disk that is kept for deletions: on a full one SQLite cannot even write that a row is gone."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

RESERVE_BYTES = 1 << 18  #: a deletion writes a few pages of 4 KiB, and 32 KiB of the index of the write-ahead log


class Reserve:
    """A file beside the database, which takes the room until it is given up. Any thread, one call at a time."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def keep(self) -> None:
        """Take the room if it is not taken; where there is none now, nothing happens."""
        if self._path.exists():
            return
        with contextlib.suppress(OSError):
            handle = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            try:
                os.posix_fallocate(handle, 0, RESERVE_BYTES)
            except OSError:
                self._path.unlink()
            finally:
                os.close(handle)

    def give_up(self) -> None:
        """Give the room back to the disk."""
        self._path.unlink(missing_ok=True)
