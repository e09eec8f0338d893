"""Deferred imports, and imports of optional modules suppressed."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.abc import MetaPathFinder
from pathlib import Path
from threading import get_ident


def imported_later(package: str, file: str) -> Callable[[str], object]:
    """Return a package's ``__getattr__`` (PEP 562) that imports each name on first use.

    The names are those that ``file``, the package's ``__file__``, imports under ``if TYPE_CHECKING``. Others raise
    :class:`AttributeError`. No name may equal the name of a module of the package, because that module would replace
    it.
    """

    @cache
    def modules() -> dict[str, str]:
        tree = ast.parse(Path(file).read_text(encoding="utf-8"))
        later = (node for branch in tree.body if isinstance(branch, ast.If) for node in branch.body)
        return {
            name.name: str(node.module) for node in later if isinstance(node, ast.ImportFrom) for name in node.names
        }

    def get(name: str) -> object:
        if name not in modules():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(modules()[name]), name)

    return get


class _Hidden(MetaPathFinder):
    """A module finder that hides some modules from the thread that created it."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = frozenset(names)
        self._thread = get_ident()

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:  # noqa: ARG002 - as called
        if fullname in self._names and get_ident() == self._thread:
            raise ModuleNotFoundError(f"{fullname} is left out here", name=fullname)


@contextmanager
def hidden_modules(*names: str) -> Iterator[None]:
    """Make imports of these modules raise :class:`ImportError` within the block, unless they are already loaded.

    Used for packages that import an optional module if it is installed. Imports in other threads are not affected.
    """
    finder = _Hidden(names)
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
