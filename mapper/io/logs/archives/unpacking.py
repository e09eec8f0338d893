"""The bytes of a log's file from front to back, in pieces: as they are, or taken out of gzip or Zstandard.

Source: RFC 1952 (a gzip file may be several members, one after the other, and padded with zeros); RFC 8878 (Zstandard).
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
PIECE = 1 << 18  #: bytes read, and bytes decompressed, at a time

Progress = Callable[[float], None]  #: called now and then with the share of the file that has been read, 0 … 1


def part_of(progress: Progress | None, done: int, of: int) -> Progress | None:
    """Return the progress of the next of ``of`` files, of which ``done`` are done."""
    return None if progress is None else lambda share: progress((done + share) / of)


def opened(path: Source) -> BinaryIO:
    """Open a file for reading. Raises :class:`ReadError` if it is missing or may not be read."""
    try:
        return path.open("rb")
    except FileNotFoundError as error:
        raise ReadError("log.missing", f"There is no file {path.name!r}.") from error
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ReadError("log.unreadable", f"The file {path.name!r} cannot be read: {reason}.") from error


class Unpacked:
    """The pieces of one open file; iterate once. None is empty or longer than ``PIECE``.

    ``packing`` is what the file is packed with, "gzip" or "zstd", or None. ``broken`` says afterwards what is wrong
    with the packed data, "ends early" or "is damaged", or None: the pieces are what comes out before. Where nothing
    tells of it before a checksum does, they are all, and wrong in places. Of Zstandard data that does not state its
    size it cannot be detected that it ends early. ``where`` is asked in which place of the log an error comes. Raises
    :class:`ReadError` for packed data of which nothing comes out and for a disk that fails, and :class:`LimitError`
    for packed data that expands to more than ``limits`` allow.
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
        # What decompress() kept back because of PIECE still has to come out.
        while not stream.eof and (piece := stream.decompress(b"", PIECE)):
            yield piece
        self.broken = None if stream.eof else "ends early"

    def _unzstd(self, first: bytes, raw: Iterator[bytes]) -> Iterator[bytes]:
        stated = zstandard.frame_content_size(first)
        stream = zstandard.ZstdDecompressor(max_window_size=MAX_WINDOW).stream_reader(
            cast("IO[bytes]", _Readable(first, raw)), read_across_frames=True
        )
        done = 0
        while piece := stream.read1(PIECE):  # no more than is there, of which the rest may be damaged
            done += len(piece)
            yield piece
        self.broken = "ends early" if done < stated or done == 0 != stated else None


def _up_to_the_damage(stream: zlib._Decompress, data: bytes) -> Iterator[bytes]:
    """Yield what can be decompressed of ``data`` before the error in it."""
    out = bytearray()
    with contextlib.suppress(zlib.error):
        for at in range(len(data)):
            out += stream.decompress(data[at : at + 1])  # of a call that fails, all would be lost
            if len(out) > PIECE // 2:
                yield bytes(out)
                out.clear()
    yield bytes(out)


class _Readable:
    """Pieces as the file that zstandard reads from."""

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
