"""The number of scans that a map needs to forget, against the arithmetic of one cell."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid, log_odds
from mapper.mapping.integrate import integrate_scan
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import WORLDS, Drawn, Edits, SensorConfig, Simulation, edited
from mapper.simulation.edits import gone
from mapper.simulation.second_map import Forgetting, cells_of

ROOM = WORLDS["room"]
SEEN = 40  # scans of the table before it goes


@pytest.mark.parametrize("clamp", [True, False])
def test_the_count_is_that_of_the_arithmetic(clamp: bool) -> None:
    # Per scan each cell in view is updated once, so that every cell of the table tells the same story.
    config = MappingConfig(range_max=10.0, window=0.2, update="per_scan", clamp=clamp)
    with_table = edited(ROOM, Edits((Drawn("box", 520, 470, 580, 530),)))
    simulation = Simulation(with_table, SensorConfig(range_noise=0.0), seed=3)
    simulation.auto = False
    simulation.teleport(4.0, 5.0, 0.0)
    grid = OccupancyGrid(GridGeometry.covering([-1.0, -1.0], [11.0, 9.0], 0.05))

    def see(scans: int) -> None:
        taken = 0
        while taken < scans:
            for scan, pose in simulation.advance(0.1):
                integrate_scan(grid, scan, pose, config)
                taken += 1

    see(SEEN)
    cells = cells_of(grid, gone(with_table, ROOM), config.resolution + config.window / 2)
    assert len(cells) > 20
    places = grid.geometry.cell_to_world(cells)
    assert ((places > [5.0, 4.5]) & (places < [6.0, 5.5])).all()
    reached = min(SEEN * config.log_odds_hit, config.log_odds_max if clamp else math.inf)
    expected = math.ceil((reached - float(log_odds(0.25))) / -config.log_odds_miss)
    forgetting = Forgetting(places)
    simulation.alter_world(ROOM)
    while forgetting.after is None:
        see(1)
        forgetting.look(grid)
        assert len(forgetting.free) < 300
    assert forgetting.after == pytest.approx(expected, abs=1)
    assert np.diff(forgetting.free).min() >= 0.0


def test_unobserved_cells_are_not_forgotten() -> None:
    grid = OccupancyGrid(GridGeometry.covering([-1.0, -1.0], [11.0, 9.0], 0.05))
    cells = cells_of(grid, [ROOM.solids[8]], 0.1)
    with pytest.raises(ConfigError, match="nothing to forget"):
        Forgetting(grid.geometry.cell_to_world(cells).reshape(-1, 2))
    assert len(cells_of(grid, [], 0.1)) == 0
