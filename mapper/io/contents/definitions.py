"""Parser of message definitions in a recording, as text: the fields of a type, in order.

Source: the ROS wiki's page on msg, docs.ros.org's "About ROS interfaces" (bounds, defaults, constants). The text starts
with the type itself; each type that it uses follows after a line of ``=`` and ``MSG: package/Type``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from mapper.core.errors import ReadError
from mapper.io.logs.ros.ros_messages import plain_type

MAX_BYTES = 1 << 18  #: of one definition: ten times those of the largest types in use
MAX_FIELDS = 4000  #: of all types in total
DYNAMIC = -1  #: length of an array whose size is in the message

#: Type → :mod:`struct` code and size in bytes. ``char`` and ``byte`` are uint8, as both versions of ROS serialise them.
PRIMITIVES: dict[str, tuple[str, int]] = {
    "bool": ("?", 1), "byte": ("B", 1), "char": ("B", 1),
    "int8": ("b", 1), "uint8": ("B", 1), "int16": ("h", 2), "uint16": ("H", 2),
    "int32": ("i", 4), "uint32": ("I", 4), "int64": ("q", 8), "uint64": ("Q", 8),
    "float32": ("f", 4), "float64": ("d", 8),
}  # fmt: skip
STRING = "string"
#: Built-in types of ROS 1: names and types of their two numbers.
TIMES: dict[str, tuple[tuple[str, str], tuple[str, str]]] = {
    "time": (("secs", "uint32"), ("nsecs", "uint32")),
    "duration": (("secs", "int32"), ("nsecs", "int32")),
}

_FIELD = re.compile(r"(\S+)\s+([A-Za-z]\w*)\s*(=?)")
_TYPE = re.compile(r"([\w/]+)(?:<=\d+)?(?:\[(?:<=\d+|(\d*))\])?")


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a message. ``length`` is None for a single value, :data:`DYNAMIC`, or the length of a fixed array."""

    name: str
    type: str
    length: int | None


Definitions = dict[str, tuple[Field, ...]]  #: ``package/Type`` → its fields


def definitions_of(kind: str, text: str) -> Definitions:
    """Return the fields of the type ``kind`` and of all types named in its definition.

    Raises :class:`ReadError` for an invalid text, or one with an undefined type.
    """
    if len(text) > MAX_BYTES:
        raise ReadError("message.definition", f"The definition of {kind!r:.100} has more than {MAX_BYTES} characters.")
    kind = plain_type(kind)
    definitions: Definitions = {}
    count = 0
    for number, section in enumerate(re.split(r"^=+\s*$", text, flags=re.MULTILINE)):
        lines = section.strip().splitlines()
        name = kind
        if number:
            if not lines or not lines[0].startswith("MSG:"):
                continue  # an IDL of the same type, or nothing
            name = plain_type(lines.pop(0)[4:].strip())
        package = name.partition("/")[0]
        own = [parsed for line in lines if (parsed := _field(line, package)) is not None]
        count += len(own)
        if count > MAX_FIELDS:
            raise ReadError("message.definition", f"The definition of {kind!r:.100} has over {MAX_FIELDS} fields.")
        definitions[name] = tuple(own)
    for name, fields in definitions.items():
        for field in fields:
            if field.type not in definitions and field.type not in PRIMITIVES and field.type not in (STRING, *TIMES):
                where = f"{name}.{field.name} is of type {field.type}"
                raise ReadError("message.definition", f"The recording does not define every type: {where:.200}.")
    return definitions


def _field(line: str, package: str) -> Field | None:
    """Return the field in a line; None for a constant, a comment or an empty line."""
    line = line.split("#", 1)[0].strip()
    if not line:
        return None
    match = _FIELD.match(line)
    kind = None if match is None else _TYPE.fullmatch(match[1])
    if match is None or kind is None:
        raise ReadError(
            "message.definition", f"The recording’s definition has the line {line!r:.100}, which is not a definition."
        )
    if match[3]:
        return None
    base = kind[1]
    if base == "Header":
        base = "std_msgs/Header"
    elif base not in PRIMITIVES and base not in (STRING, *TIMES):
        base = plain_type(base) if "/" in base else f"{package}/{base}"
    is_array = "[" in match[1]
    length = (int(kind[2]) if kind[2] else DYNAMIC) if is_array else None
    return Field(match[2], base, length)
