"""What is told of a cell adds up to what the map holds, with every kind of update."""

import itertools

import numpy as np
import pytest

from mapper.errors import ConfigError
from mapper.parameters import MappingConfig
from mapper.replay import Replay
from mapper.scan import ScanLog

KINDS = list(
    itertools.product(["per_beam", "per_scan"], ["bresenham", "amanatides_woo"], [0.0, 0.3], ["ignore", "free"])
)


@pytest.mark.parametrize(("update", "traversal", "window", "no_return"), KINDS)
def test_the_last_entry_is_the_map(
    office_log: ScanLog, update: str, traversal: str, window: float, no_return: str
) -> None:
    config = MappingConfig(
        update=update, traversal=traversal, window=window, no_return=no_return, resolution=0.1, log_odds_prior=0.2
    )
    replay = Replay(office_log, config)
    replay.advance_to(60)
    grid, random = replay.grid, np.random.default_rng(5)
    occupied, seen = np.argwhere(grid.log_odds > 1.0), np.argwhere(grid.observed)
    for row, col in [*random.choice(occupied, 25), *random.choice(seen, 25)]:
        told = replay.provenance(row, col)
        assert len(told.scans) > 0
        assert told.log_odds[-1] == grid.log_odds[row, col]
        assert (np.diff(told.scans * office_log.n_beams + told.beams) > 0).all()
        assert told.scans.max() < 60
        np.testing.assert_array_equal(told.increments > 0, told.hits)
        np.testing.assert_array_equal(told.ranges, office_log.ranges[told.scans, told.beams])
    unseen = np.argwhere(~grid.observed)
    for row, col in random.choice(unseen, 25):
        assert len(replay.provenance(row, col).scans) == 0


def test_a_cell_that_is_not_there(office_log: ScanLog) -> None:
    replay = Replay(office_log, MappingConfig(resolution=0.2))
    with pytest.raises(ConfigError, match="outside the grid"):
        replay.provenance(-1, 0)
    with pytest.raises(ConfigError, match="outside the grid"):
        replay.provenance(0, replay.grid.geometry.cols)
