"""Values in trees of messages: limits, and the display of arrays, texts and numbers."""

from __future__ import annotations

import math
from typing import Any

from mapper.core.errors import LimitError, ReadError

MAX_DEPTH = 24  #: nested types: three times the depth of those in use
MAX_VALUES = 1_000_000  #: values read from one message
MAX_SHOWN = 20_000  #: values in the tree, above which arrays are no longer shown
SHOWN = 128  #: elements of an array shown, as in ``ros2 topic echo``
SHOWN_CHARACTERS = 4000
EXACT = 1 << 53  #: larger integers are strings, because JSON readers round them

Tree = dict[str, Any]


def damaged(kind: str) -> ReadError:
    """Return the error for bytes that are not a message of its type."""
    message = f"The message is no {kind} as the recording defines it"
    return ReadError("message.damaged", f"{message:.200}.")


def check_size(values: int, depth: int, most: int = MAX_VALUES) -> None:
    """Raise :class:`LimitError` for a message with more values than ``most``, or too many levels."""
    if values > most:
        raise LimitError("message.too_large", f"The message has more than {most} values.")
    if depth > MAX_DEPTH:
        raise LimitError("message.too_deep", f"The message’s types are nested more than {MAX_DEPTH} deep.")


def cut_list(values: list[object], n: int) -> list[object]:
    """Return the stored elements of an array of ``n``, and a sentence on the rest."""
    return values if n <= len(values) else [*values, f"… {n - len(values):,} more"]


def cut_text(value: str) -> str:
    """Return a text, or the beginning of a long one."""
    return value if len(value) <= SHOWN_CHARACTERS else f"{value[:SHOWN_CHARACTERS]} … {len(value):,} characters"


def plain_number(value: object) -> object:
    """Return a number for JSON, as a string if JSON lacks it or its readers would round it."""
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0.0 else "-.inf"
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > EXACT:
        return str(value)
    return value
