"""The marking of observed cells without a separate write holds for every prior and every evidence."""

import numpy as np
import pytest

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping import textbook
from mapper.mapping.integrate import integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog, Trajectory


@pytest.mark.parametrize("traversal", ["bresenham", "amanatides_woo"])
@pytest.mark.parametrize("prior", [0.0, -0.0, 0.25])
@pytest.mark.parametrize(("miss", "hit"), [(-0.4, 0.85), (-0.0, 0.0), (-0.0, -0.0), (-0.5, 0.5)])
@pytest.mark.parametrize("clamp", [True, False])
def test_observed_cells_and_signed_zeros_equal_the_textbook(
    traversal: str, prior: float, miss: float, hit: float, clamp: bool
) -> None:
    config = MappingConfig(
        traversal=traversal, log_odds_prior=prior, log_odds_miss=miss, log_odds_hit=hit, clamp=clamp, log_odds_max=0.0
    )
    ranges = np.random.default_rng(3).uniform(0.5, 2.0, (2, 90)).astype(np.float32)  # many beams to a cell
    poses = np.array([[0.1, 0.0, 0.0], [-0.1, 0.2, 0.0]])
    log = ScanLog(ranges, -np.pi, np.pi / 45, 0.05, 80.0, np.zeros(2, np.int64), {"t": Trajectory(poses)})
    geometry = GridGeometry(0.1, 30, 44, (-2.2, -1.5, 0.0))
    ours, theirs = OccupancyGrid(geometry, prior), OccupancyGrid(geometry, prior)
    count = integrate_log(ours, log, config)
    assert count == sum(textbook.update_per_beam(theirs, log.scan(t), poses[t], config) for t in range(2)) > 2000
    np.testing.assert_array_equal(ours.observed, theirs.observed)
    np.testing.assert_array_equal(ours.log_odds, theirs.log_odds)
    assert not np.signbit(ours.log_odds[ours.log_odds == 0.0]).any() or np.signbit(prior)
