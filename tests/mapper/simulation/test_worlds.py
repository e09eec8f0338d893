"""The floor plans: closed, reachable, with furniture of plausible sizes."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.errors import ConfigError
from mapper.simulation import WORLDS, SensorConfig, World
from mapper.simulation.lidar import true_ranges
from mapper.simulation.shapes import rect, wall
from mapper.simulation.simulation import ROBOT_RADIUS
from mapper.simulation.worlds import clearance_lattice


def flooded(free: np.ndarray, start: tuple[int, int]) -> np.ndarray:
    reached = np.zeros_like(free)
    reached[start] = True
    queue = deque([start])
    while queue:
        row, col = queue.popleft()
        for r, c in ((row + 1, col), (row - 1, col), (row, col + 1), (row, col - 1)):
            if 0 <= r < free.shape[0] and 0 <= c < free.shape[1] and free[r, c] and not reached[r, c]:
                reached[r, c] = True
                queue.append((r, c))
    return reached


@pytest.mark.parametrize("name", WORLDS)
def test_a_robot_can_reach_every_place_where_it_fits(name):
    world = WORLDS[name]
    assert name == world.name
    assert world.is_free(world.start[:2], ROBOT_RADIUS + 0.2)
    lattice = clearance_lattice(world)
    row, col = (int(v) for v in lattice.geometry.world_to_cell(world.start[:2]))
    fits = lattice.clearance >= ROBOT_RADIUS + 0.02
    assert (fits & ~flooded(fits, (row, col))).sum() * lattice.geometry.resolution**2 <= 0.03
    # And what no robot fits into is a corner or a gap, not a room.
    free = lattice.clearance > 0.0
    assert (free & ~flooded(free, (row, col))).sum() * lattice.geometry.resolution**2 <= 0.3


@pytest.mark.parametrize("name", WORLDS)
def test_the_outer_wall_is_closed(name):
    world = WORLDS[name]
    sensor = SensorConfig(n_beams=1080, range_max=30.0)
    rng = np.random.default_rng(0)
    x0, y0, x1, y1 = world.bounds
    for _ in range(10):
        place = world.nearest_free(rng.uniform((x0, y0), (x1, y1)), 0.05)
        assert np.isfinite(true_ranges(world, sensor, (*place, 0.0))).all()
    for solid in world.solids:
        assert np.all((solid >= (x0 - 1e-9, y0 - 1e-9)) & (solid <= (x1 + 1e-9, y1 + 1e-9)))


@given(st.sampled_from(sorted(WORLDS)), st.floats(0, 1), st.floats(0, 1), st.sampled_from([0.0, 0.1, 0.2, 0.3]))
def test_the_nearest_free_place_is_free_and_none_is_much_nearer(name, across, up, radius):
    world = WORLDS[name]
    x0, y0, x1, y1 = world.bounds
    target = np.array([x0 + across * (x1 - x0), y0 + up * (y1 - y0)])
    place = world.nearest_free(target, radius)
    assert world.is_free(place, radius)
    if world.is_free(target, radius):
        assert np.array_equal(place, target)
        return
    gap = np.hypot(*(place - target))
    rings = np.linspace(0.0, 0.96 * gap - 0.01, 12)[:, None]
    angle = np.linspace(0, 2 * np.pi, 72)
    around = target + np.stack([rings * np.cos(angle), rings * np.sin(angle)], axis=-1)
    assert not np.any(world.clearance(around) >= radius + 0.01)


def test_places_far_outside_have_a_nearest_free_place_too():
    world = WORLDS["office"]
    for far in ((1e9, 7.0), (-1e300, -1e300), (10.0, 1e12)):
        assert world.is_free(world.nearest_free(far, 0.2), 0.2)
    assert not world.is_free((-1.0, 7.0), 0.0)


def test_an_invalid_world_is_refused():
    box = (0.0, 0.0, 2.0, 2.0)
    with pytest.raises(ConfigError, match="Solid 1"):
        World("w", "W", box, (rect(0, 0, 1, 1), np.array([(0.0, 0.0), (1.0, 1.0)])), (1, 1, 0))
    with pytest.raises(ConfigError, match="no area"):
        World("w", "W", box, (np.array([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]),), (1, 1, 0))
    with pytest.raises(ConfigError, match="finite"):
        World("w", "W", box, (np.array([(0.0, 0.0), (np.nan, 1.0), (2.0, 2.0)]),), (1, 1, 0))
    with pytest.raises(ConfigError, match="bounds"):
        World("w", "W", (0.0, 0.0, 0.0, 2.0), (), (1, 1, 0))
    full = World("full", "Full", box, (rect(0, 0, 2, 2),), (1, 1, 0))
    with pytest.raises(ConfigError, match="fits nowhere"):
        full.nearest_free((1.0, 1.0), 0.2)
    with pytest.raises(ConfigError, match="finite"):
        WORLDS["room"].nearest_free((np.nan, 1.0), 0.2)


def test_clockwise_polygons_are_turned_and_walls_leave_their_doors_open():
    world = World("w", "W", (-1, -1, 5, 5), (rect(0, 0, 1, 1)[::-1],), (3, 3, 0))
    assert world.clearance((0.5, 0.5)) < 0.0 < world.clearance((2.0, 0.5))
    world = World("w", "W", (-1, -1, 5, 5), tuple(wall((0, 0), (4, 0), 0.2, [(1.0, 1.9)])), (3, 3, 0))
    assert world.clearance((1.45, 0.0)) == pytest.approx(0.45)
    assert world.clearance((0.5, 0.0)) < 0.0
    assert world.clearance((2.5, 0.0)) < 0.0
