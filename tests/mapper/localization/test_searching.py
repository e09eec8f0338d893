"""Addition of particles from all over the map, and their number by a scan's loss."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.localization.parameters import LocalizationConfig
from mapper.localization.recovery import LOST, SEARCHING, Recovery
from mapper.localization.resample import resampled


def test_the_robot_is_searched_until_the_filter_has_converged_and_not_when_it_gets_wider() -> None:
    recovery = Recovery(LocalizationConfig(), is_searched=True)
    assert recovery.added_weight(0.9, 0.9, is_converged=False) == SEARCHING
    assert recovery.added_weight(0.9, 0.9, is_converged=True) == 0.0
    assert recovery.added_weight(0.9, 0.9, is_converged=False) == 0.0
    added = [recovery.added_weight(0.3, 0.9, is_converged=False) for _ in range(8)]
    first = next(i for i, weight in enumerate(added) if weight)
    assert added[first] == LOST
    assert set(added[first + 1 :]) == {SEARCHING}
    assert recovery.added_weight(0.9, 0.9, is_converged=True) == 0.0


@pytest.mark.parametrize(
    ("heavy", "kept", "count"), [(2000, 1.0, 500), (500, 1.0, 2000), (1000, 1.0, 1000), (1000, 0.5, 2000)]
)
def test_more_particles_are_drawn_where_the_weights_leave_few(heavy: int, kept: float, count: int) -> None:
    particles = np.zeros((2000, 3))  # one bin: KLD sampling asks for min_particles, 500
    weights = np.where(np.arange(2000) < heavy, 1.0 / heavy, 0.0)
    assert len(resampled(particles, weights, 4000, 0.5, LocalizationConfig(), kept)) == count
    assert len(resampled(particles, weights, 800, 0.5, LocalizationConfig(), kept)) == min(count, 800)
