"""The plan of a world as a map: beams that are cast in the world end on its occupied cells."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.grid import FREE, OCCUPIED
from mapper.simulation import WORLDS, SensorConfig
from mapper.simulation.lidar import true_ranges
from mapper.simulation.plan_map import plan_map


@pytest.mark.parametrize("name", ["room", "office"])
def test_beams_end_on_occupied_cells_and_pass_free_ones(name: str) -> None:
    world, sensor = WORLDS[name], SensorConfig(n_beams=180, range_max=30.0)
    grid = plan_map(world)
    state, geometry = grid.classify(), grid.geometry
    x, y, yaw = world.start
    ranges = true_ranges(world, sensor, world.start)
    away = np.stack([np.cos(yaw + sensor.bearings), np.sin(yaw + sensor.bearings)], axis=-1)
    ends = np.array([x, y]) + away * ranges[:, np.newaxis]
    assert (state[tuple(geometry.world_to_cell(ends).T)] == OCCUPIED).all()
    halfway = np.array([x, y]) + away * ranges[:, np.newaxis] / 2
    assert (state[tuple(geometry.world_to_cell(halfway).T)] == FREE).mean() > 0.9
    assert not grid.observed[0, -1] or state[0, -1] != FREE  # beyond the outer wall nothing is known
