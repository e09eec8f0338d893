"""Wean Hall: a corridor with people, who walk beside the robot and stand around it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.se2 import wrap_angle
from mapper.io.logs import open_log
from mapper.io.maps import load_map
from mapper.localization import localize_log


@pytest.mark.data
def test_the_robot_is_found_and_not_carried_off_by_the_people_beside_it(data_file: Callable[[str], Path]):
    log = open_log(data_file("mcl/robotdata1.log.gz"))
    found = localize_log(log, load_map(data_file("mcl/wean.dat.gz")).grid, seed=3)
    first = found.first_converged
    assert first is not None
    assert first < 80
    # The robot leaves a room by its door, facing down, and comes back into the same door at the end. The start is that
    # of scans of 10 m put together by the odometry and searched for in the whole map; the end is in the only door that
    # the odometry's errors, some percent of 41 m, allow.
    np.testing.assert_allclose(found.poses[100, :2], [43.6, 39.6], atol=0.4)
    np.testing.assert_allclose(found.poses[-1, :2], [39.9, 41.35], atol=0.4)
    assert abs(float(wrap_angle(found.poses[-1, 2] - 1.28))) < math.radians(10)
    assert found.is_converged[80:400].mean() > 0.9
    # The scans lie on the map's walls: it is the right way round, and 1 is free in its file.
    assert np.median(found.fit[-200:]) > 0.85
