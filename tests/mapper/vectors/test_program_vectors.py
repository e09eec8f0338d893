"""The lines of textbook Python that a scan executes: the lecture must highlight the same lines.

``python tests/mapper/vectors/test_program_vectors.py --write`` rewrites the vectors after a change of the textbook.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping import textbook
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import LaserScan

VECTORS = Path(__file__).parents[3] / "static" / "src" / "lessons" / "program" / "program.vectors.json"
TRACED = (3, 11)  #: the Python whose line events are kept
SHOWN = ("update_per_beam", "evidence_of_beam", "evidence_along_beam", "update", "bayes_filter")
GEOMETRY: dict[str, Any] = {"resolution": 0.25, "rows": 8, "cols": 10, "origin": (0.0, 0.0, 0.0)}
POSE = (0.65, 0.85, 0.3)
#: beams that end, one without return, one too near, one that leaves the grid
RANGES = (0.9, 1.3, float("inf"), 0.01, 2.6, 0.5)


def executed() -> tuple[list[list[Any]], list[list[float]]]:
    """Return [function, line after its ``def``] of every line that ran, and [index, log-odds] of each observed cell."""
    ran: list[list[Any]] = []

    def trace(frame: FrameType, event: str, _: object) -> Any:
        code = frame.f_code
        if code.co_filename != textbook.__file__ or code.co_name not in SHOWN:
            return None
        if event == "line":
            ran.append([code.co_name, frame.f_lineno - code.co_firstlineno])
        return trace

    grid = OccupancyGrid(GridGeometry(**GEOMETRY))
    scan = LaserScan(np.array(RANGES, np.float32), -0.7, 0.45, 0.05, 3.0)
    config, before = MappingConfig(resolution=0.25), sys.gettrace()
    sys.settrace(trace)
    try:
        textbook.update_per_beam(grid, scan, POSE, config)
    finally:
        sys.settrace(before)
    flat = grid.log_odds.ravel()
    return ran, [[int(i), float(flat[i])] for i in np.flatnonzero(grid.observed.ravel())]


def vectors() -> dict[str, Any]:
    """Return the scan, the lines that ran, and the cells."""
    lines, cells = executed()
    ranges = [str(value) if np.isinf(value) else value for value in RANGES]
    return {"geometry": GEOMETRY, "pose": POSE, "ranges": ranges, "lines": lines, "cells": cells}


def text() -> str:
    return json.dumps(vectors(), separators=(",", ":")) + "\n"


def test_the_lines_that_the_lecture_lights_are_those_that_run():
    hint = "run: python tests/mapper/vectors/test_program_vectors.py --write"
    stored, fresh = json.loads(VECTORS.read_text()), json.loads(text())
    if sys.version_info[:2] != TRACED:
        # Which events a line gives differs from one Python to the next; what runs does not.
        del stored["lines"], fresh["lines"]
    assert stored == fresh, hint


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(text())
