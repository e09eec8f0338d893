"""Marks of cases that only ``make test-long`` runs."""

from __future__ import annotations

from typing import Any

import pytest


def also_long(*cases: Any) -> list[Any]:
    """Return the values of one parameter, marked so that ``make test`` leaves them to ``make test-long``."""
    return [pytest.param(case, marks=pytest.mark.long) for case in cases]


def also_long_rows(*rows: tuple[Any, ...]) -> list[Any]:
    """Return the values of several parameters, a row for each case, marked like those of :func:`also_long`."""
    return [pytest.param(*row, marks=pytest.mark.long) for row in rows]
