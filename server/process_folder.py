"""The folder for this process's Unix sockets, removed with the process, or at the next start if it was killed."""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import os
import shutil
import tempfile
from functools import cache
from pathlib import Path

PREFIX = "gridbloom-process-"


@cache
def process_folder() -> Path:
    """Return the folder, below the system's temporary one, which no other account can open.

    The first call removes the folders of killed processes. Raises :class:`OSError`.
    """
    _remove_abandoned()
    while True:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX))
        # The lock ends with the process, for whatever reason. Its child processes do not inherit it.
        if _is_locked(folder):
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            return folder


def _remove_abandoned() -> None:
    """Remove this account's folders whose lock no process holds."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):
            if folder.is_dir() and not folder.is_symlink() and folder.stat().st_uid == os.geteuid():
                _remove_unlocked(folder)


def _remove_unlocked(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)  # BlockingIOError if its process is running
        shutil.rmtree(folder, ignore_errors=True)
    finally:
        os.close(handle)


def _is_locked(folder: Path) -> bool:
    """Lock a new folder until this process ends; return False if another start has just removed it."""
    handle = os.open(folder, os.O_RDONLY)
    with contextlib.suppress(OSError):  # a file system without locks, on which no start removes a folder
        fcntl.flock(handle, fcntl.LOCK_EX)
    return folder.exists()
