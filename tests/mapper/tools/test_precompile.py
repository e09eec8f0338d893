"""``python -m mapper.tools.precompile`` compiles every kernel."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mapper.tools import precompile


@pytest.mark.long
def test_every_kernel_is_ready_where_all_are_kept_from_a_run_before():
    # `make test` has run it before the tests. What only kernels call is then not compiled of itself.
    environment = {key: value for key, value in os.environ.items() if key != "NUMBA_DISABLE_JIT"}
    done = subprocess.run(
        [sys.executable, "-m", "mapper.tools.precompile"], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    ready, of, total, *_ = done.stdout.split()
    assert of == "of"
    assert int(ready) == int(total) >= 10


def test_a_kernel_that_it_leaves_out_is_named(monkeypatch, capsys):
    monkeypatch.setattr(precompile, "precompile", lambda: None)
    monkeypatch.setattr(precompile, "_compile_parts", lambda: None)
    monkeypatch.setattr(
        precompile, "kernels", lambda: {"mapper.grid.kernels.a.used": True, "mapper.grid.kernels.a.forgotten": False}
    )
    assert precompile.main() == 1
    assert "mapper.grid.kernels.a.forgotten was not compiled" in capsys.readouterr().err


def names_used(path: Path) -> set[str]:
    """Return the full names that a file imports from modules, and those of the modules that it imports by name."""
    tree = list(ast.walk(ast.parse(path.read_bytes())))
    imported = {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in tree
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    attributes = {
        f"{imported[node.value.id]}.{node.attr}"
        for node in tree
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in imported
    }
    return attributes | set(imported.values())


def test_every_kernel_with_a_public_name_is_called_from_python():
    # Those that only kernels call are not compiled of themselves where their code is kept from a run before.
    sources = [*Path("mapper").rglob("*.py"), *Path("server").rglob("*.py")]
    users = [path for path in sources if path.parent.name != "kernels" and b"kernels" in path.read_bytes()]
    called = set().union(*(names_used(path) for path in users))
    assert set(precompile.kernels()) <= called


def test_all_modules_of_kernels_are_looked_at():
    modules = {".".join(path.with_suffix("").parts) for path in Path("mapper").glob("*/kernels/*.py")}
    compiled = {name.rsplit(".", 1)[0] for name in precompile.kernels()}
    assert {"mapper.simulation.kernels.raycast", "mapper.mapping.kernels.bresenham"} <= compiled <= modules
    assert {"mapper.simulation.kernels.lidar.cast_rays", "mapper.grid.kernels.quantise.quantise"} <= set(
        precompile.kernels()
    )
