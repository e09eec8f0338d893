"""Any message of a recording as a tree of its fields, decoded with the recording's definition.

To be run in a process with limits, because the definition and the message are untrusted. Every length is compared with
the available bytes, and the numbers of values and levels are limited (:mod:`mapper.io.contents.tree_values`).
"""

from __future__ import annotations

from mapper.io.contents.definitions import DYNAMIC, PRIMITIVES, STRING, TIMES, Definitions, Field
from mapper.io.contents.tree_values import MAX_SHOWN, SHOWN, Tree, check_size, cut_list, cut_text, damaged, plain_number
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields
from mapper.io.logs.ros.ros_messages import plain_type


def tree_of(types: Definitions, kind: str, data: bytes, *, cdr: bool) -> Tree:
    """Return the fields of a message by name.

    An array is a list of its first :data:`SHOWN` elements and a sentence on the rest. Numbers that JSON lacks are the
    strings ``.nan``, ``.inf`` and ``-.inf``, as in YAML. Raises :class:`ReadError` and :class:`LimitError`.
    """
    try:
        decoder = _Decoder(types, MessageFields(data, cdr=cdr))
        tree: Tree = decoder.message(plain_type(kind), 0)
        decoder.fields.end()
    except BadMessageError:
        raise damaged(kind) from None
    return tree


class _Decoder:
    def __init__(self, types: Definitions, fields: MessageFields) -> None:
        self.fields = fields
        self._types = types
        self._values = self._kept = 0
        self._least: dict[str, int] = {}

    def message(self, kind: str, depth: int) -> Tree:
        check_size(self._values, depth)
        own = self._types[kind]
        if not own and self.fields.cdr:
            self.fields.unpack("B", 1)  # IDL has no empty structure, so ROS 2 inserts a byte
        return {field.name: self._field(field.type, field.length, depth) for field in own}

    def _field(self, kind: str, length: int | None, depth: int) -> object:
        if length is None:
            return self._value(kind, depth)
        n = self.fields.count(0) if length == DYNAMIC else length
        least = self._least_bytes(kind, depth)
        if n * least > len(self.fields.data) - self.fields.pos:
            raise BadMessageError
        if kind in PRIMITIVES:
            return cut_list(self._numbers(kind, n), n)
        # The rest is also read, because the next field starts at its end, unless elements have no bytes.
        values: list[object] = []
        for i in range(n if least else min(n, SHOWN)):
            before = self._values
            value = self._value(kind, depth)
            if i < SHOWN and self._kept < MAX_SHOWN:
                values.append(value)
                self._kept += self._values - before
        return cut_list(values, n)

    def _value(self, kind: str, depth: int) -> object:
        self._values += 1
        check_size(self._values, depth)
        if kind in PRIMITIVES:
            return plain_number(self.fields.unpack(*PRIMITIVES[kind])[0])
        if kind == STRING:
            return cut_text(self.fields.string())
        if kind in TIMES:
            return {name: int(self.fields.unpack(*PRIMITIVES[of])[0]) for name, of in TIMES[kind]}
        return self.message(kind, depth + 1)

    def _numbers(self, kind: str, n: int) -> list[object]:
        """Return the first of ``n`` numbers, and continue after the last."""
        code, size = PRIMITIVES[kind]
        fields = self.fields
        if n == 0:
            return []
        shown = min(n, SHOWN)
        self._values += shown
        check_size(self._values, 0)
        values = fields.unpack(f"{shown}{code}", size)
        fields.pos += (n - shown) * size
        if fields.pos > len(fields.data):
            raise BadMessageError
        return [plain_number(value) for value in values]

    def _least_bytes(self, kind: str, depth: int) -> int:
        """Return the minimum size in bytes of a value of a type."""
        if kind in PRIMITIVES:
            return PRIMITIVES[kind][1]
        if kind == STRING:
            return 4
        if kind in TIMES:
            return 8
        if kind not in self._least:
            check_size(0, depth)
            self._least[kind] = 0  # for a type that contains itself
            own = self._types[kind]
            self._least[kind] = sum(self._least_of(field, depth + 1) for field in own) if own else int(self.fields.cdr)
        return self._least[kind]

    def _least_of(self, field: Field, depth: int) -> int:
        if field.length == DYNAMIC:
            return 4
        return (1 if field.length is None else field.length) * self._least_bytes(field.type, depth)
