"""Parser of message definitions in IDL, as in ROS 2 recordings: modules, structures, typedefs of arrays.

Source: OMG IDL 4.2, 7.4; design.ros2.org/articles/idl_interface_definition.html; mcap.dev/spec/registry (``ros2idl``:
the files of the type and of those that it uses, each after a line of ``=`` and ``IDL: package/msg/Type``). Other
features of IDL (unions, enumerations, maps, inheritance, wide characters, arrays of arrays) are rejected.
"""

from __future__ import annotations

import re

from mapper.core.errors import ReadError
from mapper.io.contents.definitions import DYNAMIC, MAX_BYTES, MAX_FIELDS, PRIMITIVES, STRING, Definitions, Field
from mapper.io.logs.ros.ros_messages import plain_type

MAX_DEPTH = 16  #: of nested modules, of which ROS has three, and of chained typedefs
#: Basic types of IDL with other names in ROS.
_BASIC = {
    "boolean": "bool", "octet": "byte", "float": "float32", "double": "float64",
    "short": "int16", "unsigned short": "uint16", "long": "int32", "unsigned long": "uint32",
    "long long": "int64", "unsigned long long": "uint64",
}  # fmt: skip
#: Comments, preprocessor lines and separators between files; or, as the group, a word. An unclosed comment extends to
#: the end, so that no text is searched twice.
_WORD = re.compile(
    r"""//[^\n]*|/\*(?:.*?\*/|.*)|^[ \t]*\#[^\n]*|^=+\s*$|^IDL:[^\n]*|"""
    r"""("(?:[^"\\]|\\.)*"?|'(?:[^'\\]|\\.)*'?|(?:::)?[A-Za-z_]\w*(?:::\w+)*|[\d.][\w.]*|\S)""",
    re.ASCII | re.DOTALL | re.MULTILINE,
)
_NAME = re.compile(r"(?:::)?[A-Za-z_]\w*(?:::\w+)*", re.ASCII)
_NO_MEMBER = "structure_needs_at_least_one_member"  #: used by ROS 2 in an empty message

_Type = tuple[str, int | None]  #: a name, and the length as in :class:`Field`


def definitions_in_idl(kind: str, text: str) -> Definitions:
    """Return the fields of the type ``kind`` and of all types in its definition.

    Raises :class:`ReadError` for an invalid text, unsupported features, or an undefined type.
    """
    if len(text) > MAX_BYTES:
        raise ReadError("message.definition", f"The definition of {kind!r:.100} has more than {MAX_BYTES} characters.")
    parser = _Parser([word for word in _WORD.findall(text) if word])
    parser.definitions("", 0, "")
    definitions: Definitions = {}
    for name, members in parser.structures.items():
        scope = name.rpartition("::")[0]
        fields = tuple(Field(member, *parser.resolved(scope, of)) for member, of in members)
        definitions[plain_type(name)] = () if [field.name for field in fields] == [_NO_MEMBER] else fields
    if plain_type(kind) not in definitions:
        raise ReadError("message.definition", f"The recording does not define the type {kind!r:.100}.")
    return definitions


def _refused(word: str) -> ReadError:
    return ReadError("message.definition", f"The recording’s definition has {word!r:.100}, which is not read of IDL.")


class _Parser:
    """Parses the structures and typedefs of a text; constants and annotations are skipped."""

    def __init__(self, tokens: list[str]) -> None:
        self.structures: dict[str, list[tuple[str, _Type]]] = {}
        self._typedefs: dict[str, _Type] = {}
        self._tokens = tokens
        self._at = 0
        self._members = 0

    def definitions(self, scope: str, depth: int, end: str) -> None:
        """Parse the contents of a module, or of the whole text, up to ``end``."""
        if depth > MAX_DEPTH:
            raise _refused("module")
        while (word := self._next(end)) != end:
            if word == "@":
                self._annotation()
                continue
            if word == "module":
                name = self._name(scope)
                self._expect("{")
                self.definitions(name, depth + 1, "}")
            elif word == "struct":
                name = self._name(scope)
                self._expect("{")
                self.structures[name] = self._structure()
            elif word == "typedef":
                of = self._type(self._next())
                for name, declared in self._declarators(of):
                    self._typedefs[_within(scope, name)] = declared
                continue
            elif word == "const":
                while self._next() != ";":
                    pass
                continue
            else:
                raise _refused(word)
            self._expect(";")

    def resolved(self, scope: str, of: _Type) -> _Type:
        """Return a type with its ROS name and all typedefs resolved.

        A name is looked up in ``scope``, then in each enclosing scope.
        """
        name, length = of
        for _ in range(MAX_DEPTH):
            if name in PRIMITIVES or name == STRING:
                return name, length
            full_name = next(
                (name_ for name_ in _scoped(scope, name) if name_ in self.structures or name_ in self._typedefs), None
            )
            if full_name is None:
                raise ReadError("message.definition", f"The recording does not define every type: {name!r:.200}.")
            if full_name in self.structures:
                return plain_type(full_name), length
            scope = full_name.rpartition("::")[0]
            name, own = self._typedefs[full_name]
            if own is not None:
                if length is not None:
                    raise _refused(full_name)
                length = own
        raise _refused(name)

    def _structure(self) -> list[tuple[str, _Type]]:
        members: list[tuple[str, _Type]] = []
        while (word := self._next()) != "}":
            if word == "@":
                self._annotation()
                continue
            declared = self._declarators(self._type(word))
            members += declared
            self._members += len(declared)
            if self._members > MAX_FIELDS:
                raise ReadError("message.definition", f"The recording’s definition has over {MAX_FIELDS} fields.")
        return members

    def _type(self, word: str) -> _Type:
        if word == "sequence":
            self._expect("<")
            if self._peek() == "sequence":
                raise _refused("sequence<sequence>")
            name, _ = self._type(self._next())
            self._bound(self._next())
            return name, DYNAMIC
        if word == STRING:
            if self._peek() == "<":
                self._next()
                self._next()
                self._expect(">")
            return STRING, None
        words = word
        while word in ("unsigned", "long") and self._peek() in ("short", "long"):
            word = self._next()
            words += f" {word}"
        name = _BASIC.get(words, words)
        if name not in PRIMITIVES and not _NAME.fullmatch(name):
            raise _refused(words)
        return name, None

    def _bound(self, word: str) -> None:
        if word == ",":
            self._next()
            word = self._next()
        if word != ">":
            raise _refused(word)

    def _declarators(self, of: _Type) -> list[tuple[str, _Type]]:
        """Return the names declared with a type, up to the semicolon, with their types, which may be arrays."""
        declarators: list[tuple[str, _Type]] = []
        while True:
            name, declared = self._name(""), of
            if self._peek() == "[":
                self._next()
                size = self._next()
                self._expect("]")
                if of[1] is not None or not size.isascii() or not size.isdecimal() or self._peek() == "[":
                    raise _refused(f"{name}[{size}]")
                declared = of[0], int(size)
            declarators.append((name, declared))
            word = self._next()
            if word == ";":
                return declarators
            if word != ",":
                raise _refused(word)

    def _annotation(self) -> None:
        """Skip an annotation's name and its parentheses."""
        self._name("")
        if self._peek() != "(":
            return
        depth = 0
        while True:
            word = self._next()
            depth += (word == "(") - (word == ")")
            if depth == 0:
                return

    def _name(self, scope: str) -> str:
        word = self._next()
        if not _NAME.fullmatch(word):
            raise _refused(word)
        return _within(scope, word)

    def _peek(self) -> str:
        return self._tokens[self._at] if self._at < len(self._tokens) else ""

    def _next(self, end: str | None = None) -> str:
        """Return the next word; at the end of the text nothing, if that is the expected ``end``."""
        if self._at == len(self._tokens):
            if end == "":
                return ""
            raise ReadError("message.definition", "The recording’s definition ends early.")
        self._at += 1
        return self._tokens[self._at - 1]

    def _expect(self, word: str) -> None:
        token = self._next()
        if token != word:
            raise _refused(token)


def _within(scope: str, name: str) -> str:
    return f"{scope}::{name}" if scope else name


def _scoped(scope: str, name: str) -> list[str]:
    """Return the full names that a name may refer to in a scope, nearest first."""
    if name.startswith("::"):
        return [name[2:]]
    names = [name]
    parts = scope.split("::") if scope else []
    for n in range(1, len(parts) + 1):
        names.insert(0, "::".join([*parts[:n], name]))
    return names
