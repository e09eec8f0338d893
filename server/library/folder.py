"""A folder of logs that everybody may open and nobody may change."""

from __future__ import annotations

import hashlib
import os
import stat
from dataclasses import dataclass
from pathlib import Path

from mapper.logs import is_log

MAX_LOGS = 1000


@dataclass(frozen=True, slots=True)
class FolderLog:
    """One log of the folder; ``id`` stays the same as long as its name, size and time do."""

    id: str
    name: str
    path: Path  #: what the name leads to
    bytes: int
    modified_s: float


class LogFolder:
    """The logs among the files of ``folder``. What is no log is found out once."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._is_log: dict[tuple[Path, int, int, int], bool] = {}  #: what was found out, by path, size and times

    def logs(self) -> list[FolderLog]:
        """Return the logs in the folder by name: its own files only, at most :data:`MAX_LOGS`.

        Hidden files, folders, devices, links that lead out of the folder and files that do not begin as a log does
        are left out. A folder that is not there, or may not be read, is empty: the service runs on without it.
        """
        found = []
        is_log_now = {}
        try:
            root = self._folder.resolve(strict=True)
            paths = sorted(self._folder.iterdir(), key=lambda path: path.name.casefold())
        except OSError:
            return []
        for path in paths:
            if path.name.startswith("."):
                continue
            try:
                target = path.resolve(strict=True)
                info = target.stat()
            except (OSError, RuntimeError):  # a link into nothing, or round in a circle
                continue
            if not stat.S_ISREG(info.st_mode) or not target.is_relative_to(root):
                continue
            key = (target, info.st_size, info.st_mtime_ns, info.st_ctime_ns)
            is_log_now[key] = self._is_log[key] if key in self._is_log else is_log(target)
            if is_log_now[key]:
                found.append(_described(path.name, target, info))
            if len(found) == MAX_LOGS:
                break
        self._is_log = is_log_now
        return found


def _described(name: str, path: Path, info: os.stat_result) -> FolderLog:
    digest = hashlib.sha256(f"{name}\0{info.st_size}\0{info.st_mtime_ns}".encode("utf-8", "surrogateescape"))
    return FolderLog(f"folder-{digest.hexdigest()[:20]}", name, path, info.st_size, info.st_mtime)
