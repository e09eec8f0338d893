"""Score around the relative pose of two scans."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int64Array
from mapper.matching.fields import GREATEST
from mapper.matching.kernels.types import ScanArrays
from mapper.matching.parameters import MatchConfig
from mapper.matching.search import window_scores
from mapper.matching.target import Target
from mapper.matching.task import Task


@dataclass(frozen=True, slots=True)
class ScoreLandscape:
    """The score of the poses around a guess, 0 to 1: the mean score of the points in the field.

    ``offsets`` (n,) metres are those of rows (y) and columns (x), ``turns`` (k,) radians those of the angle.
    ``slice`` (n, n) is the score at the guess's angle, ``greatest`` (n, n) the greatest over all angles and ``turn_of``
    (n, n) the index of the angle at which it is; ``by_turn`` (k,) is the greatest over all places.
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
    """Return the score landscape in the window of ``config``, which every pose of is scored.

    Raises what :class:`Task` raises for the method "exhaustive", also for a window of too many poses.
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
