"""The ``gridbloom`` command.

``serve`` runs the service, ``upload`` sends a log to one, ``notes`` gets the notes on it; all other commands work on
files. What is slow to import is imported where it is used, so that the command starts quickly. Bad input is one
sentence on standard error and exit status 2; a log that does not keep the limits of ``check`` is exit status 1. With
``--json`` standard output is one JSON object and nothing else.
"""

from __future__ import annotations

# Each adds its commands, which `--help` lists in this order.
from server.cli import service  # noqa: F401

# isort: split
from server.cli import logs  # noqa: F401

# isort: split
from server.cli import check as checking  # noqa: F401

# isort: split
from server.cli import report as reporting  # noqa: F401

# isort: split
from server.cli import maps  # noqa: F401

# isort: split
from server.cli import why as asking  # noqa: F401

# isort: split
from server.cli import merge as merging  # noqa: F401

# isort: split
from server.cli import compare as comparing  # noqa: F401

# isort: split
from server.cli import evaluate as evaluating  # noqa: F401

# isort: split
from server.cli import match as matching  # noqa: F401

# isort: split
from server.cli import slam as correcting  # noqa: F401

# isort: split
from server.cli import localize as localizing  # noqa: F401

# isort: split
from server.cli import edit as editing  # noqa: F401

# isort: split
from server.cli import costmap as costing  # noqa: F401

# isort: split
from server.cli import path as planning  # noqa: F401

# isort: split
from server.cli import map3d as mapping_in_3d  # noqa: F401

# isort: split
from server.cli import terrain as assessing  # noqa: F401

# isort: split
from server.cli import fleet as many  # noqa: F401

# isort: split
from server.cli import bench as measuring  # noqa: F401

# isort: split
from server.cli.common import SHORT_NAMES, app

__all__ = ["SHORT_NAMES", "app", "main"]


def main() -> None:
    """Run the command line."""
    app(prog_name="gridbloom")
