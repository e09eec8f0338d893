"""The ring of sonars in worlds with known distances, and its map."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.grid import FREE, OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig, sensor_defaults
from mapper.simulation import WORLDS, Recording, SensorConfig, Simulation, World
from mapper.simulation.lidar import measure, true_ranges

TURN = 2 * np.pi
ROOM = World(
    "room of 8 m",
    "Room",
    (-4.0, -4.0, 4.0, 4.0),
    tuple(
        np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        for x0, y0, x1, y1 in ((-4, -4, 4, -3.9), (-4, 3.9, 4, 4), (-4, -3.9, -3.9, 3.9), (3.9, -3.9, 4, 3.9))
    ),
    (0.0, 0.0, 0.0),
)


@pytest.mark.parametrize("yaw", [0.0, 0.1, 0.3, np.pi / 4])
@pytest.mark.parametrize("width", [0.05, 0.35, 1.0])
def test_a_cone_measures_the_nearest_point_of_a_wall(yaw: float, width: float) -> None:
    ring = SensorConfig(kind="sonar_ring", n_sonars=8, beam_width=width, range_noise=0.0, range_max=10.0)
    ranges = true_ranges(ROOM, ring, (0.0, 0.0, yaw))
    # To the wall 3.9 m ahead: straight on where the cone holds its normal, else along the edge that is nearer to it.
    axes = yaw + ring.angle_min + ring.angle_increment * np.arange(8)
    off = np.abs((axes + np.pi / 4) % (np.pi / 2) - np.pi / 4)
    expected = 3.9 / np.cos(np.maximum(off - width / 2, 0.0))
    np.testing.assert_allclose(ranges, expected, rtol=2e-4)


def test_a_thin_cone_is_the_lidars_beam_and_a_wide_one_hears_no_farther() -> None:
    lidar = SensorConfig(n_beams=30, range_max=10.0)
    pose = (3.0, 2.5, 0.4)
    beams = true_ranges(WORLDS["office"], lidar, pose)
    before = np.full(30, np.inf)
    for width in (0.05, 0.3, 0.6, 1.0):
        ring = SensorConfig(kind="sonar_ring", n_sonars=30, beam_width=width, range_max=10.0)
        heard = true_ranges(WORLDS["office"], ring, pose)
        assert (heard <= beams + 1e-9).all()
        assert (heard <= before + 0.02).all()  # the rays of two widths are not the same ones
        before = heard


def test_a_walk_with_sonars_frees_the_room_that_the_robot_walked_through() -> None:
    ring = SensorConfig(kind="sonar_ring", range_max=5.0)
    simulation = Simulation(WORLDS["room"], ring, 3)
    recording = Recording(ring)
    poses = []
    for scan, pose in simulation.advance(20.0):
        assert len(scan.ranges) == 16
        recording.append(scan, pose)
        poses.append(pose[:2])
    log = recording.as_log()
    assert log.beam_width == pytest.approx(0.35)
    config = MappingConfig().with_values(sensor_defaults(log.beam_width, {"resolution": 0.1, "range_max": 5.0}))
    assert config.model == "sonar_cone"
    assert config.opening == pytest.approx(0.35)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)
    cells = grid.geometry.world_to_cell(np.array(poses))
    assert (grid.classify()[cells[:, 0], cells[:, 1]] == FREE).mean() > 0.95


def test_noise_of_a_ring_is_one_draw_for_each_sonar() -> None:
    ring = SensorConfig(kind="sonar_ring", n_sonars=5, range_noise=0.2, range_max=10.0)
    scan = measure(ROOM, ring, (0.0, 0.0, 0.0), np.random.default_rng(1))
    exact = true_ranges(ROOM, ring, (0.0, 0.0, 0.0))
    np.testing.assert_allclose(scan.ranges, exact + 0.2 * np.random.default_rng(1).standard_normal(5), rtol=1e-6)
