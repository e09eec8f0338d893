"""The types of requests and answers in the pages are those of the OpenAPI document."""

from __future__ import annotations

from typing import Any

import pytest

from server import http_types
from server.app import create_app
from server.settings import Settings


def test_the_generated_file_is_up_to_date(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["http_types", "--check"])
    http_types.main()


def test_an_outdated_file_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    monkeypatch.setattr(http_types, "FILE", tmp_path / "http.ts")
    monkeypatch.setattr("sys.argv", ["http_types", "--check"])
    with pytest.raises(SystemExit, match=r"http\.ts is out of date"):
        http_types.main()


def test_models_become_interfaces() -> None:
    """With what they refer to; a field that a body may leave out is optional there, an answer has all of its fields."""
    end = {"type": "object", "properties": {"at": {"prefixItems": [{"type": "number"}] * 2, "type": "array"}}}
    line = {
        "type": "object",
        "description": "A line, ``None``: nowhere.",
        "properties": {
            "ends": {"type": "array", "items": {"$ref": "#/components/schemas/End"}},
            "colour": {"anyOf": [{"enum": ["red", "blue"], "type": "string"}, {"type": "null"}]},
            "lengths": {"type": "object", "additionalProperties": {"type": "integer"}},
            "mixed": {"type": "array", "items": {"anyOf": [{"type": "string"}, {"type": "number"}]}},
        },
    }
    answer = {"200": {"content": {"application/json": {"schema": {"$ref": "#/components/schemas/Line"}}}}, "404": {}}
    either = {"200": answer["200"], "202": {"content": {"application/json": {"schema": {"type": "null"}}}}, "204": {}}
    file: dict[str, object] = {"200": {"content": {"image/png": {}}}}
    wanted = {
        "type": "object",
        "properties": {"end": {"$ref": "#/components/schemas/End"}, "name": {"type": "string"}},
        "required": ["end"],
    }
    named = {"requestBody": {"content": {"application/json": {"schema": {"$ref": "#/components/schemas/Wanted"}}}}}
    binary = {"requestBody": {"content": {"a/b": {"schema": {"type": "string", "format": "binary"}}}}}
    query = {
        "parameters": [
            {"in": "path", "name": "id", "schema": {"type": "string"}},
            {"in": "query", "name": "at", "required": True, "schema": {"type": "number"}},
            {"in": "query", "name": "until", "schema": {"anyOf": [{"type": "number"}, {"type": "null"}]}},
        ]
    }
    kinds = {
        "parameters": [
            {"in": "path", "name": "id", "schema": {"type": "string"}},
            {"in": "path", "name": "kind", "schema": {"type": "string", "enum": ["yaml", "pgm"]}},
        ]
    }
    document = {
        "paths": {
            "/lines/{id}": {"get": {"responses": answer}, "delete": {"responses": {"204": {}}}},
            "/lines": {"get": {"responses": either}, "post": {"responses": file} | named},
            "/lines.png": {"get": {"responses": file} | query, "put": {"responses": file} | binary},
            "/{id}.{kind}": {"get": {"responses": file} | kinds},
        },
        "components": {"schemas": {"Line": line, "End": end, "Wanted": wanted, "Other": end}},
    }
    assert (
        http_types.typescript(document).split("\n", 2)[2]
        == """\
export interface End {
  readonly at: readonly [number, number];
}

/** A line, `null`: nowhere. */
export interface Line {
  readonly ends: readonly End[];
  readonly colour: "red" | "blue" | null;
  readonly lengths: Readonly<Record<string, number>>;
  readonly mixed: readonly (string | number)[];
}

export interface Wanted {
  readonly end: End;
  readonly name?: string;
}

/** The query of each request that has one, by method and address. */
export interface Queries {
  "GET /lines.png": {
    readonly at: number;
    readonly until?: number;
  };
}

/** The body of each request that has one, by method and address. */
export interface Bodies {
  "POST /lines": Wanted;
  "PUT /lines.png": Blob;
}

/** The answer to each request, by method and address. */
export interface Answers {
  "DELETE /lines/{id}": undefined;
  "GET /lines": Line | null | undefined;
  "GET /lines/{id}": Line;
}

/** The requests that are answered with a file. */
export type Files =
  | "GET /lines.png"
  | "GET /{id}.pgm"
  | "GET /{id}.yaml"
  | "POST /lines"
  | "PUT /lines.png";
"""
    )


def test_every_answer_in_json_is_a_model() -> None:
    answers = http_types.answers_of(create_app(Settings()).openapi())
    assert len(answers) > 90
    unnamed = {
        request
        for request, schemas in answers.items()
        for schema in schemas
        if schema and any("$ref" not in part for part in schema.get("anyOf", [schema]))
    }
    assert not unnamed
    # {} is no content there, or what a route returns without a model.
    empty = {request for request, schemas in answers.items() if {} in schemas}
    assert {request for request in empty if not request.startswith("DELETE ")} == {
        "GET /api/classes",
        "GET /api/sessions/making/{name}",
        "PUT /api/classes/{code}/puzzle",
    }
