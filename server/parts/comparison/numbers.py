"""The numbers of a comparison of two maps, for JSON."""

from __future__ import annotations

from typing import Any

from mapper.grid.compare import Comparison


def numbers(found: Comparison) -> dict[str, Any]:
    """Return the numbers of a comparison as a dictionary for JSON."""
    return {
        "cells": found.cells,
        "states": found.states.tolist(),
        "same": found.same,
        "only": list(found.only),
        "both": found.both,
        "entropy_bits": [round(bits, 1) for bits in found.entropy_bits],
        "contrast": [round(contrast, 4) for contrast in found.contrast],
        "mean_difference": round(found.mean_difference, 4),
        "max_difference": round(found.max_difference, 4),
        "max_at": None if found.max_at_xy is None else [round(v, 4) for v in found.max_at_xy],
    }


def comparison_message(index: int, found: Comparison | None = None, refused: str | None = None) -> dict[str, Any]:
    """Return a ``comparison`` message: the numbers, or the reason why the maps cannot be compared."""
    return {
        "type": "comparison",
        "index": index,
        "refused": refused,
        "numbers": None if found is None else numbers(found),
    }
