"""Conversion of the fields of a text log's line to numbers, with errors that name the line."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.core.time_units import EPOCH_S, UNITS

MAX_STAMP = 9e9  #: seconds: later times in nanoseconds do not fit into 64 bits
_INFINITE = ("inf", "infinity")
_LIST = msgspec.json.Decoder(list[float])


def numbers(tokens: Sequence[str], line: int, word: str) -> list[float]:
    """Return ``tokens`` as numbers, including ``nan`` and ``inf``. Raises :class:`ReadError` naming an invalid one."""
    try:
        values = list(map(float, tokens))
    except ValueError:
        values = []
    if not values and tokens:
        bad = next(token for token in tokens if not is_number(token))
        comma = " with a decimal point" if is_number(bad.replace(",", ".", 1)) else ""
        raise ReadError("log.not_a_number", f"Line {line}: {bad!r:.40} in this {word} line is not a number{comma}.")
    # The sum of finite numbers is finite, unless they are huge, and is fast to compute.
    if not math.isfinite(sum(values)) and (math.inf in values or -math.inf in values):
        for token, value in zip(tokens, values, strict=True):
            if math.isinf(value) and token.lower().lstrip("+-") not in _INFINITE:
                raise ReadError("log.not_a_number", f"Line {line}: {token!r:.40} in this {word} line is too large.")
    if "_" in "".join(tokens):  # Python accepts 1_000 as a number; logs do not use it
        bad = next(token for token in tokens if "_" in token)
        raise ReadError("log.not_a_number", f"Line {line}: {bad!r:.40} in this {word} line is not a number.")
    return values


def listed(text: bytes) -> list[float] | None:
    """Return the numbers in ``text``, separated by single spaces; None unless they are valid in a JSON list.

    :func:`numbers` accepts more than this and explains errors; this is twice as fast.
    """
    try:
        return _LIST.decode(b"[" + text.replace(b" ", b",") + b"]")
    except msgspec.DecodeError:
        return None


def is_number(token: str) -> bool:
    """Return whether ``token`` is a number, including ``nan`` and ``inf``."""
    try:
        float(token)
    except ValueError:
        return False
    return True


def pose(
    tokens: Sequence[str], line: int, word: str, whose: str, limits: Limits, farthest: float | None = None
) -> list[float]:
    """Return three tokens as a pose (x, y, theta). Raises :class:`ReadError` if it is not finite or too far away.

    The limit is ``max_pose``, or ``farthest`` metres if coordinates may be georeferenced.
    """
    x, y, theta = values = numbers(tokens, line, word)
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(theta)):
        raise ReadError("log.pose", f"Line {line}: {whose} pose in this {word} line is not finite: {x}, {y}, {theta}.")
    farthest = farthest or limits.max_pose
    if max(abs(x), abs(y)) > farthest or abs(theta) > limits.max_pose:
        raise ReadError(
            "log.pose",
            f"Line {line}: {whose} pose in this {word} line, {x:g}, {y:g}, {theta:g}, lies beyond {farthest:g}.",
        )
    return values


def stamp(token: str, line: int, word: str, per_second: float = 1.0) -> float:
    """Return a time in seconds; ``per_second`` of the unit in ``token`` are one second.

    Raises :class:`ReadError` for one that is not finite or an impossible time.
    """
    (value,) = numbers((token,), line, word)
    if not abs(value) < MAX_STAMP * per_second:
        unit = _unit_of(value)
        hint = unit and f" It would be one in {unit[1]}: divide the log’s times by {unit[0]:,.0f} to have seconds."
        raise ReadError(
            "log.stamp", f"Line {line}: the time {token!r:.40} of this {word} line is impossible.{hint or ''}"
        )
    return value / per_second


def time_unit(first: str, line: int, word: str) -> tuple[float, list[str]]:
    """Return how many of the unit of a file's times, of which ``first`` is one, are a second, and a note if not one.

    A unit other than seconds is assumed if ``first`` cannot be seconds and is a time since 1970 in that unit. Raises
    :class:`ReadError` if it is not a number.
    """
    unit = _unit_of(numbers((first,), line, word)[0])
    if unit is None:
        return 1.0, []
    return unit[0], [f"The times are {unit[1]} since 1970, where the format has seconds: they are converted."]


def _unit_of(value: float) -> tuple[float, str] | None:
    """Return the sub-second unit in which a number is a time since 1970, and its count per second; None if there is
    none.
    """
    return next((unit for unit in UNITS if EPOCH_S[0] < value / unit[0] < EPOCH_S[1]), None)


def count(token: str, line: int, word: str, what: str, largest: int, *, least: int = 1) -> int:
    """Return a count. Raises :class:`ReadError` unless it is an integer ≥ ``least``."""
    if not (token.isascii() and token.isdigit()) or len(token) > 9 or int(token) < least:
        raise ReadError(
            "log.beam_count",
            f"Line {line}: this {word} line states {token!r:.40} as the number of {what}, which is impossible.",
        )
    if int(token) > largest:
        raise LimitError(
            "log.too_many_beams", f"Line {line}: this {word} line states {token} {what}; the limit is {largest}."
        )
    return int(token)


def require_fields(tokens: Sequence[str], between: tuple[int, int], line: int, word: str, stated: str) -> None:
    """Raise :class:`ReadError` unless a line has as many tokens as ``between`` allows; ``stated`` is the reason.

    CARMEN lines end with ``stamp host logger_stamp``. A line that still has its host, which is not a number, is
    complete and has the maximum number of tokens, so another number of them means that the stated count is wrong.
    """
    (needed, most), n = between, len(tokens)
    whole = n > 3 and not is_number(tokens[-2]) and is_number(tokens[-1])
    if n == most or (needed <= n < most and not whole):
        return
    if whole or n > most:
        raise ReadError(
            "log.beam_count",
            f"Line {line}: this {word} line states {stated}, which makes {most} fields, but it has {n}.",
        )
    raise ReadError(
        "log.truncated_line",
        f"Line {line}: this {word} line ends early: it states {stated} and needs {needed} fields, but has {n}.",
    )
