"""Generate from the messages: TypeScript types and validators, the JSON Schema, and the documentation page.

The constants shared by the pages and the mapper are written too. ``python -m server.stream.generate`` writes the files;
with ``--check`` it only fails if one is out of date.
"""

from __future__ import annotations

import inspect
import json
import sys
import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import get_args

import msgspec
from msgspec import inspect as types

from mapper.diagnosis.examination import LEAST_SCANS
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD
from mapper.grid.merge import LATTICE_TOLERANCE
from mapper.mapping.parameters import PARAMETERS
from mapper.sensors.pose_graph import CONTRADICTS, STRAINED
from mapper.simulation.edits import WALL_THICKNESS
from mapper.simulation.lidar import SensorConfig
from mapper.simulation.live_map import LiveMap
from mapper.simulation.simulation import ROBOT_RADIUS
from server.parts import wire
from server.stream import message_parts, protocol
from server.stream.class_messages import ClassCommand, ClassMessage
from server.stream.close_codes import CLOSE_CODES, ENDED

#: rows of the table of mapping parameters that the profile of the sensor model shows
_SHOWN = [
    row for row in PARAMETERS if row.group == "model" or row.name in {"log_odds_prior", "no_return", "resolution"}
]
_LIVE = LiveMap.first_config(SensorConfig())

#: name, value, meaning
CONSTANTS: tuple[tuple[str, float, str], ...] = (
    ("ROBOT_RADIUS", ROBOT_RADIUS, "Radius of the simulated robot, which is a disc, metres."),
    ("WALL_THICKNESS", WALL_THICKNESS, "Thickness of a wall that is drawn into a world, metres."),
    ("LIVE_RANGE_MAX", _LIVE.range_max, "Longest range that a live world's map begins with, metres."),
    ("LIVE_WINDOW", _LIVE.window, "Window of a hit that a live world's map begins with, metres."),
    ("LATTICE_TOLERANCE", LATTICE_TOLERANCE, "How far two lattices may lie apart and still be the same, in cells."),
    ("OCCUPIED_THRESHOLD", OCCUPIED_THRESHOLD, "p_occ above which a cell is occupied, as in map_server."),
    ("FREE_THRESHOLD", FREE_THRESHOLD, "p_occ below which a cell is free, as in map_server."),
    ("LOOP_STRAINED", STRAINED, "Residual from which a loop is strained, standard deviations."),
    ("LOOP_CONTRADICTS", CONTRADICTS, "Residual from which a loop contradicts the rest, standard deviations."),
    ("DOCTOR_LEAST_SCANS", LEAST_SCANS, "Scans of a sensor below which the doctor refuses to judge a log."),
)
ROOT = Path(__file__).parents[2]
COMMAND = "python -m server.stream.generate"
_SCALARS: dict[type[types.Type], tuple[str, str]] = {  # TypeScript type, and validator
    types.IntType: ("number", "isInteger"),
    types.FloatType: ("number", "isNumber"),
    types.StrType: ("string", "isText"),
    types.BoolType: ("boolean", "isFlag"),
    types.NoneType: ("null", "isNull"),
}
#: description of each alias by its title; ``msgspec.inspect`` replaces it by a field's own description
ALIASES: dict[str, str] = {
    meta.title: meta.description or ""
    for alias in vars(message_parts).values()
    for meta in getattr(alias, "__metadata__", ())
    if isinstance(meta, msgspec.Meta) and meta.title is not None
}
_CHECKS = (
    "isFlag", "isInteger", "isListOf", "isLiteral", "isNull", "isNumber", "isObject", "isPositive", "isRecordOf",
    "isText", "isTuple", "oneOf", "optional",
)  # fmt: skip


def constants(command: str) -> str:
    """Return ``static/src/wire/constants.ts``, with a note that ``command`` writes it."""
    lines = [f"// Written by `{command}` from constants of mapper/: change those."]
    for name, value, meaning in CONSTANTS:
        lines += ["", f"/** {meaning} */", f"export const {name} = {value!r};"]
    initial = [f"  {row.name}: {json.dumps(row.initial)}," for row in _SHOWN]
    bounds = [
        f"  {row.name}: {{ low: {row.low!r}, high: {row.high!r}, step: {row.step!r} }},"
        for row in _SHOWN
        if row.kind == "number"
    ]
    lines += ["", "/** Initial values of the parameters of the sensor model. */"]
    lines += ["export const SENSOR_MODEL_INITIAL = {", *initial, "} as const;"]
    lines += ["", "/** Bounds and steps of their numbers. */"]
    lines += ["export const SENSOR_MODEL_BOUNDS = {", *bounds, "} as const;"]
    return "\n".join([*lines, ""])


def _structs(classes: Iterable[type[msgspec.Struct]]) -> list[types.StructType]:
    structs = [types.type_info(cls) for cls in classes]
    return [struct for struct in structs if isinstance(struct, types.StructType)]


MESSAGES, COMMANDS = _structs(wire.MESSAGES), _structs(wire.COMMANDS)
CLASS_MESSAGES, CLASS_COMMANDS = _structs(get_args(ClassMessage)), _structs(get_args(ClassCommand))


def _children(of: types.Type) -> tuple[types.Type, ...]:
    match of:
        case types.Metadata(type=inner):
            return (inner,)
        case types.UnionType(types=inner) | types.TupleType(item_types=inner):
            return tuple(inner)
        case types.ListType(item_type=inner) | types.VarTupleType(item_type=inner):
            return (inner,)
        case types.DictType(value_type=inner):
            return (inner,)
        case types.StructType(fields=fields):
            return tuple(field.type for field in fields)
    return ()


def _alias(of: types.Type) -> str | None:
    """Return the name of a type: the title of its ``Meta``."""
    return (of.extra_json_schema or {}).get("title") if isinstance(of, types.Metadata) else None


def _named_parts(roots: Iterable[types.Type]) -> dict[str, types.Type]:
    """Return the aliases and the objects inside messages by name, each after its own parts."""
    named: dict[str, types.Type] = {}

    def visit(kind: types.Type, *, is_root: bool) -> None:
        for child in _children(kind):
            visit(child, is_root=False)
        name = kind.cls.__name__ if isinstance(kind, types.StructType) else _alias(kind)
        if name is not None and not is_root:
            named.setdefault(name, kind)

    for root in roots:
        visit(root, is_root=True)
    return named


def _description(of: types.Type) -> str:
    """Return the description of a field's type, else the first one inside it."""
    own = (of.extra_json_schema or {}).get("description", "") if isinstance(of, types.Metadata) else ""
    return own or next((text for text in map(_description, _children(of)) if text), "")


def _doc(of: types.StructType) -> str:
    return " ".join((inspect.getdoc(of.cls) or "").split())


def _typescript(of: types.Type, *, expand: bool = False) -> str:
    """Return a type in TypeScript; ``expand`` writes out an alias."""
    name = _alias(of)
    if name is not None and not expand:
        return name
    match of:
        case types.Metadata(type=inner, extra=extra):
            if isinstance(inner, types.TupleType) and extra:
                items = zip(extra["labels"], inner.item_types, strict=True)
                return f"readonly [{', '.join(f'{label}: {_typescript(item)}' for label, item in items)}]"
            return _typescript(inner)
        case types.UnionType(types=options):
            return " | ".join(_typescript(option) for option in options)
        case types.LiteralType(values=values):
            return " | ".join(json.dumps(value) for value in values)
        case types.TupleType(item_types=items):
            return f"readonly [{', '.join(map(_typescript, items))}]"
        case types.ListType(item_type=item) | types.VarTupleType(item_type=item):
            inner_text = _typescript(item)
            return f"readonly ({inner_text})[]" if " " in inner_text else f"readonly {inner_text}[]"
        case types.DictType(value_type=value):
            return f"Readonly<Record<string, {_typescript(value)}>>"
        case types.StructType(cls=cls):
            return cls.__name__
    return _SCALARS[type(of)][0]


def _validator(of: types.Type, *, expand: bool = False) -> str:
    """Return the expression that checks a value of a type; ``expand`` writes out an alias."""
    name = of.cls.__name__ if isinstance(of, types.StructType) else _alias(of)
    if name is not None and not expand:
        return f"is{name}"
    match of:
        case types.Metadata(type=inner):
            return _validator(inner)
        case types.UnionType(types=options):
            return f"oneOf({', '.join(map(_validator, options))})"
        case types.LiteralType(values=values):
            return f"isLiteral({', '.join(json.dumps(value) for value in values)})"
        case types.TupleType(item_types=items):
            return f"isTuple({', '.join(map(_validator, items))})"
        case types.ListType(item_type=item) | types.VarTupleType(item_type=item):
            return f"isListOf({_validator(item)})"
        case types.DictType(value_type=value):
            return f"isRecordOf({_validator(value)})"
        case types.StructType(fields=fields):
            return f"isObject({_fields(fields)})"
        case types.FloatType(gt=0):
            return "isPositive"
    return _SCALARS[type(of)][1]


def _fields(fields: Iterable[types.Field], indent: str = "") -> str:
    lines = [
        f"{indent}  {field.encode_name}: "
        + (_validator(field.type) if field.required else f"optional({_validator(field.type)})")
        + ","
        for field in fields
    ]
    return "\n".join(["{", *lines, f"{indent}}}"])


def _comment(text: str, indent: str = "") -> list[str]:
    comment = f"{indent}/** {text} */"
    if len(comment) <= 120:
        return [comment]
    return [f"{indent}/**", *textwrap.wrap(text, 118, initial_indent=f"{indent} * ", subsequent_indent=f"{indent} * "),
            f"{indent} */"]  # fmt: skip


def _interface(struct: types.StructType) -> list[str]:
    lines = [*_comment(_doc(struct)), f"export interface {struct.cls.__name__} {{"]
    if struct.tag_field is not None:
        lines.append(f"  readonly {struct.tag_field}: {json.dumps(struct.tag)};")
    for field in struct.fields:
        mark = "" if field.required else "?"
        lines += _comment(_description(field.type), "  ")
        lines.append(f"  readonly {field.encode_name}{mark}: {_typescript(field.type)};")
    return [*lines, "}", ""]


def typescript() -> str:
    """Return ``static/src/wire/messages.ts``."""
    every = [*MESSAGES, *COMMANDS, *CLASS_MESSAGES, *CLASS_COMMANDS]
    parts = {name: part for name, part in _named_parts(every).items() if part not in every}
    read = _named_parts([*MESSAGES, *CLASS_MESSAGES])
    lines = [
        f"// Written by `{COMMAND}` from the Structs of server/stream and server/parts: change those.",
        "",
        "import {",
        "  type Check,",
        *(f"  {name}," for name in sorted(_CHECKS)),
        '} from "./checks";',
        "",
        "/** Version of the protocol, as the WebSocket's subprotocol. */",
        f"export const SUBPROTOCOL = {json.dumps(protocol.SUBPROTOCOL)};",
        "",
    ]
    for name, part in parts.items():
        if isinstance(part, types.StructType):
            lines += _interface(part)
        else:
            lines += [*_comment(ALIASES[name]), f"export type {name} = {_typescript(part, expand=True)};", ""]
    for struct in every:
        lines += _interface(struct)
    unions = (
        ("ServerMessage", MESSAGES),
        ("Command", COMMANDS),
        ("ClassMessage", CLASS_MESSAGES),
        ("ClassCommand", CLASS_COMMANDS),
    )
    for union, structs in unions:
        lines += [f"export type {union} =", *(f"  | {struct.cls.__name__}" for struct in structs)]
        lines[-1] += ";"
        lines.append("")
    lines += [f"const is{name}: Check = {_validator(part, expand=True)};" for name, part in read.items()]
    lines += [
        "",
        "/** The check of each field of each message from the server; a message may have more fields. */",
        'export const FIELDS: Readonly<Record<ServerMessage["type"], Readonly<Record<string, Check>>>> = {',
        *(f"  {struct.tag}: {_fields(struct.fields, '  ')}," for struct in MESSAGES),
        "};",
        "",
        "/** The same of the messages of a class. */",
        'export const CLASS_FIELDS: Readonly<Record<ClassMessage["type"], Readonly<Record<string, Check>>>> = {',
        *(f"  {struct.tag}: {_fields(struct.fields, '  ')}," for struct in CLASS_MESSAGES),
        "};",
        "",
        "/** The sentence that the page shows when the server closes the connection with one of these codes. */",
        "export const CLOSE_SENTENCES: Readonly<Record<number, string>> = {",
        *(f"  {code.code}: {json.dumps(code.sentence)}," for code in CLOSE_CODES),
        "};",
        "",
        "/** Close codes after which the session may not exist any more. */",
        f"export const MAYBE_OVER: readonly number[] = {[code.code for code in CLOSE_CODES if code.may_be_over]};",
        "",
        "/** The close code of a session's own stream after which the session does not exist. */",
        f"export const ENDED = {ENDED.code};",
        "",
    ]
    return "\n".join(lines)


def schema() -> str:
    """Return ``docs/wire.schema.json``, with the definitions ``ServerMessage`` and ``Command``."""
    unions = {
        "ServerMessage": wire.ServerMessage,
        "Command": wire.Command,
        "ClassMessage": ClassMessage,
        "ClassCommand": ClassCommand,
    }
    components, parts = msgspec.json.schema_components(unions.values(), ref_template="#/$defs/{name}")
    for part in parts.values():
        if "description" in part:  # a docstring; Python removes its indentation only from version 3.13 on
            part["description"] = inspect.cleandoc(part["description"])
    whole = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": protocol.SUBPROTOCOL,
        "$defs": dict(zip(unions, components, strict=True)) | parts,
    }
    return json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


def _words(of: types.Type) -> str:
    """Return a type in words for the documentation."""
    if (name := _alias(of)) is not None:
        return f"[{name}](#{name.lower()})"
    match of:
        case types.Metadata(type=inner):
            return _words(inner)
        case types.UnionType(types=options):
            return " or ".join(map(_words, options))
        case types.LiteralType(values=values):
            return " or ".join(f"`{json.dumps(value)}`" for value in values)
        case types.TupleType(item_types=items):
            return f"[{', '.join(map(_words, items))}]"
        case types.ListType(item_type=item) | types.VarTupleType(item_type=item):
            return f"list of ({_words(item)})" if isinstance(item, types.UnionType) else f"list of {_words(item)}"
        case types.DictType(value_type=value):
            return f"object of {_words(value)}"
        case types.StructType(cls=cls):
            return f"[{cls.__name__}](#{cls.__name__.lower()})"
        case types.IntType():
            return "integer"
    return _SCALARS[type(of)][0]


def _table(fields: Iterable[types.Field]) -> list[str]:
    rows = [
        f"| `{field.encode_name}` | {_words(field.type)}{'' if field.required else ', optional'} "
        f"| {_description(field.type)} |"
        for field in fields
    ]
    return ["", "| field | type | |", "| --- | --- | --- |", *rows] if rows else []


def page() -> str:
    """Return ``docs/wire.md``."""
    lines = [
        f"<!-- Written by `{COMMAND}`: change server/stream and server/parts instead. -->",
        "",
        "# Wire protocol",
        "",
    ]
    lines += [inspect.cleandoc(protocol.__doc__ or ""), ""]
    lines += ["The schema of all text messages: [wire.schema.json](wire.schema.json).", ""]
    sections = (
        ("Messages from the server", MESSAGES),
        ("Commands from the browser", COMMANDS),
        ("Messages of a class", CLASS_MESSAGES),
        ("Commands of a class", CLASS_COMMANDS),
    )
    for title, structs in sections:
        lines += [f"## {title}", ""]
        for struct in structs:
            lines += [f"### `{struct.tag}`", "", _doc(struct), *_table(struct.fields), ""]
    lines += ["## Parts of messages", ""]
    every = [*MESSAGES, *COMMANDS, *CLASS_MESSAGES, *CLASS_COMMANDS]
    for name, part in _named_parts(every).items():
        if isinstance(part, types.StructType):
            lines += [f"### {name}", "", _doc(part), *_table(part.fields), ""]
        else:
            shape = _typescript(part, expand=True).replace("readonly ", "")
            lines += [f"### {name}", "", f"`{shape}`: {ALIASES[name]}.", ""]
    lines += ["## Close codes", "", "| code | cause | sentence on the page |", "| --- | --- | --- |"]
    lines += [f"| {code.code} | {code.cause} | {code.sentence} |" for code in CLOSE_CODES]
    return "\n".join([*lines, ""])


def outputs() -> dict[Path, str]:
    """Return the text of each generated file by its path."""
    return {
        ROOT / "static" / "src" / "wire" / "messages.ts": typescript(),
        ROOT / "static" / "src" / "wire" / "constants.ts": constants(COMMAND),
        ROOT / "docs" / "wire.schema.json": schema(),
        ROOT / "docs" / "wire.md": page(),
    }


def stale() -> list[Path]:
    """Return the generated files that are missing or out of date."""
    return [path for path, text in outputs().items() if not path.is_file() or path.read_text(encoding="utf-8") != text]


def main(arguments: list[str]) -> int:
    """Write outdated files, or list them with ``--check``; return the exit code."""
    late = stale()
    if "--check" in arguments:
        for path in late:
            print(f"{path.relative_to(ROOT)} is out of date: run {COMMAND}", file=sys.stderr)
        return 1 if late else 0
    texts = outputs()
    for path in late:
        path.write_text(texts[path], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
