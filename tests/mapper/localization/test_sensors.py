"""A robot with two lidars is localized by the scans of both."""

from __future__ import annotations

import numpy as np

from mapper.core.se2 import wrap_angle
from mapper.localization import LocalizationConfig, MonteCarloLocalizer, localize_log
from mapper.localization.scan_beams import scan_beams
from tests.mapper.localization.rooms import office, two_lidars

FEW = LocalizationConfig(global_particles=8000)


def test_two_lidars_that_see_a_quarter_each_find_the_robot():
    grid, log = office()
    both = two_lidars(log)
    assert both.n_scans == 2 * log.n_scans
    found = localize_log(both, grid, FEW, seed=1)
    true = both.trajectory("true").poses
    assert found.is_converged[-10:].all()
    assert np.hypot(*(found.poses - true)[-10:, :2].T).max() < 0.4
    assert np.abs(wrap_angle(found.poses[-10:, 2] - true[-10:, 2])).max() < 0.2
    # Where the robot has moved, both scans are used, one after the other.
    used = found.is_updated.reshape(-1, 2)
    assert used[:, 0].any()
    np.testing.assert_array_equal(used[:, 0], used[:, 1])


def test_each_sensor_is_used_once_for_each_motion():
    grid, log = office()
    robot = MonteCarloLocalizer(grid, range_max=log.range_max, initial_pose=log.trajectory("true").poses[0])
    scan = scan_beams(log.scan(0), log.mount, robot.config)
    used = [
        robot.update_beams((x, 0.0, 0.0), scan, sensor).is_updated
        for x, sensor in ((0.0, 0), (0.0, 1), (0.1, 0), (0.1, 1), (0.3, 0), (0.3, 1), (0.3, 1), (0.4, 0))
    ]
    assert used == [True, True, False, False, True, True, False, False]
