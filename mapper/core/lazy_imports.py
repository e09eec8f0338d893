"""Imports put off until they are needed, and imports of optional modules left out."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module


def attributes_from(package: str, modules: Mapping[str, str]) -> Callable[[str], object]:
    """Return the function ``__getattr__`` of a package (PEP 562).

    ``modules`` maps each name that the package offers to the module that defines it, which is imported when the name
    is first read. Other names raise :class:`AttributeError`.
    """

    def get(name: str) -> object:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(modules[name]), name)

    return get


@contextmanager
def hidden_modules(*names: str) -> Iterator[None]:
    """Make imports of these modules raise :class:`ImportError` during the block, unless they are loaded already.

    For packages that import a module where it is installed, and do without it otherwise. Not safe while other threads
    import.
    """
    hidden = [name for name in names if name not in sys.modules]
    for name in hidden:
        sys.modules[name] = None  # type: ignore[assignment] # which makes an import fail
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]
