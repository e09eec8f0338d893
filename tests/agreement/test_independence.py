"""What a textbook twin computes with is its own, but for what the table says; the product uses no textbook."""

import ast
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tests.agreement.table import SHARED, TABLE, Row

ROOT = Path(__file__).parents[2]
#: poses, grids and scans, which both sides have, and the parameters of a case
COMMON = ("mapper.core.", "mapper.grid.", "mapper.sensors.")


def modules_of(function: Callable[[Any], object], case: Any) -> set[str]:
    """The product's modules whose functions run."""
    called: set[str] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            called.add(str(frame.f_globals.get("__name__", "")))

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        function(case)
    finally:
        sys.setprofile(before)
    return {
        name
        for name in called
        if name.startswith("mapper.")
        and not name.startswith(COMMON)
        and not name.endswith(".parameters")
        and "textbook" not in name
    }


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row.name)
@given(data=st.data())
@settings(max_examples=1, deadline=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
def test_a_twin_uses_of_the_product_what_the_table_says(row: Row, data: st.DataObject) -> None:
    stated = {module for module, rows in SHARED.items() if row.name in rows}
    assert modules_of(row.twin, data.draw(row.inputs)) <= stated


def imports_of(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@pytest.mark.parametrize("package", ["mapper", "server"])
def test_only_textbooks_import_textbooks(package: str) -> None:
    files = [path for path in (ROOT / package).rglob("*.py") if "textbook" not in path.name]
    assert len(files) > 100
    for path in files:
        if b"textbook" not in path.read_bytes():
            continue
        assert [name for name in imports_of(path) if "textbook" in name] == [], path
