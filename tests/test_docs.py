"""The README says what the code does: its tables are written from the code. ``python tests/test_docs.py --write``."""

from __future__ import annotations

import contextlib
import gzip
import io
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic_core import PydanticUndefined
from typer.testing import CliRunner

from mapper.parameters import PARAMETERS
from server.cli import app
from server.settings import Settings

README = Path(__file__).parents[1] / "README.md"


def parameters_table() -> str:
    """The parameter table as Markdown."""
    lines = ["| name | first | from … to | what it does |", "|---|---|---|---|"]
    for row in PARAMETERS:
        unit = f" {row.unit}" if row.unit else ""
        bounds = {"number": f"{row.low:g} … {row.high:g}{unit}", "choice": " · ".join(row.choices), "flag": "on · off"}
        first = {
            "number": f"{row.initial:g}{unit}" if row.kind == "number" else "",
            "flag": "on" if row.initial else "off",
        }
        shown = first.get(row.kind, str(row.initial))
        lines.append(f"| `{row.name}` | {shown} | {bounds[row.kind]} | {row.sentence} |")
    return "\n".join(lines)


def settings_table() -> str:
    """The settings as Markdown."""
    lines = ["| variable | default | meaning |", "|---|---|---|"]
    for name, field in Settings.model_fields.items():
        default = field.default if field.default is not PydanticUndefined else None
        shown = "" if default in (None, ()) else f"`{default}`"
        lines.append(f"| `GRIDBLOOM_{name.upper()}` | {shown} | {field.description} |")
    return "\n".join(lines)


TABLES = {"parameters": parameters_table, "settings": settings_table}


def with_tables(text: str) -> str:
    """The README's text with every table written anew."""
    for name, table in TABLES.items():
        pattern = rf"(?s)<!-- {name} -->.*?<!-- /{name} -->"
        assert re.search(pattern, text), f"the README has no place for the {name}"
        text = re.sub(pattern, lambda _, n=name, t=table: f"<!-- {n} -->\n{t()}\n<!-- /{n} -->", text)  # type: ignore[misc]
    return text


def test_the_tables_are_those_of_the_code() -> None:
    text = README.read_text()
    assert with_tables(text) == text, "write them anew: python tests/test_docs.py --write"


@pytest.mark.parametrize("name", Settings.model_fields)
def test_every_setting_says_what_it_means(name: str) -> None:
    description = Settings.model_fields[name].description or ""
    assert description.endswith(".")


@pytest.mark.parametrize("command", re.findall(r"^    gridbloom (.+)$", README.read_text(), re.MULTILINE))
def test_every_command_of_the_readme_exists(command: str) -> None:
    words = [word for word in command.split() if word.islower() and not word.startswith("-") and "/" not in word]
    options = set(re.findall(r"--[a-z-]+", command))
    result = CliRunner().invoke(app, [*words, "--help"], env={"COLUMNS": "200"})
    assert result.exit_code == 0, result.output
    assert all(option in result.output for option in options)


def test_the_library_is_used_as_the_readme_shows_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A room 4 m wide, seen from its middle forwards and backwards.
    angles = np.radians(np.arange(180) - 90.0)
    ranges = " ".join(f"{r:.3f}" for r in 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles))))
    lines = [
        f"FLASER 180 {ranges} 0 0 {yaw} 0 0 {yaw} {k} host {k}\n" for k, yaw in enumerate((0.0, 3.141592653589793))
    ]
    monkeypatch.chdir(tmp_path)
    Path("intel.log.gz").write_bytes(gzip.compress("".join(lines).encode()))
    program, own_model = re.findall(r"(?s)```python\n(.*?)```", README.read_text())
    assert len([line for line in program.splitlines() if line and not line.startswith("from")]) <= 10
    names: dict[str, Any] = {}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(program, names)
    said = re.fullmatch(r"(\d+) cells are occupied\n", printed.getvalue())
    assert said
    # The wall is 4 · 80 cells long, and 360 beams end on it, here and there two in one cell.
    assert 200 < int(said[1]) <= 360
    assert Path("out/intel.pgm").read_bytes().startswith(b"P5\n128 128\n")

    built_in = names["grid"]
    assert len([line for line in own_model.splitlines() if line]) <= 13
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(own_model, names)
    assert re.fullmatch(
        r"<OccupancyGrid 128 × 128 cells of 0.05 m, origin \(-3.2, -3.2, 0\), \d+ known>\n", printed.getvalue()
    )
    own = names["grid"]
    assert own is not built_in
    # Both models find the room: free in its middle, and the same walls to within the window.
    row, col = own.geometry.world_to_cell((0.3, 0.2))
    assert own.classify()[row, col] == built_in.classify()[row, col] == 0
    walls = own.classify() == 100
    assert walls.sum() >= 200
    near = np.argwhere(built_in.classify() == 100)
    assert all(np.abs(near - cell).max(axis=1).min() <= 6 for cell in np.argwhere(walls))


def test_every_picture_is_there() -> None:
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", README.read_text())
    assert pictures
    assert all((README.parent / picture).is_file() for picture in pictures)


if __name__ == "__main__" and "--write" in sys.argv:
    README.write_text(with_tables(README.read_text()))
