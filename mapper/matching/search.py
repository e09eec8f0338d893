"""Initial poses of a refinement: the guess, or the best poses of a window around it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int32Array, Int64Array, UInt8Array
from mapper.grid import GridGeometry
from mapper.matching.features import poses_by_features
from mapper.matching.fields import GREATEST
from mapper.matching.kernels.correlative import (
    Window,
    best_in_window,
    best_modes,
    branch_and_bound,
    score_window,
)
from mapper.matching.kernels.score_field import write_pyramid
from mapper.matching.kernels.types import ScanArrays
from mapper.matching.parameters import MatchConfig
from mapper.matching.target import Target
from mapper.matching.task import TOP_LEVEL, Task

APART_M, APART_RAD = 0.4, 0.25  #: two modes are farther apart than one of these


def _pose(task: Task, best: Int64Array) -> Float64Array:
    _, turn, row, col = best
    cell = task.config.field_resolution
    return np.asarray(task.guess + np.array([col * cell, row * cell, turn * task.window.turn]))


def at_guess(task: Task) -> Float64Array:
    """Return the guess (1, 3)."""
    return task.guess[np.newaxis].copy()


def _levels(task: Task) -> tuple[GridGeometry, UInt8Array]:
    geometry, scores = task.score_field(task.config.field_resolution, task.config.field_sigma)
    levels: UInt8Array = np.empty((TOP_LEVEL + 1, *scores.shape), dtype=np.uint8)
    write_pyramid(scores, levels)
    return geometry, levels


def modes(task: Task) -> Float64Array:
    """Return the best modes of the window (k, 3), best first."""
    config = task.config
    geometry, levels = _levels(task)
    best = np.empty((int(config.modes), 4), dtype=np.int64)
    apart = Window(round(APART_M / config.field_resolution), round(APART_RAD / config.turn_step), 0.0)
    best_modes(
        levels, geometry.frame, task.source, task.index, task.guess, task.window, task.stride, 1, config.mode_share,
        apart, best,
    )  # fmt: skip
    return np.array([_pose(task, row) for row in best if row[0] > 0]).reshape(-1, 3)


def by_branch_and_bound(task: Task) -> Float64Array:
    """Return the best pose of the window, (1, 3), or (0, 3) if no point falls near the target."""
    geometry, levels = _levels(task)
    best = np.empty(4, dtype=np.int64)
    branch_and_bound(levels, geometry.frame, task.source, task.index, task.guess, task.window, 1, 1, best)
    return _pose(task, best)[np.newaxis] if best[0] > 0 else np.empty((0, 3))


def window_scores(task: Task) -> Int32Array:
    """Return the score of every pose of the window (turns, rows, columns) int32, with the guess at its centre."""
    geometry, scores = task.score_field(task.config.field_resolution, task.config.field_sigma)
    window = task.window
    size = 2 * window.cells + 1
    volume = np.empty((2 * window.turns + 1, size, size), dtype=np.int32)
    score_window(scores, geometry.frame, task.source, task.index, task.guess, window, 1, volume)
    return volume


def exhaustive(task: Task) -> Float64Array:
    """Return the result of :func:`by_branch_and_bound` by scoring every pose."""
    best = np.empty(4, dtype=np.int64)
    best_in_window(window_scores(task), best)
    return _pose(task, best)[np.newaxis] if best[0] > 0 else np.empty((0, 3))


SEARCHES: Mapping[str, Callable[[Task], Float64Array]] = {
    "guess": at_guess,
    "modes": modes,
    "branch_and_bound": by_branch_and_bound,
    "exhaustive": exhaustive,
    "features": poses_by_features,
}


@dataclass(frozen=True, slots=True)
class ScoreLandscape:
    """The score of the poses around a guess, 0 to 1: the mean score of the points in the field.

    ``offsets`` (n,) metres are those of rows (y) and columns (x), ``turns`` (k,) radians those of the angle. ``slice``
    (n, n) is the score at the guess's angle, ``greatest`` (n, n) the maximum over all angles and ``turn_of`` (n, n) the
    index of its angle; ``by_turn`` (k,) is the maximum over all positions.
    """

    offsets: Float64Array
    turns: Float64Array
    slice: Float32Array
    greatest: Float32Array
    turn_of: Int64Array
    by_turn: Float32Array


def score_landscape(
    source: ScanArrays, index: int, target: Target, guess: Float64Array, config: MatchConfig
) -> ScoreLandscape:
    """Return the score landscape over the window of ``config``; every pose in it is scored.

    Raises the errors of :class:`Task` for the method "exhaustive", also for a window of too many poses.
    """
    task = Task(source, index, target, guess, config.with_values({"method": "exhaustive"}))
    window, cell = task.window, config.field_resolution
    points = int(np.count_nonzero(source.kind[index]))
    volume = (window_scores(task) / (GREATEST * points)).astype(np.float32)
    turn_of = volume.argmax(axis=0)
    return ScoreLandscape(
        np.asarray(np.arange(-window.cells, window.cells + 1) * cell, dtype=np.float64),
        np.asarray(np.arange(-window.turns, window.turns + 1) * window.turn, dtype=np.float64),
        volume[window.turns],
        np.take_along_axis(volume, turn_of[np.newaxis], axis=0)[0],
        turn_of,
        volume.max(axis=(1, 2)),
    )
