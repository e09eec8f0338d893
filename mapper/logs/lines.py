"""The lines of a text log, plain or gzip, read in pieces so that neither a bomb nor one huge line fills the memory.

Source of the gzip format: RFC 1952 (a file may be several members, one after the other).
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from mapper.errors import LimitError, ReadError
from mapper.limits import Limits

GZIP_MAGIC = b"\x1f\x8b"
PIECE = 1 << 18  #: bytes read, and bytes decompressed, at a time

Progress = Callable[[float], None]  #: called now and then with the share of the file that has been read, 0 … 1


def opened(path: Path) -> BinaryIO:
    """Open a file for reading. Raises :class:`ReadError` if it is missing or may not be read."""
    try:
        return path.open("rb")
    except FileNotFoundError as error:
        raise ReadError("log.missing", f"There is no file {path.name!r}.") from error
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ReadError("log.unreadable", f"The file {path.name!r} cannot be read: {reason}.") from error


class TextLines:
    """The lines of one file; iterate once, over ``(line number from 1, line without its end)``.

    While the last line is handed out ``unfinished`` says that it has no line end: whoever parses it may find it cut.
    ``cut_after`` is afterwards the number of whole lines before the place where a gzip file ends too early, or None;
    the piece of a line that it ends in is never handed out.

    Raises :class:`LimitError` for more lines than ``limits`` allow, or for more bytes, after decompression, in the file
    or in one line, and :class:`ReadError` for a file that cannot be opened, is empty or holds damaged gzip data.
    """

    def __init__(self, path: Path, limits: Limits, progress: Progress | None = None) -> None:
        self.path = path
        self.limits = limits
        self.progress = progress
        self.unfinished = False
        self.cut_after: int | None = None
        self.number = 0  #: of the line handed out last

    def __iter__(self) -> Iterator[tuple[int, bytes]]:
        rest = b""
        total = 0
        for piece in self._pieces():
            total += len(piece)
            if total > self.limits.max_log_bytes:
                raise LimitError(
                    "log.too_many_bytes",
                    f"The log is larger than the limit of {self.limits.max_log_bytes} bytes, counted after "
                    f"decompression; {self.number} lines were read.",
                )
            lines = (rest + piece).split(b"\n")
            rest = lines.pop()
            if self.number + len(lines) > self.limits.max_lines:
                raise LimitError(
                    "log.too_many_lines", f"The log has more lines than the limit of {self.limits.max_lines}."
                )
            for line in lines:
                self.number += 1
                if len(line) > self.limits.max_line_bytes:
                    raise self._line_too_long(self.number)
                yield self.number, line
            if len(rest) > self.limits.max_line_bytes:
                raise self._line_too_long(self.number + 1)
        if total == 0 and self.cut_after is None:
            raise ReadError("log.empty", "The file is empty.")
        if rest and self.cut_after is None:
            self.number += 1
            self.unfinished = True
            yield self.number, rest

    def _line_too_long(self, number: int) -> LimitError:
        return LimitError(
            "log.line_too_long",
            f"Line {number} is longer than the limit of {self.limits.max_line_bytes} bytes; this is not a text log.",
        )

    def _pieces(self) -> Iterator[bytes]:
        """Yield the text in pieces of at most ``PIECE`` bytes."""
        with opened(self.path) as file:
            size = max(1, os.fstat(file.fileno()).st_size)
            raw = self._raw(file, size)
            first = next(raw, b"")
            if first.startswith(GZIP_MAGIC):
                yield from self._unzipped(first, raw)
            else:
                yield first
                yield from raw

    def _raw(self, file: BinaryIO, size: int) -> Iterator[bytes]:
        done = 0
        try:
            while piece := file.read(PIECE):
                done += len(piece)
                yield piece
                if self.progress is not None:
                    self.progress(min(1.0, done / size))
        except OSError as error:
            raise ReadError(
                "log.unreadable", f"The file cannot be read to its end: {error.strerror}, after line {self.number}."
            ) from error

    def _unzipped(self, data: bytes, raw: Iterator[bytes]) -> Iterator[bytes]:
        stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
        while True:
            if stream.eof:
                # Another member may follow, and padding of zeros.
                data = (stream.unused_data or data).lstrip(b"\0")
                while not data:
                    more = next(raw, None)
                    if more is None:
                        return
                    data = more.lstrip(b"\0")
                stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
            try:
                piece = stream.decompress(data, PIECE)
            except zlib.error as error:
                raise ReadError(
                    "log.gzip", f"The gzip data is damaged after line {self.number} of the log: {error}."
                ) from error
            if piece:
                yield piece
            data = stream.unconsumed_tail
            if not data and not stream.eof:
                more = next(raw, None)
                if more is None:
                    # What decompress() kept back because of PIECE still has to come out.
                    if piece:
                        data = b""
                        continue
                    self.cut_after = self.number
                    return
                data = more


def take_lines(
    lines: TextLines, take: Callable[[int, bytes], None], n_scans: Callable[[], int], notes: list[str]
) -> None:
    """Give every line to ``take`` and put into ``notes`` what is missing at the end of a cut file.

    A file that was cut, by a full disk or a broken download, still has good scans: its last, broken line is left out
    if whole scans came before it. Otherwise :class:`ReadError`.
    """
    for number, text in lines:
        try:
            take(number, text)
        except ReadError:
            if not (lines.unfinished and n_scans()):
                raise
            notes.append(f"The file ends in the middle of line {number}, which is left out.")
    if lines.cut_after is None:
        return
    if not n_scans():
        raise ReadError(
            "log.truncated", f"The gzip data ends early, after line {lines.cut_after}, before any whole scan."
        )
    notes.append(f"The gzip data ends early, after line {lines.cut_after}: the rest of the log is missing.")
