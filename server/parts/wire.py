"""All commands and messages of a session's stream, common ones and those of the parts, and decoding of commands."""

from __future__ import annotations

import json
import re
from functools import reduce
from operator import or_
from typing import Any

import msgspec
from msgspec import Struct

from server.parts import stated
from server.stream import commands, messages
from server.stream.protocol import MAX_COMMAND_BYTES, ProtocolError

COMMANDS: tuple[type[Struct], ...] = (
    *commands.COMMANDS,
    *(struct for of in stated("messages", "COMMANDS") for struct in of),
)
MESSAGES: tuple[type[Struct], ...] = (
    *messages.MESSAGES,
    *(struct for of in stated("messages", "MESSAGES") for struct in of),
)
Command: Any = reduce(or_, COMMANDS)  #: the union of all commands
_BY_TYPE: dict[str, type[Struct]] = {str(command.__struct_config__.tag): command for command in COMMANDS}
_DECODER = msgspec.json.Decoder(Command)
ServerMessage: Any = reduce(or_, MESSAGES)  #: the union of all messages

_TYPE_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a string",
    "bool": "true or false",
    "array": "a list",
    "object": "an object",
    "null": "null",
}  #: descriptions of msgspec's names of types


def _refuse_constant(name: str) -> float:
    raise ProtocolError("command.number", f"{name} is not a JSON number.")


def decode_command(text: str | bytes) -> Struct:
    """Return a command from the browser, one of :data:`COMMANDS`.

    Raises :class:`ProtocolError` for anything else: binary data, invalid JSON, NaN or Infinity, too much text, a
    missing or unknown ``type``, a missing field or one of another type.
    """
    if isinstance(text, bytes):
        raise ProtocolError("command.binary", "Commands are text frames, not binary ones.")
    if len(text) > MAX_COMMAND_BYTES:
        raise ProtocolError("command.too_long", f"A command has at most {MAX_COMMAND_BYTES} characters.")
    try:
        command: Struct = _DECODER.decode(text)
    except (msgspec.DecodeError, RecursionError):
        return command_of(_fields(text))  # raises an error that says what is wrong
    return command


def _fields(text: str) -> object:
    """Return the contents of a text frame. Raises :class:`ProtocolError` if it is not JSON."""
    try:
        fields: object = json.loads(text, parse_constant=_refuse_constant)
        json.dumps(fields, ensure_ascii=False).encode()
    except UnicodeEncodeError as error:
        raise ProtocolError("command.json", "A command contains a surrogate without its pair.") from error
    except (ValueError, RecursionError) as error:
        raise ProtocolError("command.json", "A command is one JSON object; this is not JSON.") from error
    return fields


def command_of(fields: object) -> Struct:
    """Return the command with these fields, including its ``type``, as one of :data:`COMMANDS`.

    Raises :class:`ProtocolError`.
    """
    if not isinstance(fields, dict) or not isinstance(fields.get("type"), str):
        raise ProtocolError("command.type", 'A command is a JSON object with a "type".')
    kind = _BY_TYPE.get(fields["type"])
    if kind is None:
        raise ProtocolError("command.unknown", f"There is no command {fields['type']!r:.80}.")
    try:
        # Converts to one type, because for the union msgspec would prepare all types again with each command.
        return msgspec.convert(fields, kind)
    except msgspec.ValidationError as error:
        raise _refused(fields["type"], str(error)) from error


def _refused(kind: str, error: str) -> ProtocolError:
    """Return the error for a command of type ``kind`` from msgspec's message ``error``."""
    what, _, path = error.partition(" - at `$.")
    missing = re.fullmatch(r"Object missing required field `(\w+)`", what)
    if missing is not None:
        return ProtocolError(f"command.{missing[1]}", f'The command "{kind}" needs a "{missing[1]}".')
    what = re.sub(r"`([^`]+)`", lambda name: " or ".join(_TYPE_WORDS.get(k, k) for k in name[1].split(" | ")), what)
    path = path.removesuffix("`").replace("[...]", "")
    name = path.partition("[")[0]
    return ProtocolError(f"command.{name}", f'"{path}" of the command "{kind}" is wrong: {what}.')
