"""Room on the disk that is kept for deletions: on a full one SQLite cannot even write that a row is gone."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

RESERVE_BYTES = 1 << 18  #: a deletion writes a few pages of 4 KiB, and 32 KiB of the index of the write-ahead log
LEAST_BYTES = 1 << 15  #: less is of no use


class Reserve:
    """A file beside the database, which takes the room until it is given up. Any thread, one call at a time."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def keep(self) -> None:
        """Take the room that is not taken, or as much of it as there is now."""
        with contextlib.suppress(OSError):
            handle = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o600)
            try:
                taken, size = os.fstat(handle).st_size, RESERVE_BYTES
                while size >= max(LEAST_BYTES, taken + 1):
                    with contextlib.suppress(OSError):
                        os.posix_fallocate(handle, 0, size)
                        break
                    os.ftruncate(handle, taken)  # what was taken before it failed
                    size //= 2
            finally:
                os.close(handle)

    def give_up(self) -> None:
        """Give the room back to the disk."""
        self._path.unlink(missing_ok=True)
