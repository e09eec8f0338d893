"""A folder of logs that everybody may open and nobody may change."""

from __future__ import annotations

import hashlib
import stat
from dataclasses import dataclass
from pathlib import Path

MAX_FILES = 1000


@dataclass(frozen=True, slots=True)
class FolderLog:
    """One file of the folder; ``id`` stays the same as long as its name, size and time do."""

    id: str
    name: str
    path: Path  #: what the name leads to
    bytes: int
    modified_s: float


def list_folder(folder: Path) -> list[FolderLog]:
    """Return the files in ``folder`` by name: its own files only, at most :data:`MAX_FILES`.

    Hidden files, folders, devices and links that lead out of the folder are left out. A folder that is not there,
    or may not be read, is empty: the service runs on without it.
    """
    found = []
    try:
        root = folder.resolve(strict=True)
        paths = sorted(folder.iterdir(), key=lambda path: path.name.casefold())
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
        digest = hashlib.sha256(f"{path.name}\0{info.st_size}\0{info.st_mtime_ns}".encode("utf-8", "surrogateescape"))
        found.append(FolderLog(f"folder-{digest.hexdigest()[:20]}", path.name, target, info.st_size, info.st_mtime))
        if len(found) == MAX_FILES:
            break
    return found
