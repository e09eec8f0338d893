"""Any message in JSON as a tree of its fields, which it names itself.

For a process with limits, as :mod:`mapper.io.contents.message_tree`. Source: RFC 8259; mcap.dev/spec/registry.
"""

from __future__ import annotations

import json

from mapper.core.errors import LimitError
from mapper.io.contents.tree_values import (
    MAX_DEPTH,
    MAX_SHOWN,
    SHOWN,
    Tree,
    check_size,
    cut_list,
    cut_text,
    damaged,
    plain_number,
)

MAX_BYTES = 1 << 24  #: of one message: as objects of Python it may take thirty times as much memory


def tree_of_json(kind: str, data: bytes) -> Tree:
    """Return the fields of a message by name, as :func:`mapper.io.contents.message_tree.tree_of` does.

    Raises :class:`ReadError` and :class:`LimitError`.
    """
    if len(data) > MAX_BYTES:
        raise LimitError("message.too_large", f"The message has more than {MAX_BYTES} bytes of JSON.")
    try:
        value = json.loads(data)
    except RecursionError:
        raise LimitError("message.too_deep", f"The message is nested more than {MAX_DEPTH} deep.") from None
    except ValueError:
        raise damaged(kind) from None
    if not isinstance(value, dict):
        raise damaged(kind)
    return _Cutter().tree(value, 0)


class _Cutter:
    def __init__(self) -> None:
        self._values = 0

    def tree(self, value: dict[str, object], depth: int) -> Tree:
        check_size(0, depth)
        return {_text(name): self._value(part, depth) for name, part in value.items()}

    def _value(self, value: object, depth: int) -> object:
        self._values += 1
        check_size(self._values, depth, MAX_SHOWN)
        if isinstance(value, dict):
            return self.tree(value, depth + 1)
        if isinstance(value, list):
            shown = value[:SHOWN] if self._values < MAX_SHOWN // 2 else []  # the rest is for what follows
            return cut_list([self._value(one, depth + 1) for one in shown], len(value))
        return _text(value) if isinstance(value, str) else plain_number(value)


def _text(value: str) -> str:
    return cut_text(value.encode("utf-8", "replace").decode())  # JSON can name halves of characters, alone no text
