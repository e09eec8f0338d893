"""Footprints: radii of shapes whose radii are known, and outlines that are refused."""

import math

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.costmap import Footprint

SQUARE = ((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2))


def test_the_radii_of_a_rectangle() -> None:
    shape = Footprint(SQUARE)
    assert shape.inscribed_radius == pytest.approx(0.2)
    assert shape.circumscribed_radius == pytest.approx(math.hypot(0.3, 0.2))


def test_a_round_robot_is_sixteen_points_on_its_circle() -> None:
    shape = Footprint.circle(0.5)
    assert len(shape.vertices) == 16
    assert shape.circumscribed_radius == pytest.approx(0.5)
    assert shape.inscribed_radius == pytest.approx(0.5 * math.cos(math.pi / 16))


def test_an_outline_may_be_closed_and_have_a_vertex_twice() -> None:
    """As geometry_msgs/Polygon and parameter files have it; Nav2 takes both."""
    assert Footprint((*SQUARE, SQUARE[0])) == Footprint(SQUARE) == Footprint((SQUARE[0], *SQUARE))


def test_padding_moves_each_coordinate_away_from_zero() -> None:
    padded = Footprint(((0.3, 0.2), (-0.3, 0.2), (0.0, -0.2))).padded(0.01)
    np.testing.assert_allclose(padded.vertices, [(0.31, 0.21), (-0.31, 0.21), (0.0, -0.21)])


def test_the_outline_turns_with_the_robot() -> None:
    at = Footprint(SQUARE).at((1.0, 2.0, math.pi / 2))
    np.testing.assert_allclose(at[0], [0.8, 2.3], atol=1e-12)


@pytest.mark.parametrize(
    ("vertices", "said"),
    [
        (((0.1, 0.1), (-0.1, -0.1)), "3 to 200 points"),
        (((1.0, 0.0), (float("nan"), 1.0), (-1.0, 0.0)), "finite"),
        ((("a", 1.0), (2.0, 1.0), (2.0, 2.0)), "list of points"),
    ],
)  # fmt: skip
def test_outlines_that_are_refused(vertices: tuple[tuple[float, float], ...], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        Footprint(vertices)


def test_an_outline_beside_the_origin_has_the_radii_of_nav2() -> None:
    """calculateMinAndMaxDistances of nav2_costmap_2d: the least distance to an edge, and the greatest to a corner."""
    beside = Footprint(((1.0, -1.0), (2.0, -1.0), (2.0, 1.0), (1.0, 1.0)))
    assert not beside.holds_origin
    assert beside.inscribed_radius == pytest.approx(1.0)
    assert beside.circumscribed_radius == pytest.approx(math.sqrt(5.0))
    assert Footprint(SQUARE).holds_origin
