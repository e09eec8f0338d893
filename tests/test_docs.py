"""The README and docs/ agree with the code: tables are written from it. ``python tests/test_docs.py --write``."""

from __future__ import annotations

import ast
import contextlib
import gzip
import io
import json
import re
import runpy
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.routing import APIRoute
from pydantic_core import PydanticUndefined
from typer.testing import CliRunner

from mapper.mapping.parameters import PARAMETERS
from server.app import create_app
from server.cli import app
from server.settings import Settings

README = Path(__file__).parents[1] / "README.md"
ROOT = README.parent
DOCS = ROOT / "docs"
TESTING = DOCS / "testing.md"
SERVICE = DOCS / "service.md"
COMMAND_LINE = DOCS / "command-line.md"
COMMANDS = README.read_text() + COMMAND_LINE.read_text()
HISTORY = DOCS / "history.md"  # of names and paths that may be gone
PAGES = [*sorted(path for path in DOCS.rglob("*.md") if path != HISTORY), README, ROOT / "CONTRIBUTING.md"]


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


def routes_table() -> str:
    """The public routes as Markdown, each with the first sentence of its description."""
    lines = ["| request | what it does |", "|---|---|"]
    for path, methods in create_app(Settings()).openapi()["paths"].items():
        for method, operation in methods.items():
            sentence = re.split(r"(?<=\.)\s", operation["description"], maxsplit=1)[0]
            lines.append(f"| `{method.upper()} {path}` | {sentence} |")
    return "\n".join(lines)


TABLES = {
    COMMAND_LINE: {"parameters": parameters_table},
    SERVICE: {"routes": routes_table, "settings": settings_table},
}


def with_tables(page: Path) -> str:
    """A page's text with each of its tables rewritten."""
    text = page.read_text()
    for name, table in TABLES[page].items():
        pattern = rf"(?s)<!-- {name} -->.*?<!-- /{name} -->"
        assert re.search(pattern, text), f"{page.name} has no place for the {name}"
        text = re.sub(pattern, lambda _, n=name, t=table: f"<!-- {n} -->\n{t()}\n<!-- /{n} -->", text)  # type: ignore[misc]
    return text


@pytest.mark.parametrize("page", TABLES, ids=lambda page: page.name)
def test_the_tables_are_those_of_the_code(page: Path) -> None:
    assert with_tables(page) == page.read_text(), "rewrite them: python tests/test_docs.py --write"


def _routes(router: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield method and path of every route in the OpenAPI schema, found without that schema."""
    for route in router.routes:
        inner = getattr(route, "original_router", None)
        if inner is not None:
            yield from _routes(inner, prefix)
        elif isinstance(route, APIRoute) and route.include_in_schema:
            yield from ((method, prefix + route.path) for method in route.methods or ())


def test_every_public_route_is_named() -> None:
    routes = set(_routes(create_app(Settings())))
    assert ("PUT", "/api/logs") in routes
    text = SERVICE.read_text()
    assert [f"{method} {path}" for method, path in sorted(routes) if f"| `{method} {path}` |" not in text] == []


@pytest.mark.parametrize("command", re.findall(r"^    curl (.+)$", SERVICE.read_text(), re.MULTILINE))
def test_every_curl_address_is_a_route(command: str) -> None:
    (address,) = re.findall(r"http://127\.0\.0\.1:8000(/[^\s\"?]*)", command)
    method = "PUT" if " -T " in f" {command}" else "POST" if " --json " in f" {command}" else "GET"
    routes = _routes(create_app(Settings()))
    assert any(m == method and re.fullmatch(re.sub(r"\{\w+\}", "ID", path), address) for m, path in routes)


@pytest.mark.parametrize("name", Settings.model_fields)
def test_every_setting_is_documented(name: str) -> None:
    description = Settings.model_fields[name].description or ""
    assert description.endswith(".")


@pytest.mark.parametrize("command", re.findall(r"^    gridbloom (.+)$", COMMANDS, re.MULTILINE))
def test_every_command_of_the_docs_exists(command: str) -> None:
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


def test_the_long_tests_are_listed() -> None:
    root = README.parent
    marked = {
        str(path.relative_to(root))
        for path in (root / "tests").rglob("*.py")
        if path.name.startswith(("test_", "conftest"))
        and re.search(r"pytest\.mark\.(long|sampled)\b|\balso_long(_rows)?\(", path.read_text())
    }
    assert set(re.findall(r"^\| `(tests/[^`]+)`", TESTING.read_text(), flags=re.MULTILINE)) == marked


def layers_of(contract: dict[str, Any]) -> list[set[str]]:
    return [set(re.split(r"\s*[|:]\s*", layer)) for layer in contract["layers"]]


def test_the_picture_of_the_layers_is_that_of_the_contracts() -> None:
    """Each column of the picture, from the top down, names what its contract does; two lines may be one layer."""
    text = (DOCS / "architecture.md").read_text()
    (picture,) = re.findall(r"(?s)```text\n(mapper .*?)\n\n", text)
    header, rule, *lines = picture.splitlines()
    columns = [(m.start(), m.end()) for m in re.finditer(r"─+", rule)]
    drawn = {header[a:b].strip(): [line[a:b].split() for line in lines] for a, b in columns}

    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    stated = {one["containers"][0]: layers_of(one) for one in contracts if one["type"] == "layers"}
    (front,) = re.findall(r"const LAYERS = (\[.*\]);", (ROOT / "static/.dependency-cruiser.cjs").read_text())
    stated["static/src"] = [set(layer) for layer in json.loads(front)]
    for column, rows in drawn.items():
        rest = [name for row in rows for name in row]
        for layer in stated[column]:
            assert set(rest[: len(layer)]) == layer, f"{column}: the next layer is {layer}"
            rest = rest[len(layer) :]
        assert rest == []


def test_the_site_draws_every_package_of_the_layers() -> None:
    hooks = runpy.run_path(str(DOCS / "hooks.py"))
    picture = hooks["picture_of_layers"]()
    named = set(re.findall(r"<title>([^:]+): [\d,]+ lines", picture))
    packages = {path.name for path in (ROOT / "mapper").iterdir() if (path / "__init__.py").exists()}
    assert named >= packages >= {"core", "volume"}
    assert "0 lines" not in re.findall(r": (\d+ lines)", picture)
    text = (DOCS / "architecture.md").read_text()
    assert picture in hooks["on_page_markdown"](text)


@cache
def names_in(path: Path) -> set[str]:
    """Every name that a Python or TypeScript file defines at its top level, and Class.member."""
    if path.suffix == ".py":
        names = set()
        for node in ast.parse(path.read_text()).body:
            for name in defined_by(node):
                names.add(name)
                if isinstance(node, ast.ClassDef):
                    names.update(f"{name}.{member}" for inner in node.body for member in defined_by(inner))
        return names
    names, inside = set(), None
    for line in path.read_text().splitlines():
        found = re.match(r"(?:export )?(?:abstract )?(?:async )?(?:class|function|const|interface|type) (\w+)", line)
        if found:
            inside = found[1]
            names.add(inside)
        member = re.match(r"  (?:async |static |readonly |get |set )*(#?\w+)[(:= ]", line)
        if member and inside:
            names.add(f"{inside}.{member[1]}")
    return names


def defined_by(node: ast.stmt) -> list[str]:
    """The names that one statement defines."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        return [node.name]
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return [target.id for target in targets if isinstance(target, ast.Name)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_path_and_name_of_the_docs_exists(page: Path) -> None:
    roots = "mapper|server|static|tests|examples|docs|requirements"
    spans = [span for span in re.findall(r"`([^`\n]+)`", page.read_text()) if "NAME" not in span]
    named = [span for span in spans if re.fullmatch(rf"(?:{roots})/[\w./-]*(?:::[\w.#]+)?", span)]
    generated = ("static/dist", "static/node_modules")
    for span in named:
        path, _, name = span.partition("::")
        assert (ROOT / path).exists() or path.startswith(generated), f"{span}: there is no {path}"
        assert not name or name in names_in(ROOT / path), f"{span}: {path} does not define {name}"
    if page.parent == DOCS and page.stem == "architecture":
        assert len(named) > 100


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_between_pages_leads_to_a_file(page: Path) -> None:
    links = re.findall(r"(?<!!)\[[^]]*\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text())
    assert [link for link in links if "://" not in link and not (page.parent / link).exists()] == []


def test_every_page_is_in_the_navigation() -> None:
    entries = re.findall(r"^ +- (\S+\.md)$", (ROOT / "mkdocs.yml").read_text(), flags=re.MULTILINE)
    assert sorted(entries) == sorted(str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md"))


def test_every_picture_is_there() -> None:
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", README.read_text())
    assert pictures
    assert all((README.parent / picture).is_file() for picture in pictures)


if __name__ == "__main__" and "--write" in sys.argv:
    for one in TABLES:
        one.write_text(with_tables(one))
