"""The hill of the score and the basins of attraction of the methods."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.matching import MatchConfig, match_scan, prepare_scans, scan_target
from mapper.matching.kernels.types import ScanArrays
from mapper.matching.landscape import basin_of_attraction, score_landscape
from mapper.matching.target import Target
from tests.mapper.matching.rooms import ROOM, scan_log

POSES = np.array([[3.5, 2.2, 0.3], [3.9, 1.8, 0.8]])
TRUE = compose(inverse(POSES[0]), POSES[1])


@pytest.fixture(scope="module")
def scans() -> ScanArrays:
    return prepare_scans(scan_log(ROOM, POSES))


@pytest.fixture(scope="module")
def target(scans: ScanArrays) -> Target:
    return scan_target(scans, 0)


def test_the_hill_is_highest_where_the_search_ends(scans: ScanArrays, target: Target) -> None:
    guess = TRUE + np.array([0.3, -0.2, 0.2])
    config = MatchConfig(method="correlative", window_m=0.5, window_rad=0.3)
    hill = score_landscape(scans, 1, target, guess, config)
    row, col = np.unravel_index(int(hill.greatest.argmax()), hill.greatest.shape)
    top = guess + np.array([hill.offsets[col], hill.offsets[row], hill.turns[hill.turn_of[row, col]]])
    np.testing.assert_allclose(match_scan(scans, 1, target, guess, config).pose, top, atol=1e-9)
    assert (hill.greatest >= hill.slice).all()
    assert hill.by_turn.max() == hill.greatest.max() <= 1.0
    assert hill.greatest.min() >= 0.0


def test_a_search_has_a_wider_basin_than_an_iteration(scans: ScanArrays, target: Target) -> None:
    local = MatchConfig(method="point_to_line", min_cosine=0.0)
    searching = MatchConfig(window_m=0.8, window_rad=0.7)
    found = [
        basin_of_attraction(scans, 1, target, TRUE, config, reach=0.8, starts=5, turn=0.5).found
        for config in (local, searching)
    ]
    assert found[1].all()
    assert not found[0].all()
    near = basin_of_attraction(scans, 1, target, TRUE, local, reach=0.05, starts=3)
    assert near.found.all()
    assert (near.scores > 0.5).all()


def test_too_many_starts_are_refused(scans: ScanArrays, target: Target) -> None:
    for starts in (0, 101):
        with pytest.raises(ConfigError, match="guesses a side"):
            basin_of_attraction(scans, 1, target, TRUE, MatchConfig(), starts=starts)
