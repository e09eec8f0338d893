"""Checks whether the folder and the database that the library opened still exist and are writable.

Open files outlast their names. Without this check, a service whose data folder was moved or unmounted would continue to
accept uploads into files that are lost at its end.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from server.storage import StorageError


class KnownPaths:
    """Identifies folders and files by their device and inode at construction."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self._known = {path: _identity(path) for path in paths}
        self._folders = {path for path in paths if path.is_dir()}

    def check(self) -> None:
        """Raise :class:`StorageError` unless all of them are the same as before, and writable."""
        for path, known in self._known.items():
            if _identity(path) != known:
                raise StorageError(
                    "library.gone",
                    f"The service’s {'folder' if path in self._folders else 'database'} was moved or removed: "
                    "nothing can be stored until it is back, or the service is started again.",
                )
            if not os.access(path, os.W_OK) or os.statvfs(path).f_flag & os.ST_RDONLY:
                raise StorageError("library.read_only", "The service’s folder is read-only now: nothing can be stored.")


def _identity(path: Path) -> tuple[int, int] | None:
    """Return device and inode of a folder or file; None if it is missing."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino
