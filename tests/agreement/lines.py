"""The cells of one line, by the kernels and by the textbook."""

from __future__ import annotations

from typing import Any

import numpy as np

from mapper.mapping import textbook_traversal as traversal
from mapper.mapping.kernels.amanatides_woo import draw_rays
from mapper.mapping.kernels.bresenham import draw_lines
from mapper.mapping.kernels.contributions import contributions_of_rays
from mapper.mapping.kernels.types import Cells, Evidence, LogOddsUpdate
from mapper.mapping.update import NO_ENDS
from tests.agreement.inputs import LineCase, RayCase


def line_by_kernel(case: LineCase) -> tuple[Any, ...]:
    drawn, observed = np.zeros(case.shape, dtype=np.float32), np.zeros(case.shape, dtype=np.bool_)
    (rows, cols), steps = case.shape, max(abs(case.end[0] - case.start[0]), abs(case.end[1] - case.start[1]))
    box = np.array([rows, 0, cols, 0])
    line = np.array([[*case.start, *case.end, steps + 1, steps + 1, -1, -1, -1]], dtype=np.int32).T.copy()
    one, nothing, low, high = (np.float32(n) for n in (1, 0, -100, 100))
    cells = Cells(drawn.reshape(-1), observed.reshape(-1), cols)
    draw_lines(cells, line, LogOddsUpdate(one, nothing, low, high), False, NO_ENDS, 0, rows, box, True)
    return drawn, observed, box if drawn.any() else None


def line_by_textbook(case: LineCase) -> tuple[Any, ...]:
    drawn = np.zeros(case.shape, dtype=np.float32)
    for row, col in traversal.bresenham(case.start, case.end):
        if 0 <= row < case.shape[0] and 0 <= col < case.shape[1]:
            drawn[row, col] += 1
    rows, cols = np.nonzero(drawn)
    return drawn, drawn > 0, np.array([rows.min(), rows.max() + 1, cols.min(), cols.max() + 1]) if len(rows) else None


def ray_by_kernel(case: RayCase) -> tuple[Any, ...]:
    drawn, observed = np.zeros(case.shape, dtype=np.float32), np.zeros(case.shape, dtype=np.bool_)
    touched = np.zeros(case.shape, dtype=np.int64)
    rows, cols = case.shape
    ray = np.array([[*case.start, *case.end, *case.end, np.inf, 0.0]])
    one, nothing, low, high = (np.float32(n) for n in (1, 0, -100, 100))
    cells, box = Cells(drawn.reshape(-1), observed.reshape(-1), cols), np.array([rows, 0, cols, 0])
    update = LogOddsUpdate(one, nothing, low, high)
    draw_rays(cells, ray, 1.0, False, Evidence(1.0, 0.0), update, NO_ENDS, 0, rows, box, True)
    for row, col in np.ndindex(case.shape):
        touched[row, col] = contributions_of_rays(ray, 1.0, row, col, np.empty((1, 2), dtype=np.int64))
    return drawn, observed, touched, box if drawn.any() else None


def ray_by_textbook(case: RayCase) -> tuple[Any, ...]:
    drawn = np.zeros(case.shape, dtype=np.float32)
    for row, col in traversal.amanatides_woo(case.start, case.end):
        if 0 <= row < case.shape[0] and 0 <= col < case.shape[1]:
            drawn[row, col] += 1
    rows, cols = np.nonzero(drawn)
    box = np.array([rows.min(), rows.max() + 1, cols.min(), cols.max() + 1]) if len(rows) else None
    return drawn, drawn > 0, (drawn > 0).astype(np.int64), box
