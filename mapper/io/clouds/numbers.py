"""Tables of numbers in text, with equally many on each line."""

from __future__ import annotations

import io
import re

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.names import printable

_ROW = re.compile(r" at row (\d+)")
CONTENT = re.compile(rb"^[ \t]*[^#\s]", re.MULTILINE)  #: a line with more than a comment

_FORTRAN = re.compile(rb"(?<=[\d.])[dD](?=[-+]?\d+(?![\w.]))")  #: before the exponent of a double-precision number
#: Written instead of a number by C on Windows, spreadsheets, databases, R and Python.
_NOTHING = re.compile(rb"(?<![^\s,;|])(?:[-+]?nan\([^)\s]*\)|#?N/A|NA|NULL|null|None|none)(?![^\s,;|])")
_SIGNS_OF_NOTHING = (b"nan(", b"N/A", b"NA", b"NULL", b"null", b"one")
_WINDOWS = re.compile(rb"[-+]?1\.#\w+")  #: ``1.#QNAN``, ``-1.#IND``, ``1.#INF``, written by C on Windows until 2015


def as_python_writes(text: bytes) -> bytes:
    """Return a text with its numbers in Python's notation: Fortran's ``1.0D+02``, and ``1.#QNAN`` of C on Windows.

    Non-finite numbers become ``nan``, as do words for missing numbers: ``-nan(ind)``, ``NA``, ``NULL``, ``None``.
    """
    if any(sign in text for sign in _SIGNS_OF_NOTHING):
        text = _NOTHING.sub(b"nan", text)
    if b"D" in text or b"d" in text:
        text = _FORTRAN.sub(b"e", text)
    return _WINDOWS.sub(b"nan", text) if b".#" in text else text


def table(
    text: bytes, separator: str | None, n: int | None, columns: int | None, limits: Limits, first_line: int = 1
) -> NDArray[np.float64]:
    """Return the numbers of ``text`` (rows, columns), including ``nan`` and ``inf``; empty lines and ``#`` comments are
    skipped.

    ``separator`` is a character, or None for blanks. ``n`` is the expected number of rows, None if unknown; there may
    be fewer if the file ends early, and an incomplete last line is then ignored. ``columns`` is the required number of
    columns, None for any; ``first_line`` is the line number of the text's start in its file. Raises :class:`ReadError`
    for a token that is not a number and another number of values; :class:`LimitError` for too many.
    """
    most = limits.max_points
    text = as_python_writes(text)
    if n is not None and not text.endswith(b"\n") and text.count(b"\n") < n:
        lines = text.count(b"\n") + 1
        last = text[text.rfind(b"\n") + 1 :].split(separator.encode() if separator else None)
        if lines < n or (columns is not None and len(last) != columns):
            text = text[: text.rfind(b"\n") + 1]
    if n is None and text.count(b"\n") > most:
        raise LimitError("cloud.too_many_points", f"The file holds more lines than the limit of {most} points.")
    if CONTENT.search(text) is None:
        rows = np.zeros((0, columns or 0))
    else:
        try:
            rows = np.loadtxt(io.BytesIO(text), delimiter=separator, ndmin=2, comments="#", encoding="latin-1")
        except (ValueError, OverflowError) as error:
            raise ReadError("cloud.numbers", _message(str(error), first_line)) from error
    if columns is not None and len(rows) and rows.shape[1] != columns:
        raise ReadError(
            "cloud.numbers", f"The points have {rows.shape[1]} numbers each, but the header says {columns}."
        )
    return rows[:n] if n is not None else rows


def _message(error: str, first_line: int) -> str:
    """Return NumPy's message on a row as a sentence with the line in the file, not counting comments and empty
    lines.
    """
    match = _ROW.search(error)
    where = f"near line {int(match.group(1)) + first_line}" if match else "in the points"
    if "columns changed" in error or "number of columns" in error:
        return f"The number of values changes {where}: all points must have as many."
    word = error.split("'")[1] if error.count("'") > 1 else ""
    return f"{printable(word[:40])!r} {where} is not a number." if word else f"A value {where} is not a number."
