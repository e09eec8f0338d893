"""Score around the relative pose of two scans, and the basin of attraction of each method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.matching.fields import GREATEST
from mapper.matching.kernels.types import ScanArrays
from mapper.matching.match import match_scan
from mapper.matching.parameters import MatchConfig
from mapper.matching.search import window_scores
from mapper.matching.target import Target
from mapper.matching.task import Task

MOST_STARTS = 10_000
FOUND_M, FOUND_RAD = 0.10, np.deg2rad(2.0)  #: a method that ends nearer than both has found the pose


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


@dataclass(frozen=True, slots=True)
class Basin:
    """From where a method finds a pose: ``offsets`` (n,) metres of rows (y) and columns (x) from it, ``turn`` radians.

    ``ends`` (n, n, 3) are the poses at which the method ends, ``found`` (n, n) whether that is the pose, ``scores``
    (n, n) how well both sides agree there.
    """

    offsets: Float64Array
    turn: float
    ends: Float64Array
    found: np.ndarray
    scores: Float64Array


def basin_of_attraction(
    source: ScanArrays,
    index: int,
    target: Target,
    pose: Float64Array,
    config: MatchConfig,
    *,
    reach: float = 1.0,
    starts: int = 21,
    turn: float = 0.0,
) -> Basin:
    """Return where a method ends from ``starts`` × ``starts`` guesses up to ``reach`` metres around ``pose`` (3,).

    All guesses are turned by ``turn`` radians. Found is the pose where the end is nearer than 0.10 m and 2°; a guess
    from which nothing is found ends where it began, with the score 0. Raises :class:`ConfigError` for more than 100
    guesses along a side or none, and what :func:`match_scan` raises for reasons that do not depend on the guess.
    """
    if not 1 <= starts <= int(MOST_STARTS**0.5):
        raise ConfigError("matching.starts", f"A basin has 1 to {int(MOST_STARTS**0.5)} guesses a side, not {starts}.")
    pose = np.asarray(pose, dtype=np.float64)
    Task(source, index, target, pose, config)
    offsets = np.linspace(-reach, reach, starts)
    ends, scores = np.empty((starts, starts, 3)), np.zeros((starts, starts))
    for row, col in np.ndindex(starts, starts):
        guess = pose + np.array([offsets[col], offsets[row], turn])
        try:
            match = match_scan(source, index, target, guess, config)
            ends[row, col], scores[row, col] = match.pose, match.score
        except ConfigError as error:
            if error.code != "matching.apart":  # nothing near in the window of this guess
                raise
            ends[row, col] = guess
    off = compose(inverse(pose), ends)
    found = (np.hypot(off[..., 0], off[..., 1]) < FOUND_M) & (np.abs(wrap_angle(off[..., 2])) < FOUND_RAD)
    return Basin(offsets, turn, ends, found, scores)
