"""The values of messages as trees: how many there may be, and how arrays, texts and numbers are shown."""

from __future__ import annotations

import math
from typing import Any

from mapper.core.errors import LimitError, ReadError

MAX_DEPTH = 24  #: types within types: those in use have a third of it
MAX_VALUES = 1_000_000  #: that are read of one message
MAX_SHOWN = 20_000  #: values in the tree, from which on arrays are no longer shown
SHOWN = 128  #: elements of an array that are in the tree, as ``ros2 topic echo`` shows them
SHOWN_CHARACTERS = 4000
EXACT = 1 << 53  #: whole numbers beyond are texts: programs that read JSON round them

Tree = dict[str, Any]


def damaged(kind: str) -> ReadError:
    """Return the error that the bytes of a message are none of its type."""
    message = f"The message is no {kind} as the recording defines it"
    return ReadError("message.damaged", f"{message:.200}.")


def check_size(values: int, depth: int, most: int = MAX_VALUES) -> None:
    """Raise :class:`LimitError` for a message that has more values than ``most``, or too many levels."""
    if values > most:
        raise LimitError("message.too_large", f"The message has more than {most} values.")
    if depth > MAX_DEPTH:
        raise LimitError("message.too_deep", f"The message’s types are nested more than {MAX_DEPTH} deep.")


def cut_list(values: list[object], n: int) -> list[object]:
    """Return the elements of an array of ``n`` that are kept, and a sentence on the rest."""
    return values if n <= len(values) else [*values, f"… {n - len(values):,} more"]


def cut_text(value: str) -> str:
    """Return a text, of a long one its beginning."""
    return value if len(value) <= SHOWN_CHARACTERS else f"{value[:SHOWN_CHARACTERS]} … {len(value):,} characters"


def plain_number(value: object) -> object:
    """Return a number as JSON can have it: as a text where JSON has none, or its readers would round it."""
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0.0 else "-.inf"
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > EXACT:
        return str(value)
    return value
