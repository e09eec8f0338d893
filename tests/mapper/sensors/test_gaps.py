"""Which pauses are gaps, by what is written of them."""

from __future__ import annotations

import numpy as np

from mapper.sensors.gaps import are_gaps


def gaps(*pauses_s: float) -> list[bool]:
    found: list[bool] = are_gaps(np.array(pauses_s)).tolist()
    return found


def test_more_than_a_second_and_five_times_the_usual_pause() -> None:
    assert gaps(0.1, 0.1, 0.9, 0.1, 1.1) == [False, False, False, False, True]
    assert gaps(1.0, 1.0, 4.9, 5.1, 1.0) == [False, False, False, True, False]


def test_equal_and_decreasing_times_are_not_usual() -> None:
    assert gaps(0.0, 0.0, 0.0, 2.0, 2.0, -1.0, 11.0) == [False] * 6 + [True]


def test_none_of_none_and_of_a_log_without_times() -> None:
    assert gaps() == []
    assert gaps(0.0, 0.0) == [False, False]
