"""Bytes of a log file from start to end, in pieces: plain, or decompressed from gzip or Zstandard.

Source: RFC 1952 (a gzip file may consist of several members and be padded with zeros); RFC 8878 (Zstandard).
"""

from __future__ import annotations

import contextlib
import os
import zlib
from collections.abc import Callable, Iterator
from typing import IO, BinaryIO, cast

import zstandard

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.inflate import MAX_WINDOW, ZSTD_MAGIC

GZIP_MAGIC = b"\x1f\x8b"
PIECE = 1 << 18  #: bytes read or decompressed at a time

Progress = Callable[[float], None]  #: called from time to time with the fraction of the file read, 0 to 1


def part_of(progress: Progress | None, done: int, of: int) -> Progress | None:
    """Return the progress callback for the next of ``of`` files, of which ``done`` are done."""
    return None if progress is None else lambda share: progress((done + share) / of)


def opened(path: Source) -> BinaryIO:
    """Open a file for reading. Raises :class:`ReadError` if it is missing or not readable."""
    try:
        return path.open("rb")
    except FileNotFoundError as error:
        raise ReadError("log.missing", f"There is no file {path.name!r}.") from error
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ReadError("log.unreadable", f"The file {path.name!r} cannot be read: {reason}.") from error


class Unpacked:
    """The pieces of one open file; iterate once. None is empty or longer than ``PIECE``.

    ``packing`` is the compression, "gzip" or "zstd", or None. ``broken`` is afterwards the damage in the compressed
    data, "ends early" or "is damaged", or None. The pieces are then the output before the damage; if only the checksum
    reveals it, they are complete but wrong in places. An early end cannot be detected for Zstandard data without a
    stated size. ``where`` returns the position in the log for error messages. Raises :class:`ReadError` for compressed
    data without output and for disk errors, and :class:`LimitError` for compressed data that expands to more than
    ``limits`` allow.
    """

    def __init__(
        self, file: BinaryIO, where: Callable[[], str], limits: Limits, progress: Progress | None = None
    ) -> None:
        self.packing: str | None = None
        self.broken: str | None = None
        self._limits = limits
        self._size = 0  #: of the file
        self._file = file
        self._where = where
        self._progress = progress

    def __iter__(self) -> Iterator[bytes]:
        raw = self._raw()
        first = next(raw, b"")
        if first.startswith(GZIP_MAGIC):
            self.packing, unpacked = "gzip", self._gunzipped(first, raw)
        elif first.startswith(ZSTD_MAGIC):
            self.packing, unpacked = "zstd", self._unzstd(first, raw)
        else:
            if first:
                yield first
                yield from raw
            return
        total, most = 0, self._limits.unpacked_bytes(self._size)
        try:
            for piece in filter(None, unpacked):
                total += len(piece)
                if total > most:
                    raise LimitError(
                        "log.too_many_bytes",
                        f"The {self.packing} data expands to more than the limit of {most} bytes: {self._where()}.",
                    )
                yield piece
        except (zlib.error, zstandard.ZstdError) as error:
            if not total:
                code = "log.gzip" if self.packing == "gzip" else "log.compression"
                raise ReadError(
                    code, f"The {self.packing} data is damaged {self._where()} of the log: {error}."
                ) from error
            self.broken = "is damaged"

    def _raw(self) -> Iterator[bytes]:
        done = 0
        try:
            self._size = self._file.seek(0, os.SEEK_END)
            self._file.seek(0)
            while piece := self._file.read(PIECE):
                done += len(piece)
                yield piece
                if self._progress is not None:
                    self._progress(min(1.0, done / max(1, self._size)))
        except OSError as error:
            raise ReadError(
                "log.unreadable", f"The file cannot be read to its end: {error.strerror}, {self._where()}."
            ) from error

    def _gunzipped(self, data: bytes, raw: Iterator[bytes]) -> Iterator[bytes]:
        stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
        while data := data or next(raw, b""):
            if stream.eof:
                data = data.lstrip(b"\0")
                if not data:
                    continue
                stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
            while data and not stream.eof:
                before = stream.copy()
                try:
                    piece = stream.decompress(data, PIECE)
                except zlib.error:
                    yield from _up_to_the_damage(before, data)
                    raise
                yield piece
                data = stream.unconsumed_tail
            data = stream.unused_data if stream.eof else b""
        # Output held back by decompress() because of PIECE must still be read.
        while not stream.eof and (piece := stream.decompress(b"", PIECE)):
            yield piece
        self.broken = None if stream.eof else "ends early"

    def _unzstd(self, first: bytes, raw: Iterator[bytes]) -> Iterator[bytes]:
        stated = zstandard.frame_content_size(first)
        stream = zstandard.ZstdDecompressor(max_window_size=MAX_WINDOW).stream_reader(
            cast("IO[bytes]", _Readable(first, raw)), read_across_frames=True
        )
        done = 0
        while piece := stream.read1(PIECE):  # no more than is available, because the rest may be damaged
            done += len(piece)
            yield piece
        self.broken = "ends early" if done < stated or done == 0 != stated else None


def _up_to_the_damage(stream: zlib._Decompress, data: bytes) -> Iterator[bytes]:
    """Yield the decompressed part of ``data`` before the error in it."""
    out = bytearray()
    with contextlib.suppress(zlib.error):
        for at in range(len(data)):
            out += stream.decompress(data[at : at + 1])  # a failing call would lose all of its output
            if len(out) > PIECE // 2:
                yield bytes(out)
                out.clear()
    yield bytes(out)


class _Readable:
    """The pieces as a file object for zstandard."""

    def __init__(self, first: bytes, pieces: Iterator[bytes]) -> None:
        self._pieces = pieces
        self._held = first

    def read(self, n: int) -> bytes:
        while not self._held:
            self._held = next(self._pieces, b"")
            if not self._held:
                return b""
        data, self._held = self._held[:n], self._held[n:]
        return data
