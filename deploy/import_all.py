"""Import every module of the packages, and all that they name, so that Python keeps the bytecode of what is used.

The image is built without bytecode and has that of these modules only. A name that cannot be imported ends the build:
what was left out of the image is then needed. Modules of extras, which the image does not have, may be missing.
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
from collections.abc import Iterator
from pathlib import Path

import numba

PACKAGES = ("mapper", "server")
EXTRAS = {"distributed"}  #: of gridbloom[dask]


def names_of(package: str) -> Iterator[tuple[str, str | None]]:
    """Yield the modules of a package, and the modules and names that they import, at any place."""
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"{package} is not installed")
    root = Path(spec.origin).parent
    for path in sorted(root.rglob("*.py")):
        if "migrations" in path.parts:  # which Alembic runs
            continue
        parts = path.relative_to(root.parent).with_suffix("").parts
        yield ".".join(parts).removesuffix(".__init__"), None
        for node in _used(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                yield from ((one.name, None) for one in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                yield from ((node.module, one.name) for one in node.names)


def _used(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a module that are more than annotations for type checkers."""
    for node in ast.iter_child_nodes(tree):
        is_typing = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        if not is_typing:
            yield node
            yield from _used(node)


def main() -> None:
    """Import them, and have numba compile a function, which imports more."""
    wanted = sorted({one for package in PACKAGES for one in names_of(package)}, key=str)
    for module, name in wanted:
        try:
            found = importlib.import_module(module)
            if name is not None and not hasattr(found, name):
                importlib.import_module(f"{module}.{name}")
        except ModuleNotFoundError as error:
            if error.name is None or error.name.partition(".")[0] not in EXTRAS:
                raise
    numba.njit(lambda x: x + 1)(1)
    print(f"{len(wanted)} names were imported")


if __name__ == "__main__":
    main()
