"""Lines of a text log, plain or compressed, read in pieces, so that a decompression bomb cannot fill the memory."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress, Unpacked, opened

BOM = b"\xef\xbb\xbf"  #: written by spreadsheets before the first line of UTF-8 text


def ends_in_returns(begin: bytes) -> bool:
    """Return whether the lines of a text with this beginning end in carriage returns only (old Macintosh programs)."""
    return b"\n" not in begin and b"\r" in begin and b"\0" not in begin


def with_line_feeds(data: bytes) -> bytes:
    """Return a text with carriage-return line ends converted to line feeds; other data unchanged."""
    return data.replace(b"\r", b"\n") if ends_in_returns(data) else data


class TextLines:
    """The lines of one file; iterate once, over ``(line number from 1, line without its end)``.

    While the last line is yielded, ``unfinished`` means that it has no line end, so it may be cut. A line that is cut
    by damaged compressed data is never yielded. Raises :class:`LimitError` for more lines than ``limits`` allow, a line
    that is too long, or compressed data that expands to too much, and :class:`ReadError` for a file that cannot be
    opened, is empty or contains unreadable compressed data.
    """

    def __init__(self, path: Source, limits: Limits, progress: Progress | None = None) -> None:
        self.path = path
        self.limits = limits
        self.progress = progress
        self.unfinished = False
        self.number = 0  #: of the last yielded line
        self._unpacked: Unpacked | None = None
        self._pieces: Iterator[bytes] = iter(())

    def __iter__(self) -> Iterator[tuple[int, bytes]]:
        with opened(self.path) as file:
            self._unpacked = Unpacked(file, lambda: f"after line {self.number}", self.limits, self.progress)
            self._pieces = iter(self._unpacked)
            rest = yield from self._whole_lines()
            if rest and not self._unpacked.broken:
                self.number += 1
                self.unfinished = True
                yield self.number, rest

    @property
    def broken(self) -> str | None:
        """Damage found in compressed data, such as "The gzip data ends early"; None if there is none."""
        if self._unpacked is None or self._unpacked.broken is None:
            return None
        return f"The {self._unpacked.packing} data {self._unpacked.broken}"

    def is_damaged(self) -> bool:
        """Return whether the compressed data is damaged, which the lines may show before its checksum; reads it to the
        end.

        To be called while the lines are read; no more of them are yielded then.
        """
        try:
            for _ in self._pieces:
                pass
        except LimitError:
            return False
        return self._unpacked is not None and self._unpacked.broken == "is damaged"

    def _whole_lines(self) -> Generator[tuple[int, bytes], None, bytes]:
        """Yield the lines that have an end; return what follows the last of them."""
        rest: bytes | None = None
        end = b"\n"
        for piece in self._pieces:
            if rest is None:
                begun = piece.removeprefix(BOM)
                end = b"\r" if ends_in_returns(begun) else b"\n"
            else:
                begun = rest + piece
            lines = begun.split(end)
            rest = lines.pop()
            if self.number + len(lines) > self.limits.max_lines:
                raise LimitError(
                    "log.too_many_lines", f"The log has more lines than the limit of {self.limits.max_lines}."
                )
            for line in lines:
                self.number += 1
                if len(line) > self.limits.max_line_bytes:
                    if self.is_damaged():
                        return b""
                    raise self._line_too_long(self.number)
                yield self.number, line
            if len(rest) > self.limits.max_line_bytes:
                if self.is_damaged():
                    return b""
                raise self._line_too_long(self.number + 1)
        return rest or b""

    def _line_too_long(self, number: int) -> LimitError:
        return LimitError(
            "log.line_too_long",
            f"Line {number} is longer than the limit of {self.limits.max_line_bytes} bytes; this is not a text log.",
        )


def take_lines(
    lines: TextLines, take: Callable[[int, bytes], None], n_scans: Callable[[], int], notes: list[str]
) -> None:
    """Pass every line to ``take`` and append to ``notes`` what is missing at the end of a cut file.

    A file cut by a full disk or a broken download still has valid scans: its last, broken line is ignored if complete
    scans came before it. Otherwise raises :class:`ReadError`.
    """
    for number, text in lines:
        try:
            take(number, text)
        except ReadError:
            if n_scans() and lines.unfinished:
                notes.append(f"The file ends in the middle of line {number}, which is left out.")
            elif n_scans() and lines.is_damaged():
                break
            else:
                raise
        else:
            if lines.unfinished:
                notes.append(
                    f"Line {number}, the last, has no line end: if the file was cut there, so is its last number."
                )
    if lines.broken is None:
        return
    if not n_scans():
        raise ReadError("log.truncated", f"{lines.broken}, after line {lines.number}, before any whole scan.")
    if lines.is_damaged():
        notes.append(
            f"{lines.broken}: what precedes line {lines.number} is read, some of it perhaps wrong, and the rest "
            "is missing."
        )
    else:
        notes.append(f"{lines.broken}, after line {lines.number}: the rest of the log is missing.")
