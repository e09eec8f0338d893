"""The folders of the library, and the errors of its stores."""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mapper.core.errors import MapperError

RECORDS_FILE = "library.db"  #: the records of a service without another database, below ``library``


class StorageError(MapperError):
    """A store failed to write or read. No incomplete file is left."""


def disk_full() -> StorageError:
    """Return the error for data that cannot be written."""
    return StorageError("log.storage", "The server could not store the log; its disk may be full.")


def private_folder(folder: Path) -> None:
    """Create a folder that no other account of the machine can read, if it is missing. Raises :class:`OSError`."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    with contextlib.suppress(OSError):  # another account's folder, which it has shared with this one
        folder.chmod(0o700)


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """Hold ``folder`` exclusively for this process, because two services would remove each other's uploads.

    Raises :class:`StorageError` if another process holds it, and :class:`OSError`.
    """
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise StorageError("library.claimed", "another Gridbloom is using it") from None
        yield
    finally:
        os.close(handle)
