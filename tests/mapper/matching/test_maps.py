"""Two maps of one place, aligned."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.matching import MatchConfig, map_points, map_target, match_maps, match_scan, prepare_scans
from mapper.sensors.scan import Trajectory
from tests.mapper.matching.rooms import ROOM, scan_log

POSES = np.array([[x, 2.3, yaw] for x in (1.2, 3.0, 4.6, 6.2) for yaw in (0.0, 2.5)])


def made(origin: np.ndarray, seed: int) -> OccupancyGrid:
    """The room's map in a frame whose pose in the room is ``origin``."""
    log = scan_log(ROOM, POSES, n_beams=360, seed=seed)
    moved = type(log)(
        log.ranges, log.angle_min, log.angle_increment, log.range_min, log.range_max, log.stamps_ns,
        {"scan": Trajectory(compose(inverse(origin), POSES))}, log.mount,
    )  # fmt: skip
    config = MappingConfig(resolution=0.05)
    grid = grid_for(moved, config)
    integrate_log(grid, moved, config)
    return grid


def test_two_maps_in_different_frames() -> None:
    other = np.array([2.0, -1.0, 2.2])
    found = match_maps(made(np.zeros(3), 1), made(other, 2))
    off = compose(inverse(other), found.pose)
    assert np.hypot(off[0], off[1]) < 0.03
    assert abs(off[2]) < 0.01
    assert found.score > 0.5


def test_a_scan_in_a_map() -> None:
    log = scan_log(ROOM, np.array([[3.6, 2.0, 1.0]]), n_beams=360, seed=7)
    target = map_target(map_points(made(np.zeros(3), 1)))
    guess = np.array([4.3, 1.6, 1.4])
    found = match_scan(prepare_scans(log), 0, target, guess, MatchConfig(method="global_field"))
    off = compose(inverse(np.array([3.6, 2.0, 1.0])), found.pose)
    assert np.hypot(off[0], off[1]) < 0.04
    assert abs(off[2]) < 0.01
    for method in ("global", "point_to_line", "features"):
        with pytest.raises(ConfigError, match="not with a map"):
            match_scan(prepare_scans(log), 0, target, guess, MatchConfig(method=method))


def test_an_empty_map_is_refused() -> None:
    empty = OccupancyGrid(GridGeometry(0.1, 20, 20))
    with pytest.raises(ConfigError) as caught:
        match_maps(made(np.zeros(3), 1), empty)
    assert caught.value.code == "matching.points"
    with pytest.raises(ConfigError, match="the map has 0 usable"):
        match_maps(empty, empty)
