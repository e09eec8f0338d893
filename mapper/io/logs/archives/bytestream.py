"""Sequential reading of a binary log, plain, gzip or Zstandard, with memory bounded by the existing bytes.

Skipped bytes of a plain file are not read; compressed data has to be decompressed up to the target.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.inflate import ZSTD_MAGIC
from mapper.io.logs.archives.unpacking import GZIP_MAGIC, PIECE, Progress, Unpacked, opened

FIRST_PIECE = 1 << 14  #: bytes read after a jump; each further piece is twice as long, up to PIECE
WORTH_A_JUMP = 1 << 15  #: bytes: shorter gaps are read through, so that checksums over them can be verified


class _Plain:
    """The pieces of an uncompressed file from any offset."""

    def __init__(self, file: BinaryIO, progress: Progress | None) -> None:
        self._file, self._progress = file, progress
        self.size = file.seek(0, os.SEEK_END)
        self._at = 0
        self._next_bytes = FIRST_PIECE

    def piece(self) -> bytes:
        """Return the next bytes; empty at the end. Raises :class:`ReadError` for disk errors."""
        piece = self.bytes_at(self._at, self._next_bytes)
        self._next_bytes = min(2 * self._next_bytes, PIECE)
        self._at += len(piece)
        self._note_progress()
        return piece

    def bytes_at(self, at: int, n: int) -> bytes:
        """Return ``n`` bytes from an offset, fewer at the end. Raises :class:`ReadError` for disk errors."""
        try:
            self._file.seek(at)
            return self._file.read(n)
        except OSError as error:
            raise ReadError(
                "log.unreadable", f"The file cannot be read to its end: {error.strerror}, after byte {at}."
            ) from error

    def skip(self, n: int) -> int:
        """Skip ``n`` bytes; return how many there were."""
        done = min(n, self.size - self._at)
        self._at += done
        self._next_bytes = FIRST_PIECE
        self._note_progress()
        return done

    def _note_progress(self) -> None:
        if self._progress is not None:
            self._progress(min(1.0, self._at / max(1, self.size)))


class ByteStream:
    """Reads forward. ``at`` is the offset in the decompressed log.

    ``crc`` is the CRC-32 of all bytes so far, None once some were skipped unread.
    """

    def __init__(self, file: BinaryIO, limits: Limits, progress: Progress | None = None) -> None:
        plain = _Plain(file, progress)
        self.file_size = plain.size  #: on disk
        self._plain: _Plain | None = plain
        self._unpacked: Unpacked | None = None
        self._pieces: Iterator[bytes] = iter(())
        if plain.bytes_at(0, 4).startswith((GZIP_MAGIC, ZSTD_MAGIC)):
            self._plain = None
            self._unpacked = Unpacked(file, lambda: f"after byte {self.at}", limits, progress)
            self._pieces = iter(self._unpacked)
        self._limits = limits
        self._held = b""
        self._start = 0  #: of the unread part of ``_held``
        self.at = 0
        self.crc: int | None = 0

    @property
    def notes(self) -> list[str]:
        """Notes on damage found in the compressed data so far."""
        if self._unpacked is None or self._unpacked.broken != "is damaged":
            return []
        return [
            f"The {self._unpacked.packing} data is damaged: what comes out of it before is there, some perhaps wrong."
        ]

    @property
    def can_jump(self) -> bool:
        """Whether bytes can be skipped without reading them, and read ahead."""
        return self._plain is not None

    def read(self, n: int) -> bytes:
        """Return the next ``n`` bytes, fewer at the end. Raises :class:`LimitError` for more than a record may have.

        Memory grows with the available data, not with ``n``.
        """
        if self._start + n <= len(self._held):  # most reads are small
            data = self._held[self._start : self._start + n]
            self._start += n
        else:
            data = self._gathered(n)
        if len(data) > self._limits.max_chunk_bytes:
            raise self._too_large()
        self.at += len(data)
        if self.crc is not None:
            self.crc = zlib.crc32(data, self.crc)
        return data

    def _gathered(self, n: int) -> bytes:
        parts = [self._held[self._start :]]
        have = len(parts[0])
        self._held, self._start = b"", 0
        while have < n:
            if have > self._limits.max_chunk_bytes:
                raise self._too_large()
            piece = next(self._pieces, b"") if self._plain is None else self._plain.piece()
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
        """Skip ``n`` bytes; return how many there were. Long gaps in a plain file are not read."""
        buffered = len(self._held) - self._start
        if self._plain is not None and n - buffered >= WORTH_A_JUMP:
            self._held, self._start = b"", 0
            done = buffered + self._plain.skip(n - buffered)
            self.at += done
            self.crc = None
            return done
        done = 0
        while done < n:
            got = len(self.read(min(PIECE, self._limits.max_chunk_bytes, n - done)))
            if not got:
                break
            done += got
        return done

    def ahead(self, skipped: int, n: int) -> bytes:
        """Return ``n`` bytes, fewer at the end, after the next ``skipped`` ones; none for compressed data."""
        return b"" if self._plain is None else self._plain.bytes_at(self.at + skipped, n)


class Section:
    """The next ``left`` bytes of a stream.

    ``crc`` is the CRC-32 of the bytes read so far, None once some were skipped unread.
    """

    def __init__(self, stream: ByteStream, size: int) -> None:
        self._stream = stream
        self.left = size
        self.crc: int | None = 0

    def read(self, n: int) -> bytes:
        """Return the next ``n`` bytes, fewer at the end of the section or stream, like :meth:`ByteStream.read`."""
        data = self._stream.read(min(n, self.left))
        self.left -= len(data)
        if self.crc is not None:
            self.crc = zlib.crc32(data, self.crc)
        return data

    def skip(self, n: int) -> int:
        """Skip ``n`` bytes; return how many there were."""
        if n < WORTH_A_JUMP:
            return len(self.read(n))
        done = self._stream.skip(min(n, self.left))
        self.left -= done
        self.crc = None
        return done


@contextmanager
def byte_stream(path: Source, limits: Limits, progress: Progress | None = None) -> Iterator[ByteStream]:
    """Open the log at ``path``.

    Reading raises :class:`ReadError` for damaged compressed data or disk errors, and :class:`LimitError` for compressed
    data that expands to more than ``limits`` allow.
    """
    with opened(path) as file:
        yield ByteStream(file, limits, progress)
