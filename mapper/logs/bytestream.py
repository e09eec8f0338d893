"""The bytes of a binary log from front to back, plain, gzip or Zstandard, never more at a time than there are."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, BinaryIO, cast

import zstandard

from mapper.errors import LimitError, ReadError
from mapper.limits import Limits
from mapper.logs.inflate import MAX_WINDOW, ZSTD_MAGIC
from mapper.logs.lines import GZIP_MAGIC, Progress, opened

PIECE = 1 << 18


class ByteStream:
    """Reads forward. ``at`` is the offset in the log (after decompression); ``crc`` its CRC-32 up to there."""

    def __init__(self, pieces: Iterator[bytes], limits: Limits) -> None:
        self._pieces = pieces
        self._limits = limits
        self._held = b""
        self._start = 0  #: of what is not yet read in ``_held``
        self.at = 0
        self.crc = 0

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
def byte_stream(path: Path, limits: Limits, progress: Progress | None = None) -> Iterator[ByteStream]:
    """Open the log at ``path``. Reading raises :class:`ReadError` for damaged compressed data, or a disk that fails."""
    with opened(path) as file:
        yield ByteStream(_pieces(file, progress), limits)


def _pieces(file: BinaryIO, progress: Progress | None) -> Iterator[bytes]:
    head = file.read(4)
    file.seek(0)
    raw = _raw(file, progress)
    try:
        if head.startswith(GZIP_MAGIC):
            yield from _gunzipped(raw)
        elif head == ZSTD_MAGIC:
            stream = zstandard.ZstdDecompressor(max_window_size=MAX_WINDOW).stream_reader(
                cast("IO[bytes]", _Readable(raw)), read_across_frames=True
            )
            while piece := stream.read(PIECE):
                yield piece
        else:
            yield from raw
    except (zlib.error, zstandard.ZstdError) as error:
        raise ReadError("log.compression", f"The log's compressed data is damaged: {error}.") from error


def _raw(file: BinaryIO, progress: Progress | None) -> Iterator[bytes]:
    size = max(1, os.fstat(file.fileno()).st_size)
    done = 0
    try:
        while piece := file.read(PIECE):
            yield piece
            done += len(piece)
            if progress is not None:
                progress(min(1.0, done / size))
    except OSError as error:
        raise ReadError(
            "log.unreadable", f"The file cannot be read to its end: {error.strerror}, after byte {done}."
        ) from error


def _gunzipped(raw: Iterator[bytes]) -> Iterator[bytes]:
    """Yield what a gzip file of one or more members holds; of one that ends early, what came before."""
    stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
    data = b""
    while data := data or next(raw, b""):
        if stream.eof:
            data = data.lstrip(b"\0")
            if not data:
                continue
            stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
        while data and not stream.eof:
            yield stream.decompress(data, PIECE)
            data = stream.unconsumed_tail
        data = stream.unused_data if stream.eof else b""
    # What decompress() kept back because of PIECE still has to come out.
    while not stream.eof and (piece := stream.decompress(b"", PIECE)):
        yield piece


class _Readable:
    """An iterator of pieces as the file that zstandard reads from."""

    def __init__(self, pieces: Iterator[bytes]) -> None:
        self._pieces = pieces
        self._held = b""

    def read(self, n: int) -> bytes:
        while not self._held:
            self._held = next(self._pieces, b"")
            if not self._held:
                return b""
        taken, self._held = self._held[:n], self._held[n:]
        return taken
