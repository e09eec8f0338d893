"""The time along a path where speed limits hold, against the limit asked place by place."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.costmap import Mask, SpeedFilter
from mapper.costmap.speed_filter import ABSOLUTE, PERCENTAGE
from mapper.grid import GridGeometry
from mapper.planning.plan import travel_time

GEOMETRY = GridGeometry(0.5, 2, 4)
PATH = np.array([[-1.0, 0.25], [0.0, 0.25], [1.0, 0.25], [2.0, 0.25], [3.0, 0.25]])


def filter_of(*row: int, kind: int = PERCENTAGE, base: float = 0.0, multiplier: float = 1.0) -> SpeedFilter:
    return SpeedFilter(Mask(GEOMETRY, np.array([row, row], dtype=np.int8)), kind, base, multiplier)


def test_each_part_has_the_limit_of_its_middle() -> None:
    """Four metres at 0.5 m/s, of which one is at half of it, and one at the limit before: it is off the mask."""
    assert travel_time(PATH, 0.5) == pytest.approx(8.0)
    half = filter_of(0, 0, 50, 50)
    assert travel_time(PATH, 0.5, [half]) == pytest.approx(2.0 + 2.0 + 4.0 + 4.0)
    slow = filter_of(10, 10, 0, 0, kind=ABSOLUTE, multiplier=0.01)
    assert travel_time(PATH, 0.5, [half, slow]) == pytest.approx(2.0 + 10.0 + 4.0 + 4.0)


@pytest.mark.parametrize(
    ("kind", "base", "multiplier"), [(PERCENTAGE, 0.0, 1.0), (PERCENTAGE, 100.0, -2.0), (ABSOLUTE, 1.5, -0.02)]
)
def test_speeds_along_a_path_are_those_of_one_place_after_another(kind: int, base: float, multiplier: float) -> None:
    random = np.random.default_rng(3)
    geometry = GridGeometry(0.1, 20, 30, (0.2, -0.3, 0.4))
    mask = Mask(geometry, random.integers(-1, 101, geometry.shape).astype(np.int8))
    places = random.uniform(-1.0, 4.0, (300, 2))
    whole, single = (SpeedFilter(mask, kind, base, multiplier) for _ in range(2))
    for one in (whole, single):
        one.at(*geometry.cell_to_world((5, 5)))  # the limit that holds before the first place
    found = whole.speeds_along(places, 0.7)
    np.testing.assert_allclose(found, [single.at(x, y).of(0.7) for x, y in places])
    assert len(np.unique(found)) > 10


def test_what_is_refused() -> None:
    for speed in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ConfigError, match="greatest speed must be above 0"):
            travel_time(PATH, speed)
    with pytest.raises(ConfigError, match="base and multiplier must be finite"):
        filter_of(1, 1, 1, 1, base=float("nan"))
