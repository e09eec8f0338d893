"""Which of two programs sent which transform, against transforms whose sender is known."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.array_types import BoolArray, Float64Array
from mapper.io.logs.recording.senders import senders_of


def driven(n: int, start: tuple[float, float] = (0.0, 0.0), speed: float = 1.0) -> Float64Array:
    """Poses (n, 7) along a curve."""
    t = speed * np.linspace(0.0, 6.0, n)
    yaw = 0.4 * np.sin(t)
    columns = (start[0] + t, start[1] + np.sin(t), 0 * t, 0 * t, 0 * t, np.sin(0.5 * yaw), np.cos(0.5 * yaw))
    return np.stack(columns, axis=-1)


def in_turns(a: Float64Array, b: Float64Array, seed: int) -> tuple[Float64Array, BoolArray]:
    """Poses of two senders in an order of chance, and which are of the second."""
    which = np.random.default_rng(seed).permutation(np.repeat([False, True], [len(a), len(b)]))
    out = np.empty((len(a) + len(b), 7))
    out[~which], out[which] = a, b
    return out, which


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("n", "other"), [(200, 200), (100, 1000), (400, 60)])
def test_two_senders_are_told_apart(n: int, other: int, seed: int) -> None:
    poses, which = in_turns(driven(n), driven(other, (3.0, -2.0), 0.9), seed)
    found = senders_of(poses)
    assert found is not None
    first, second = found
    assert np.array_equal(second, which) or np.array_equal(first, which)
    assert np.array_equal(first, ~second)


@pytest.mark.parametrize("seed", range(5))
def test_the_one_that_stands_is_the_second(seed: int) -> None:
    still = np.tile(driven(1, (8.0, 4.0)), (700, 1))
    poses, which = in_turns(driven(200), still, seed)
    found = senders_of(poses)
    assert found is not None
    assert np.array_equal(found[1], which)


ALONE = {
    "a drive": driven(300),
    "few": driven(30),
    "noise": driven(300) + np.random.default_rng(1).normal(0.0, 0.3, (300, 7)) * ([1.0] * 3 + [0.0] * 4),
    "corrected once": np.concatenate([driven(150), driven(150, (3.0, 2.0))]),
    "corrected every second": driven(300) + np.outer(np.arange(300) % 10 * 0.05, [1.0] + [0.0] * 6),
    "a loop closed": np.concatenate([driven(100), driven(100, (5.0, 5.0)), driven(100)]),
}


@pytest.mark.parametrize("name", ALONE)
def test_one_sender_is_one(name: str) -> None:
    assert senders_of(ALONE[name]) is None


def test_what_comes_before_they_part_is_of_both() -> None:
    waiting = np.tile(driven(1), (100, 1))
    poses, which = in_turns(driven(300), np.tile(driven(1), (300, 1)), 3)
    found = senders_of(np.concatenate([waiting, poses]))
    assert found is not None
    assert found[0][:100].all()
    assert found[1][:100].all()
    far = np.flatnonzero(~which)[30] + 100
    assert np.array_equal(found[1][far:], which[far - 100 :])
