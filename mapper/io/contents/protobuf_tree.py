"""Any Protocol Buffers message as a tree of its fields, decoded with the recording's file descriptors.

To be run in a process with limits, like :mod:`mapper.io.contents.message_tree`. An enumeration is shown as its number,
a map as a list of keys and values. Source: google/protobuf/descriptor.proto; mcap.dev/spec/registry (schemas of kind
``protobuf``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from mapper.core.errors import ReadError
from mapper.io.contents.definitions import MAX_BYTES, MAX_FIELDS
from mapper.io.contents.tree_values import MAX_SHOWN, SHOWN, Tree, check_size, cut_list, cut_text, damaged, plain_number
from mapper.io.logs.ros.message_fields import BadMessageError
from mapper.io.logs.ros.protobuf import FIXED, VARYING, Field, Table, bytes_of, decoded, numbers, wire_fields

#: Types of FieldDescriptorProto → kinds of fields. Groups, which proto2 deprecated, are not supported.
_KINDS = {
    1: "double", 2: "float", 3: "int", 4: "uint", 5: "int", 6: "fixed64", 7: "fixed32", 8: "bool", 9: "string",
    12: "bytes", 13: "uint", 14: "int", 15: "sfixed32", 16: "sfixed64", 17: "sint", 18: "sint",
}  # fmt: skip
_MESSAGE_TYPE = 11
_REPEATED = 3  #: a label
_FIELD = {
    1: Field("name", "string"),
    3: Field("number", "int"),
    4: Field("label", "int"),
    5: Field("type", "int"),
    6: Field("type_name", "string"),
    9: Field("oneof_index", "int"),
}
_MESSAGE: dict[int, Field] = {1: Field("name", "string"), 2: Field("field", _FIELD, repeated=True)}
_MESSAGE[3] = Field("nested_type", _MESSAGE, repeated=True)
_FILE = {
    2: Field("package", "string"),
    4: Field("message_type", _MESSAGE, repeated=True),
    12: Field("syntax", "string"),
}
_FILES = {1: Field("file", _FILE, repeated=True)}

_Stated = Mapping[str, Any]  #: a descriptor


def table_of(kind: str, definition: bytes) -> Table:
    """Return the fields of the message ``kind``, such as ``package.Type``, of a serialised FileDescriptorSet.

    Raises :class:`ReadError` for an invalid set, one with undefined types, or one that is too large.
    """
    if len(definition) > MAX_BYTES:
        raise ReadError("message.definition", f"The definition of {kind!r:.100} has more than {MAX_BYTES} bytes.")
    try:
        files = decoded(definition, _FILES).get("file", ())
    except BadMessageError:
        raise ReadError("message.definition", f"The definition of {kind!r:.100} is no set of descriptors.") from None
    stated: dict[str, tuple[list[_Stated], bool]] = {}
    for file in files:
        package = file.get("package", "")
        _collect(f".{package}" if package else "", file.get("message_type", ()), file.get("syntax") == "proto3", stated)
    if sum(len(fields) for fields, _ in stated.values()) > MAX_FIELDS:
        raise ReadError("message.definition", f"The definition of {kind!r:.100} has over {MAX_FIELDS} fields.")
    tables: dict[str, dict[int, Field]] = {name: {} for name in stated}
    for name, (fields, is_proto3) in stated.items():
        for field in fields:
            tables[name][field.get("number", 0)] = _field(name, field, tables, is_proto3=is_proto3)
    if f".{kind}" not in tables:
        raise ReadError("message.definition", f"The recording does not define the type {kind!r:.100}.")
    return tables[f".{kind}"]


def _collect(
    scope: str, messages: Iterable[_Stated], is_proto3: bool, stated: dict[str, tuple[list[_Stated], bool]]
) -> None:
    for message in messages:
        name = f"{scope}.{message.get('name', '')}"
        stated[name] = message.get("field", []), is_proto3
        _collect(name, message.get("nested_type", ()), is_proto3, stated)


def _field(message: str, stated: _Stated, tables: Mapping[str, Table], *, is_proto3: bool) -> Field:
    name, number = stated.get("name", ""), stated.get("type", 0)
    kind = tables.get(stated.get("type_name", "")) if number == _MESSAGE_TYPE else _KINDS.get(number)
    if kind is None:
        of = stated.get("type_name") or f"the type {number}"
        where = f"{message[1:]}.{name} is of {of}"
        raise ReadError("message.definition", f"The recording does not define every type: {where:.200}.")
    is_repeated = stated.get("label") == _REPEATED
    # proto3 omits a zero, except for a field marked optional, or in a oneof.
    is_implied = is_proto3 and "oneof_index" not in stated and number != _MESSAGE_TYPE
    return Field(name, kind, is_repeated, implied=is_repeated or is_implied)


def tree_of_protobuf(kind: str, table: Table, data: bytes) -> Tree:
    """Return the fields of a message by name, like :func:`mapper.io.contents.message_tree.tree_of`.

    Raises :class:`ReadError` and :class:`LimitError`.
    """
    try:
        return _Decoder().message(data, table, 0)
    except BadMessageError:
        raise damaged(kind) from None


class _Decoder:
    def __init__(self) -> None:
        self._values = self._kept = 0

    def message(self, data: bytes, table: Table, depth: int) -> Tree:
        check_size(self._values, depth)
        fields: dict[str, object] = {}
        lists: dict[str, list[object]] = {}
        counts: dict[str, int] = {}
        for number, wire, value in wire_fields(data):
            self._values += 1
            check_size(self._values, depth)
            field = table.get(number)
            if field is None:
                continue
            if not field.repeated:
                if shown := self._shown(field, wire, value, depth, SHOWN)[0]:
                    fields[field.name] = shown[-1]
                continue
            values = lists.setdefault(field.name, [])
            room = max(0, SHOWN - len(values)) if self._kept < MAX_SHOWN else 0
            shown, n = self._shown(field, wire, value, depth, room)
            self._kept += len(shown)
            values += shown
            counts[field.name] = counts.get(field.name, 0) + n
        tree: Tree = {}
        for field in table.values():
            if field.repeated:
                tree[field.name] = cut_list(lists.get(field.name, []), counts.get(field.name, 0))
            elif field.name in fields:
                tree[field.name] = fields[field.name]
            elif field.implied:
                tree[field.name] = _zero(field.kind)
        return tree

    def _shown(self, field: Field, wire: int, value: int | bytes, depth: int, most: int) -> tuple[list[object], int]:
        """Return the first ``most`` values of a field, and the total number."""
        kind = field.kind
        if not isinstance(kind, str):
            raw = bytes_of(value)
            return [self.message(raw, kind, depth + 1)] if most else [], 1
        if kind in FIXED or kind in VARYING:
            values, n = numbers(kind, wire, value, most)
            return [plain_number(number) for number in values], n
        raw = bytes_of(value)
        is_text = kind == "string"
        content: object = cut_text(raw.decode("utf-8", "replace")) if is_text else cut_list(list(raw[:SHOWN]), len(raw))
        return [content][:most], 1


def _zero(kind: str | Table) -> object:
    if kind in ("double", "float"):
        return 0.0
    return {"string": "", "bytes": [], "bool": False}.get(str(kind), 0)
