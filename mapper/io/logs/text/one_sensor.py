"""Reading of text logs that have one sensor."""

from __future__ import annotations

from typing import Protocol

from mapper.core.errors import ReadError
from mapper.io.logs.text.lines import TextLines, take_lines
from mapper.io.logs.text.packing import ScanStack


class LineReader(Protocol):
    """A reader of the lines of one format, which collects their scans."""

    stack: ScanStack

    def take(self, line: int, text: bytes) -> None:
        """Read one line, numbered from 1. Raises :class:`ReadError` or :class:`LimitError` naming it."""


def take_one_sensor(reader: LineReader, lines: TextLines, topic: str | None, log: str, missing: str = "") -> list[str]:
    """Give all lines of a log with one sensor to ``reader``; return notes on its end, as :func:`take_lines`.

    ``log`` names a log of the format in errors ("A CMU log"), and ``missing`` the lines without which it has no scans.
    Raises :class:`ReadError` if a ``topic`` is requested, for a line that cannot be read and for a log without scans,
    and :class:`LimitError`.
    """
    if topic is not None:
        raise ReadError("log.topic", f"{log} has one sensor and no topic {topic!r:.80}.")
    notes: list[str] = []
    take_lines(lines, reader.take, lambda: reader.stack.n_scans, notes)
    if not reader.stack.n_scans:
        raise ReadError("log.no_scans", f"The log holds no scans{missing and ': '}{missing}.")
    return notes
