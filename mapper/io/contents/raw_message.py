"""One message of a recording as a tree: the newest of a topic at a time.

A JSON message names its fields itself. Source: RFC 8259; mcap.dev/spec/registry.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.contents.definitions import Definitions, definitions_of
from mapper.io.contents.idl import definitions_in_idl
from mapper.io.contents.message_tree import tree_of
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
from mapper.io.logs.ros.ros_messages import plain_type

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
