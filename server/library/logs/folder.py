"""A read-only folder of logs that every visitor may open."""

from __future__ import annotations

import hashlib
import os
import stat
from dataclasses import dataclass
from pathlib import Path

from mapper.core.errors import MapperError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io import logs

MAX_LOGS = 10_000
TEXT_ENDS = frozenset({".xyz", ".pts", ".csv", ".asc"})  #: of clouds as text
MAX_FILES = 100  #: in a folder that is one log,
MAX_DEPTH_FILES = 10_000  #: and in one of depth images, including its subfolders


@dataclass(frozen=True, slots=True)
class FolderLog:
    """One log of the folder; ``id`` is constant as long as its name, size and time are."""

    id: str
    name: str
    path: Path  #: with links resolved
    bytes: int
    modified_s: float


class LogFolder:
    """The logs among the files of ``folder``. Each file is examined once, until it changes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._is_log: dict[
            tuple[Path, tuple[tuple[int, int, int], ...]], bool
        ] = {}  #: results by path, sizes and times

    def logs(self) -> list[FolderLog]:
        """Return the logs in the folder by name, at most :data:`MAX_LOGS`: its files, and folders that are one log.

        Clouds, octrees and depth images are logs too. Hidden files, devices, links that lead out of the folder, and
        files that do not begin like logs are left out. A folder that is missing or unreadable counts as empty, and the
        service runs without it.
        """
        in_folder = []
        is_log_now = {}
        try:
            root = self._folder.resolve(strict=True)
            paths = sorted(self._folder.iterdir(), key=lambda path: path.name.casefold())
        except OSError:
            return []
        for path in paths:
            if path.name.startswith("."):
                continue
            target = _within(path, root)
            files = [] if target is None else _files_of(target, root)
            if target is None or not files:
                continue
            key = (target, tuple((info.st_size, info.st_mtime_ns, info.st_ctime_ns) for info in files))
            is_log_now[key] = self._is_log[key] if key in self._is_log else _is_log(target)
            if is_log_now[key]:
                in_folder.append(_described(path.name, target, files))
            if len(in_folder) == MAX_LOGS:
                break
        self._is_log = is_log_now
        return in_folder


def _is_log(target: Path) -> bool:
    """Return whether a file or folder begins like a planar log, or like a source of a 3D map."""
    # The readers of all formats, which few services need.
    from server.library.packs.volume_files import holds_volume  # noqa: PLC0415

    try:
        return logs.is_log(target) or (holds_volume(target) and (target.is_dir() or _is_cloud_by_name(target)))
    except (MapperError, OSError):
        return False


def _is_cloud_by_name(target: Path) -> bool:
    """Return whether a file with a cloud should be listed; lines of numbers may also be poses or a matrix."""
    from mapper.io.clouds.reading import TEXT, format_of  # noqa: PLC0415

    return format_of(target, DEFAULT_LIMITS) != TEXT or any(end in TEXT_ENDS for end in target.suffixes[-2:])


def _within(path: Path, root: Path) -> Path | None:
    """Return ``path`` with links resolved, None if it does not exist or is outside ``root``."""
    try:
        target = path.resolve(strict=True)
    except (OSError, RuntimeError):  # a broken link or a cycle of links
        return None
    return target if target.is_relative_to(root) else None


def _files_of(target: Path, root: Path) -> list[os.stat_result]:
    """Return the status of a file or of the files in a folder.

    Returns an empty list for a folder that contains anything but files, unless it is one of depth images in TUM's
    format, which are in a subfolder.
    """
    from mapper.io.clouds.depth_folder import is_depth_folder  # noqa: PLC0415 - as in _is_log

    try:
        inside, most = [target], MAX_FILES
        if target.is_dir():
            inside = sorted(target.iterdir())
            if is_depth_folder(target):
                most = MAX_DEPTH_FILES
                inside = [file for path in inside for file in (sorted(path.iterdir()) if path.is_dir() else [path])]
        if len(inside) > most:
            return []
        files = [path.stat() for path in inside if _within(path, root) is not None]
    except OSError:  # deleted in the meantime, or unreadable
        return []
    return files if len(files) == len(inside) and all(stat.S_ISREG(file.st_mode) for file in files) else []


def _described(name: str, path: Path, files: list[os.stat_result]) -> FolderLog:
    size, modified_ns = sum(file.st_size for file in files), max(file.st_mtime_ns for file in files)
    digest = hashlib.sha256(f"{name}\0{size}\0{modified_ns}".encode("utf-8", "surrogateescape"))
    return FolderLog(f"folder-{digest.hexdigest()[:20]}", name, path, size, modified_ns / 1e9)
