"""What visitors leave behind levels off, whatever happens meanwhile to the database, the disk and the clock."""

from __future__ import annotations

import os
from dataclasses import replace

import pytest

from tests.load.soak import ALLOWED, KEPT, PARTS, STEP, Left, soak, verdict

ROUGH = [0.0, 1.0, -1.0, 0.5, -0.5, 1.0, 0.0, -1.0]


def life(*memory_mb: float) -> list[Left]:
    """Counts of a life of a hundred visits in each part."""
    return [Left(100 * n, 280.0 + mb + ROUGH[n], 30, 20, 5, 0) for n, mb in enumerate(memory_mb)]


@pytest.mark.parametrize(
    ("counts", "is_level"),
    [
        (life(0, 20, 30, 35, 35, 35, 35, 35), True),  # the first half warms up
        (life(0, 0, 0, 0, 0, 13, 13, 13), True),
        (life(0, 0, 0, 0, 0, 0, 0, 13), False),  # what follows is not known
        (life(0, 0, 0, 0, 10, 10, 20, 20), False),
        (life(0, 0, 0, 0, 0, 40, 40, 40), False),
        (life(*(3.0 * part for part in range(PARTS))), False),
    ],
)
def test_memory_may_grow_by_one_step_that_levels_off(counts: list[Left], is_level: bool) -> None:
    assert verdict([life(*[0.0] * PARTS), counts]) is is_level


def test_what_is_counted_exactly_has_no_step() -> None:
    assert set(STEP) < set(ALLOWED)
    settled = life(*[0.0] * PARTS)
    grown = [replace(one, threads=one.threads + 10 * (n > PARTS // 2)) for n, one in enumerate(settled)]
    assert not verdict([settled, grown])


@pytest.mark.parametrize("what", KEPT)
def test_what_is_kept_on_the_disk_may_not_grow(what: str) -> None:
    settled = life(*[0.0] * PARTS)
    grown = [replace(one, **{what: getattr(one, what) + KEPT[what] + 1}) for one in settled]
    assert verdict([settled, settled])
    assert not verdict([settled, grown])


@pytest.mark.long
def test_a_soak_ends_with_a_clean_verdict() -> None:
    soak(int(os.environ.get("GRIDBLOOM_SOAK_MIN", "60")))
