"""The commands of ``python -m tests.load`` name functions of the service that exist."""

from __future__ import annotations

import importlib

from tests.load import ticks
from tests.load.spans import Spans


def test_every_command_can_be_imported():
    importlib.import_module("tests.load.__main__")


def test_the_parts_of_a_tick_are_counted_in_functions_that_exist():
    spans = Spans()
    try:
        ticks._counted(spans)  # raises AttributeError for a function that was renamed or moved
    finally:
        spans.close()
