"""The version of the installed package."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version


def package_version() -> str:
    """Return the version of the package, or ``0+checkout`` for an uninstalled checkout."""
    try:
        return version("gridbloom")
    except PackageNotFoundError:
        return "0+checkout"
