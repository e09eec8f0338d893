"""Files generated from the messages are up to date, and outdated ones are named."""

from __future__ import annotations

import inspect
import json
from pathlib import Path

import pytest

from server.stream import generate
from server.stream.messages import CellMessage


def test_the_generated_files_are_up_to_date() -> None:
    assert generate.stale() == [], "run: python -m server.stream.generate"


def test_a_changed_message_makes_the_check_fail(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(generate, "ROOT", tmp_path)
    for folder in ("docs", "static/src/wire"):
        (tmp_path / folder).mkdir(parents=True)
    assert generate.main(["--check"]) == 1
    assert generate.main([]) == 0
    assert generate.main(["--check"]) == 0
    assert "static/src/wire/constants.ts" in capsys.readouterr().err
    monkeypatch.setattr(CellMessage, "__doc__", "Another sentence.")
    assert generate.main(["--check"]) == 1
    told = capsys.readouterr().err.splitlines()
    assert [line.partition(" is out of date")[0] for line in told] == [
        "static/src/wire/messages.ts",
        "docs/wire.schema.json",
        "docs/wire.md",
    ]


def test_every_field_has_a_description() -> None:
    schema = json.loads(generate.schema())
    for name, part in schema["$defs"].items():
        if part.get("type") != "object":
            continue
        assert part["description"]
        assert part["description"] == inspect.cleandoc(part["description"]), "as Python 3.13 compiles docstrings"
        for key, field in part["properties"].items():
            assert key == "type" or field.get("description"), f"{name}.{key}"
