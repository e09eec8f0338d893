"""The landscape of the score."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.se2 import compose, inverse
from mapper.matching import MatchConfig, match_scan, prepare_scans, scan_target
from mapper.matching.kernels.types import ScanArrays
from mapper.matching.search import score_landscape
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


def test_the_landscape_is_highest_where_the_search_ends(scans: ScanArrays, target: Target) -> None:
    guess = TRUE + np.array([0.3, -0.2, 0.2])
    config = MatchConfig(method="correlative", window_m=0.5, window_rad=0.3)
    landscape = score_landscape(scans, 1, target, guess, config)
    row, col = np.unravel_index(int(landscape.greatest.argmax()), landscape.greatest.shape)
    top = guess + np.array(
        [landscape.offsets[col], landscape.offsets[row], landscape.turns[landscape.turn_of[row, col]]]
    )
    np.testing.assert_allclose(match_scan(scans, 1, target, guess, config).pose, top, atol=1e-9)
    assert (landscape.greatest >= landscape.slice).all()
    assert landscape.by_turn.max() == landscape.greatest.max() <= 1.0
    assert landscape.greatest.min() >= 0.0
