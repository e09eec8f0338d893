"""Lines of numbers in trajectories and relations: equally many on each, with comments after ``#``.

Programs separate the values by blanks; tables use commas, semicolons or tabs, and in some locales decimal commas. The
first line of numbers determines the variant.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.foreign import TRAJECTORIES, trajectory_format
from mapper.io.logs.text import fields
from mapper.io.logs.text.lines import TextLines

_UNIT = re.compile(r"\s*[\[(](?:s|sec|ns|m|)[\])]$|\s*_(?:s|ns|m)$")  #: unit after a column name


@dataclass(frozen=True, slots=True)
class _Layout:
    """Separator of the values of a line, None for blanks, and whether it has decimal commas."""

    separator: str | None
    has_decimal_commas: bool

    @classmethod
    def of(cls, line: str, count: int) -> _Layout:
        """Return the layout of a line of numbers with at least ``count`` values."""
        if ";" in line:
            return cls(";", "," in line)
        words = line.split()
        if "," in line and len(words) >= count and not any(re.search(",.*,|,$", word) for word in words):
            return cls(None, has_decimal_commas=True)
        return cls("," if "," in line else None, has_decimal_commas=False)

    def split(self, line: str) -> list[str]:
        tokens = line.split() if self.separator is None else line.rstrip(self.separator).split(self.separator)
        tokens = [token.strip(' \t"') for token in tokens]
        return [token.replace(",", ".", 1) for token in tokens] if self.has_decimal_commas else tokens


def rows(
    path: Source, limits: Limits, kind: str, columns: str, synonyms: Mapping[str, str] | None = None
) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the tokens of each line of the file at ``path``, plain or compressed.

    ``columns`` names the values of a line, one word each, and ``kind`` describes the lines in errors. A line before the
    numbers, comment or not, that names all columns by these words or ``synonyms`` may define another order, with
    additional columns. Raises :class:`ReadError`, naming the line, for another number of values, for damaged compressed
    data and for a file that cannot be opened, and :class:`LimitError`.
    """
    lines = TextLines(path, limits)
    names = columns.split()
    order, n_values = list(range(len(names))), len(names)
    layout: _Layout | None = None
    for number, text in lines:
        row = text.decode("latin-1").strip()
        if layout is None:
            named = _columns_named(row, names, synonyms or {})
            if named is not None:
                order, n_values = named
                continue
        if not row or row.startswith("#"):
            continue
        layout = layout or _Layout.of(row, n_values)
        tokens = layout.split(row)
        if len(tokens) != n_values:
            raise ReadError("trajectory.columns", f"Line {number} {_why_not(tokens, text, kind, n_values, columns)}")
        if layout.separator == "," and order == list(range(n_values)):
            _refuse_other_format(number, text, kind)
        yield number, [tokens[column] for column in order]
    if lines.broken is not None:
        raise ReadError("trajectory.truncated", f"{lines.broken}, after line {lines.number}.")


def _columns_named(line: str, columns: Sequence[str], synonyms: Mapping[str, str]) -> tuple[list[int], int] | None:
    """Return the positions of the columns in a line that names them all, and how many it names; None for others."""
    line = line.lstrip("#% ")
    separator = next((sign for sign in ",;\t" if sign in line), None)
    names = [_UNIT.sub("", name.strip(' "').lower()) for name in line.split(separator)]
    names = [synonyms.get(name, name) for name in names]
    if any(names.count(column) != 1 for column in columns):
        return None
    return [names.index(column) for column in columns], len(names)


def _why_not(tokens: Sequence[str], text: bytes, kind: str, n_values: int, columns: str) -> str:
    """Return what a line has instead of ``n_values`` values."""
    has = f"has {len(tokens)} value{'s' if len(tokens) != 1 else ''}"
    if len(tokens) <= 1 or any("," in token or ";" in token for token in tokens):
        has = "has commas or semicolons between its values" if b"," in text or b";" in text else has
    if n_values != len(columns.split()):
        return f"{has}, but the line with the names of the columns has {n_values}."
    other = trajectory_format(text + b"\n")
    why = ""
    if other is not None and other != kind:
        why = f" It is of a trajectory in the format {other}. {TRAJECTORIES[other]}"
    if len(tokens) == n_values - 1:
        why = f" If the {columns.split(maxsplit=1)[0]} is missing, write it before the others."
    return f"{has}, but a {kind} line has {n_values}: {columns}.{why}"


def _refuse_other_format(number: int, text: bytes, kind: str) -> None:
    """Raise :class:`ReadError` for a line with as many values in another trajectory format."""
    other = trajectory_format(text + b"\n")
    if other is not None and other != kind:
        raise ReadError(
            "trajectory.columns",
            f"Line {number} is of a trajectory in the format {other}, not of {kind}. {TRAJECTORIES[other]}",
        )


def stamp_ns(token: str, line: int, kind: str, per_second: float = 1.0) -> int:
    """Return a time as integer nanoseconds, without the precision loss of a float.

    ``per_second`` of the unit in ``token`` are one second. Raises :class:`ReadError` for an invalid time.
    """
    fields.stamp(token, line, kind, per_second)
    return round(Decimal(token) * 10**9 / Decimal(per_second))
