"""The lines of a text log, plain or packed, read in pieces: neither a bomb nor one huge line fills the memory."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from pathlib import Path

from mapper.errors import LimitError, ReadError
from mapper.limits import Limits
from mapper.logs.unpacking import Progress, Unpacked, opened

BOM = b"\xef\xbb\xbf"  #: what spreadsheets write before the first line of UTF-8 text


class TextLines:
    """The lines of one file; iterate once, over ``(line number from 1, line without its end)``.

    While the last line is handed out ``unfinished`` says that it has no line end: whoever parses it may find it cut.
    ``cut_after`` is afterwards the number of whole lines before the place where packed data, of the kind ``packing``,
    ends too early, or None; the piece of a line that it ends in is never handed out.

    Raises :class:`LimitError` for more lines than ``limits`` allow, or for more bytes, after decompression, in the file
    or in one line, and :class:`ReadError` for a file that cannot be opened, is empty or holds damaged packed data.
    """

    def __init__(self, path: Path, limits: Limits, progress: Progress | None = None) -> None:
        self.path = path
        self.limits = limits
        self.progress = progress
        self.unfinished = False
        self.cut_after: int | None = None
        self.packing: str | None = None
        self.number = 0  #: of the line handed out last

    def __iter__(self) -> Iterator[tuple[int, bytes]]:
        with opened(self.path) as file:
            unpacked = Unpacked(file, lambda: f"after line {self.number}", self.progress)
            rest = yield from self._whole_lines(unpacked)
            if unpacked.cut:
                self.cut_after, self.packing = self.number, unpacked.packing
            elif rest:
                self.number += 1
                self.unfinished = True
                yield self.number, rest

    def _whole_lines(self, pieces: Iterable[bytes]) -> Generator[tuple[int, bytes], None, bytes]:
        """Yield the lines that end; return what follows the last of them."""
        rest = b""
        total = 0
        for piece in pieces:
            begun = rest + piece if total else piece.removeprefix(BOM)
            total += len(piece)
            if total > self.limits.max_log_bytes:
                raise LimitError(
                    "log.too_many_bytes",
                    f"The log is larger than the limit of {self.limits.max_log_bytes} bytes, counted after "
                    f"decompression; {self.number} lines were read.",
                )
            lines = begun.split(b"\n")
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
        return rest

    def _line_too_long(self, number: int) -> LimitError:
        return LimitError(
            "log.line_too_long",
            f"Line {number} is longer than the limit of {self.limits.max_line_bytes} bytes; this is not a text log.",
        )


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
        else:
            if lines.unfinished:
                notes.append(
                    f"Line {number}, the last, has no line end: if the file was cut there, so is its last number."
                )
    if lines.cut_after is None:
        return
    if not n_scans():
        raise ReadError(
            "log.truncated",
            f"The {lines.packing} data ends early, after line {lines.cut_after}, before any whole scan.",
        )
    notes.append(f"The {lines.packing} data ends early, after line {lines.cut_after}: the rest of the log is missing.")
