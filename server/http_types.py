"""Generate ``static/src/wire/http.ts``: the types of the HTTP interface, from its OpenAPI document.

They are the types of queries, of JSON bodies and answers, and a list of the requests answered with files.
``python -m server.http_types`` writes the file; with ``--check`` it only fails if it is out of date.
"""

from __future__ import annotations

import json
import re
import sys
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from server.app import create_app
from server.settings import Settings

FILE = Path(__file__).parents[1] / "static" / "src" / "wire" / "http.ts"
COMMAND = "python -m server.http_types"
_REFERENCE = "#/components/schemas/"
_SCALARS = {"string": "string", "integer": "number", "number": "number", "boolean": "boolean", "null": "null"}

Schema = Mapping[str, Any]
"""A JSON Schema of the OpenAPI document."""


def _name(reference: str) -> str:
    """Return the TypeScript name of a referenced schema. Generic models have brackets in theirs."""
    return re.sub(r"\W", "", reference.removeprefix(_REFERENCE))


def _typescript(schema: Schema) -> str:
    """Return a schema as a type."""
    if "$ref" in schema:
        return _name(schema["$ref"])
    if "anyOf" in schema or "oneOf" in schema:
        return " | ".join(dict.fromkeys(map(_typescript, schema.get("anyOf") or schema["oneOf"])))
    if "enum" in schema or "const" in schema:
        return " | ".join(json.dumps(value) for value in schema.get("enum", [schema.get("const")]))
    kind = schema.get("type")
    if schema.get("format") == "binary":
        return "Blob"
    if kind == "array" and "prefixItems" in schema:
        return f"readonly [{', '.join(map(_typescript, schema['prefixItems']))}]"
    if kind == "array":
        item = _typescript(schema.get("items", {}))
        return f"readonly ({item})[]" if " " in item else f"readonly {item}[]"
    if kind == "object":
        value = schema.get("additionalProperties", True)
        key = _typescript(schema.get("propertyNames", {"type": "string"}))
        return f"Readonly<Record<{key}, {_typescript(value) if isinstance(value, Mapping) else 'unknown'}>>"
    return _SCALARS.get(kind or "", "unknown")


def _references(schema: object) -> Iterator[str]:
    """Yield the names of the schemas that a schema references."""
    if isinstance(schema, Mapping):
        for key, value in schema.items():
            if key == "$ref":
                yield value.removeprefix(_REFERENCE)
            else:
                yield from _references(value)
    elif isinstance(schema, list):
        for variant in schema:
            yield from _references(variant)


def _operations(document: Schema) -> Iterator[tuple[str, Schema]]:
    """Yield each request, by method and address, with its description."""
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield f"{method.upper()} {path}", operation


def answers_of(document: Schema) -> dict[str, list[Schema]]:
    """Return the schemas of the answers to each request, by method and address; {} for no content.

    Requests answered with a file are left out.
    """
    answers: dict[str, list[Schema]] = {}
    for request, operation in _operations(document):
        good = [answer for status, answer in operation["responses"].items() if status.startswith("2")]
        kinds = {kind for answer in good for kind in answer.get("content", {})}
        if kinds <= {"application/json"}:
            answers[request] = [
                answer.get("content", {}).get("application/json", {}).get("schema", {}) for answer in good
            ]
    return answers


def _files_of(document: Schema) -> list[str]:
    """Return the requests answered with a file. A path parameter with few values is expanded to each of them."""
    answers, files = answers_of(document), []
    for request, operation in _operations(document):
        if request in answers:
            continue
        named = [request]
        for parameter in operation.get("parameters", []):
            if parameter["in"] == "path" and "enum" in parameter["schema"]:
                part = f"{{{parameter['name']}}}"
                named = [name.replace(part, value) for name in named for value in parameter["schema"]["enum"]]
        files += named
    return sorted(files)


def _bodies_of(document: Schema) -> dict[str, Schema]:
    """Return the schema of the body of each request that has one, by method and address."""
    return {
        request: content["schema"]
        for request, operation in _operations(document)
        for content in operation.get("requestBody", {}).get("content", {}).values()
    }


def _queries_of(document: Schema) -> dict[str, str]:
    """Return the type of the query of each request that has one, by method and address."""
    queries = {}
    for request, operation in _operations(document):
        fields = [
            _field(parameter["name"], parameter["schema"], is_optional=not parameter.get("required", False)).replace(
                " | null", ""
            )
            for parameter in operation.get("parameters", [])
            if parameter["in"] == "query"
        ]
        if fields:
            queries[request] = "\n    ".join(["{", *fields]) + "\n  }"
    return queries


def _answer_type(schemas: list[Schema]) -> str:
    parts = [part for schema in schemas for part in (_typescript(schema) if schema else "undefined").split(" | ")]
    return " | ".join(dict.fromkeys(parts))


def _comment(text: str, indent: str = "") -> list[str]:
    whole = f"{indent}/** {' '.join(text.replace('``', '`').replace('None', 'null').split())} */"
    if len(whole) <= 120:
        return [whole]
    lines = textwrap.wrap(whole.strip()[4:-3], 117 - len(indent))
    return [f"{indent}/**", *(f"{indent} * {line}" for line in lines), f"{indent} */"]


def _field(name: str, schema: Schema, *, is_optional: bool) -> str:
    return f"readonly {name}{'?' if is_optional else ''}: {_typescript(schema)};"


def _interface(name: str, schema: Schema, *, is_answer: bool) -> list[str]:
    """Return the declaration of a schema; an answer has all of its fields."""
    described = _comment(schema["description"]) if "description" in schema else []
    if schema.get("type") != "object" or "properties" not in schema:
        return [*described, f"export type {_name(name)} = {_typescript(schema)};", ""]
    lines = [*described, f"export interface {_name(name)} {{"]
    for field, of in schema["properties"].items():
        if "description" in of:
            lines += _comment(of["description"], "  ")
        is_optional = not is_answer and field not in schema.get("required", [])
        lines.append(f"  {_field(field, of, is_optional=is_optional)}")
    return [*lines, "}", ""]


def _with_references(of: object, schemas: Schema) -> set[str]:
    """Return the names of the schemas that one references, directly or through others."""
    names: set[str] = set()
    left = [*_references(of)]
    while left:
        if (name := left.pop()) not in names:
            names.add(name)
            left += _references(schemas[name])
    return names


def typescript(document: Schema) -> str:
    """Return the file for an OpenAPI document."""
    schemas, answers, bodies = document["components"]["schemas"], answers_of(document), _bodies_of(document)
    answered = _with_references([*answers.values()], schemas)
    lines = [f"// Written by `{COMMAND}` from the routes of the server: change those.", ""]
    for name in sorted(answered | _with_references([*bodies.values()], schemas)):
        lines += _interface(name, schemas[name], is_answer=name in answered)
    listed = (
        ("Queries", "The query of each request that has one", _queries_of(document)),
        ("Bodies", "The body of each request that has one", {what: _typescript(of) for what, of in bodies.items()}),
        ("Answers", "The answer to each request", {what: _answer_type(of) for what, of in answers.items()}),
    )
    for title, meaning, types in listed:
        lines += [f"/** {meaning}, by method and address. */", f"export interface {title} {{"]
        lines += [*(f"  {json.dumps(request)}: {of};" for request, of in sorted(types.items())), "}", ""]
    lines += ["/** The requests that are answered with a file. */", "export type Files ="]
    lines += [f"  | {json.dumps(request)}" for request in _files_of(document)]
    return "\n".join(lines) + ";\n"


def main() -> None:
    """Write the file, or check it."""
    text = typescript(create_app(Settings()).openapi())
    if "--check" not in sys.argv[1:]:
        FILE.write_text(text, encoding="utf-8")
    elif not FILE.exists() or FILE.read_text(encoding="utf-8") != text:
        sys.exit(f"{FILE.name} is out of date: run `make wire`.")


if __name__ == "__main__":
    main()
