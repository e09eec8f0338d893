"""Sequential reading of a binary log, plain, gzip or Zstandard, with memory bounded by the bytes that exist."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from mapper.core.errors import LimitError
from mapper.core.limits import Limits
from mapper.io.logs.archive import Source
from mapper.io.logs.unpacking import PIECE, Progress, Unpacked, opened


class ByteStream:
    """Reads forward. ``at`` is the offset in the log (after decompression); ``crc`` its CRC-32 up to there."""

    def __init__(self, file: BinaryIO, limits: Limits, progress: Progress | None = None) -> None:
        self._unpacked = Unpacked(file, lambda: f"after byte {self.at}", progress)
        self._pieces = iter(self._unpacked)
        self._limits = limits
        self._held = b""
        self._start = 0  #: of what is not yet read in ``_held``
        self.at = 0
        self.crc = 0

    @property
    def notes(self) -> list[str]:
        """What is to be said of packed data that was found damaged so far."""
        if self._unpacked.broken != "is damaged":
            return []
        return [
            f"The {self._unpacked.packing} data is damaged: what comes out of it before is there, some perhaps wrong."
        ]

    def read(self, n: int) -> bytes:
        """Return the next ``n`` bytes, fewer at the end. Raises :class:`LimitError` for more than one record may have.

        Memory grows with what is there, not with ``n``.
        """
        if self._start + n <= len(self._held):  # most reads are small
            taken = self._held[self._start : self._start + n]
            self._start += n
        else:
            taken = self._gathered(n)
        if len(taken) > self._limits.max_chunk_bytes:
            raise self._too_large()
        self.at += len(taken)
        if self.at > self._limits.max_log_bytes:
            raise LimitError(
                "log.too_many_bytes",
                f"The log is larger than the limit of {self._limits.max_log_bytes} bytes, counted after decompression.",
            )
        self.crc = zlib.crc32(taken, self.crc)
        return taken

    def _gathered(self, n: int) -> bytes:
        parts = [self._held[self._start :]]
        have = len(parts[0])
        self._held, self._start = b"", 0
        while have < n:
            if have > self._limits.max_chunk_bytes:
                raise self._too_large()
            piece = next(self._pieces, b"")
            if not piece:
                break
            parts.append(piece)
            have += len(piece)
        if have > n:
            keep = len(parts[-1]) - (have - n)
            self._held, self._start = parts[-1], keep
            parts[-1] = parts[-1][:keep]
        return b"".join(parts)

    def _too_large(self) -> LimitError:
        return LimitError(
            "log.chunk_too_large",
            f"At byte {self.at}: a record is larger than the limit of {self._limits.max_chunk_bytes} bytes.",
        )

    def skip(self, n: int) -> int:
        """Pass over ``n`` bytes; return how many there were."""
        done = 0
        while done < n:
            got = len(self.read(min(PIECE, self._limits.max_chunk_bytes, n - done)))
            if not got:
                break
            done += got
        return done


@contextmanager
def byte_stream(path: Source, limits: Limits, progress: Progress | None = None) -> Iterator[ByteStream]:
    """Open the log at ``path``. Reading raises :class:`ReadError` for damaged packed data, or a disk that fails."""
    with opened(path) as file:
        yield ByteStream(file, limits, progress)
