"""Furniture that was moved: each piece by a metre, walls not at all."""

import numpy as np
import pytest

from mapper.simulation import WORLDS
from mapper.simulation.plan_map import is_furniture, with_moved_furniture


@pytest.mark.parametrize("name", ["office", "room", "twins"])
def test_furniture_is_moved_and_walls_stay(name):
    world = WORLDS[name]
    changed = with_moved_furniture(world)
    moves = np.array([b[0] - a[0] for a, b in zip(world.solids, changed.solids, strict=True)])
    lengths = np.hypot(*moves.T)
    furniture = np.array([is_furniture(solid) for solid in world.solids])
    assert not lengths[~furniture].any()
    assert np.isin(np.round(lengths[furniture], 9), [0.0, 1.0]).all()
    assert (lengths > 0).sum() >= 0.7 * furniture.sum() > 3
    for a, b, move in zip(world.solids, changed.solids, moves, strict=True):
        np.testing.assert_allclose(b, a + move)


def test_the_rooms_of_twins_are_equal():
    """From a place in one room a robot sees what it sees from the same place in the other, but for the corridor."""
    world = WORLDS["twins"]
    inside = [solid for solid in world.solids if 2.5 < solid[:, 1].min() < 8.7]
    solids = {tuple(np.round(solid.min(axis=0), 6).tolist()) for solid in inside}
    left = {one for one in solids if one[0] < 7.9}
    assert len(left) == 6
    assert {(round(x + 7.86, 6), y) for x, y in left} <= solids
