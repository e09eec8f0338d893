"""One message of a recording as a tree of its fields: the newest of a topic at a time.

It is decoded with the recording's definition; a JSON message names its fields itself. Source: RFC 8259;
mcap.dev/spec/registry. To be run in a process with limits, because the definition and the message are untrusted. Every
length is compared with the available bytes, and the numbers of values and levels are limited
(:mod:`mapper.io.contents.tree_values`).
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.contents.definitions import DYNAMIC, PRIMITIVES, STRING, TIMES, Definitions, Field, definitions_of
from mapper.io.contents.idl import definitions_in_idl
from mapper.io.contents.protobuf_tree import table_of, tree_of_protobuf
from mapper.io.contents.seeking import Stated, message_at, stated_in
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
from mapper.io.logs.containers import mcap_file
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


MAX_BYTES = 1 << 24  #: of one message: as Python objects it may need thirty times the memory


def tree_of_json(kind: str, data: bytes) -> Tree:
    """Return the fields of a message by name, like :func:`mapper.io.contents.message_tree.tree_of`.

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
            shown = value[:SHOWN] if self._values < MAX_SHOWN // 2 else []  # reserve the rest for what follows
            return cut_list([self._value(item, depth + 1) for item in shown], len(value))
        return _text(value) if isinstance(value, str) else plain_number(value)


def _text(value: str) -> str:
    return cut_text(value.encode("utf-8", "replace").decode())  # JSON can name halves of characters, alone no text


Decoder = Callable[[bytes], Tree]
#: Kinds of ROS definitions → their parsers.
_TEXTS: dict[str, Callable[[str, str], Definitions]] = {
    "ros1msg": definitions_of,
    "ros2msg": definitions_of,
    "ros2idl": definitions_in_idl,
}


@dataclass(frozen=True, slots=True)
class RawMessage:
    """A message: its type, recording time, size, and fields."""

    type: str
    stamp_ns: int
    bytes: int
    tree: Tree


def raw_message(path: Path, topic: str, at_ns: int, limits: Limits = DEFAULT_LIMITS) -> RawMessage:
    """Return the newest message of ``topic`` recorded at or before ``at_ns``; before the first, the first.

    Raises :class:`ReadError` if there is none, or if it cannot be read with the recording's definition of its type, and
    :class:`LimitError`.
    """
    message = message_at(path, topic, at_ns, limits, as_recorded=True)
    decode = decoder_of(topic, stated_in(path, (topic,), limits).get(topic))
    return RawMessage(message.type, message.stamp_ns, len(message.data), decode(message.data))


def decoder_of(topic: str, stated: Stated | None) -> Decoder:
    """Return a function that converts a message on a topic to a tree, using the recording's definition.

    Raises :class:`ReadError` if there is no definition, or one of an unsupported kind, and :class:`LimitError`; so does
    the function for a message that does not match.
    """
    if stated is None or not (stated.definition.strip() or stated.message_encoding == "json"):
        raise ReadError(
            "message.no_definition",
            f"The recording does not define the type of {topic!r:.200}: bags before ROS 2 Iron and files without an "
            "index do not.",
        )
    kind = plain_type(stated.type)
    if stated.message_encoding == "json":  # names its fields itself
        return partial(tree_of_json, kind)
    form = stated.message_encoding, stated.definition_encoding
    if form == ("protobuf", "protobuf"):
        return partial(tree_of_protobuf, kind, table_of(kind, stated.definition))
    if form[0] not in mcap_file.ENCODINGS or form[1] not in _TEXTS:
        raise ReadError(
            "message.encoding",
            f"Messages in {form[0]!r:.40} with definitions of the kind {form[1]!r:.40} are not read: those of ROS with "
            "ros1msg, ros2msg and ros2idl are, and json and protobuf.",
        )
    types = _TEXTS[form[1]](kind, stated.definition.decode("utf-8", "replace"))
    return partial(tree_of, types, kind, cdr=mcap_file.ENCODINGS[form[0]])
