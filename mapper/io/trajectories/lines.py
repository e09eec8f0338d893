"""The lines of numbers that trajectories and relations are: as many on each, blanks between, ``#`` before remarks."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.foreign import TRAJECTORIES, trajectory_format
from mapper.io.logs.text import fields
from mapper.io.logs.text.lines import TextLines


def rows(path: Source, limits: Limits, kind: str, columns: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the tokens of each line of the file at ``path``, plain or packed.

    ``columns`` names the values of a line, one word each, and ``kind`` says whose line it is, for the errors. Raises
    :class:`ReadError`, naming the line, for another number of values, for packed data that is damaged and for a file
    that cannot be opened, and :class:`LimitError`.
    """
    lines = TextLines(path, limits)
    wanted = len(columns.split())
    for number, text in lines:
        tokens = text.decode("latin-1").split()
        if not tokens or tokens[0].startswith("#") or (number == 1 and tokens == columns.split()):
            continue
        if len(tokens) != wanted:
            other = trajectory_format(text + b"\n")
            has = f"has {len(tokens)} value{'s' if len(tokens) != 1 else ''}"
            if b"," in text or b";" in text:
                has = "has commas or semicolons between its values"
            why = "" if other is None else f" It is of a trajectory in the format {other}. {TRAJECTORIES[other]}"
            raise ReadError(
                "trajectory.columns", f"Line {number} {has}, but a {kind} line has {wanted}: {columns}.{why}"
            )
        yield number, tokens
    if lines.broken is not None:
        raise ReadError("trajectory.truncated", f"{lines.broken}, after line {lines.number}.")


def stamp_ns(token: str, line: int, kind: str, per_second: float = 1.0) -> int:
    """Return a time as nanoseconds, to the last digit, which a float would not keep.

    ``per_second`` of the unit in ``token`` are a second. Raises :class:`ReadError` for an invalid time.
    """
    fields.stamp(token, line, kind, per_second)
    return round(Decimal(token) * 10**9 / Decimal(per_second))
