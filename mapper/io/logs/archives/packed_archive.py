"""Files in a tar archive, plain or compressed with gzip or Zstandard, read in place.

Nothing is written to disk for a compressed archive either: a file in it is read by decompressing the archive up to it,
in pieces. Seeking backwards means decompressing from the beginning again, so readers go forwards.
"""

from __future__ import annotations

import io
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from mapper.core.errors import LimitError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.archives.archive import BLOCK, Member, is_tar, members
from mapper.io.logs.archives.inflate import ZSTD_MAGIC
from mapper.io.logs.archives.unpacking import GZIP_MAGIC, Unpacked, opened

if TYPE_CHECKING:
    from collections.abc import Iterator

    from _typeshed import WriteableBuffer as Buffer

MOST_PACKED_FILES = 64  #: files whose first bytes are cached; the archive is decompressed up to each file read


def archive_members(path: Path, limits: Limits) -> tuple[list[Member], list[str]] | None:
    """Return the files in the archive at ``path`` and notes on its end; None if it is not an archive.

    Raises the errors of :func:`members` and, for compressed data, of :class:`Unpacked`.
    """
    packed = _is_packed(path)
    if packed is None:
        return None
    if not packed:
        return members(path, limits)
    few = replace(limits, max_archive_files=min(limits.max_archive_files, MOST_PACKED_FILES))
    try:
        return members(path, few, partial(unpacked_file, limits=limits))
    except LimitError as error:
        if error.code != "log.too_many_files":
            raise
        raise LimitError(
            error.code,
            f"The packed archive has more than {few.max_archive_files} files, too many to find the log "
            "without unpacking it: unpack it, and take the log (or the folder) in it.",
        ) from error


def is_archive(path: Path) -> bool:
    """Return whether ``path`` is a tar archive, plain or compressed. Raises the errors of :func:`archive_members`."""
    return _is_packed(path) is not None


def unpacked_file(path: Path, limits: Limits) -> BinaryIO:
    """Return the decompressed contents of the file at ``path``, as a file. Raises :class:`ReadError`."""
    raw: io.RawIOBase = _UnpackedFile(path, limits)
    return io.BufferedReader(raw)


def _is_packed(path: Path) -> bool | None:
    """Return whether the archive at ``path`` is compressed; None if it is not an archive."""
    with opened(path) as file:
        head = file.read(BLOCK)
    if is_tar(head):
        return False
    if not head.startswith((GZIP_MAGIC, ZSTD_MAGIC)):
        return None
    with unpacked_file(path, DEFAULT_LIMITS) as file:
        return True if is_tar(file.read(BLOCK)) else None


class _UnpackedFile(io.RawIOBase):
    """The decompressed contents of a file, up to any damage."""

    def __init__(self, path: Path, limits: Limits) -> None:
        self._path, self._limits = path, limits
        self._at = 0  #: offset of the next byte
        self._begin()

    def _begin(self) -> None:
        self._file = opened(self._path)
        where = "at the beginning"
        self._pieces: Iterator[bytes] = iter(Unpacked(self._file, lambda: where, self._limits))
        self._piece, self._piece_at = b"", 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        base = self._end() if whence == io.SEEK_END else self._at if whence == io.SEEK_CUR else 0
        self._at = max(0, base + offset)
        return self._at

    def tell(self) -> int:
        return self._at

    def readinto(self, buffer: Buffer) -> int:
        if self._at < self._piece_at:
            self._file.close()
            self._begin()
        while self._at >= self._piece_at + len(self._piece):
            if not self._next():
                return 0
        view = memoryview(buffer)
        data = self._piece[self._at - self._piece_at :][: len(view)]
        view[: len(data)] = data
        self._at += len(data)
        return len(data)

    def _next(self) -> bool:
        piece = next(self._pieces, b"")
        self._piece_at += len(self._piece)
        self._piece = piece
        return bool(piece)

    def _end(self) -> int:
        while self._next():
            pass
        return self._piece_at

    def close(self) -> None:
        self._file.close()
        super().close()
