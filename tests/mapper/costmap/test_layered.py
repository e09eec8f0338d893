"""Layers on each other: updates of what changed equal an update of everything, and each cell says why."""

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.costmap import (
    INSCRIBED,
    LETHAL,
    NO_INFORMATION,
    CostmapConfig,
    DecayConfig,
    DecayLayer,
    Footprint,
    InflationConfig,
    InflationLayer,
    KeepoutLayer,
    LayeredCostmap,
    Observation,
    ObstacleConfig,
    ObstacleLayer,
    StaticConfig,
    StaticLayer,
)
from mapper.grid import GridGeometry

GEOMETRY = GridGeometry(0.1, 60, 80)
ROBOT = Footprint.circle(0.2)
GENERAL = CostmapConfig()


def values() -> np.ndarray:
    found = np.zeros(GEOMETRY.shape, dtype=np.int8)
    found[0, :] = found[-1, :] = found[:, 0] = found[:, -1] = 100
    found[30:, 60:] = -1
    return found


def scan(x: float, y: float, stamp: float = 0.0, at: tuple[float, float] = (2.0, 2.0)) -> Observation:
    return Observation(np.array([*at, 0.2]), np.array([[x, y, 0.2]]), stamp)


def stack(obstacles: ObstacleConfig | None = None) -> tuple[LayeredCostmap, ObstacleLayer, KeepoutLayer]:
    """Return a costmap of a map, obstacles, painted areas and inflation."""
    seen = ObstacleLayer(GEOMETRY, obstacles or ObstacleConfig(), GENERAL)
    painted = KeepoutLayer(GEOMETRY)
    static = StaticLayer(GEOMETRY, values(), StaticConfig(), GENERAL)
    inflation = InflationLayer(GEOMETRY, InflationConfig(cost_scaling_factor=3.0), ROBOT.inscribed_radius)
    return LayeredCostmap(GEOMETRY, GENERAL, ROBOT, [static, seen, painted], inflation), seen, painted


def test_updates_of_boxes_equal_an_update_of_everything() -> None:
    """The same observations and paintings one by one, and all of them before the first update."""
    rng = np.random.default_rng(1)
    one_by_one, seen, painted = stack()
    at_once, seen_too, painted_too = stack()
    one_by_one.update()
    for k in range(12):
        observation = scan(*rng.uniform(0.5, 4.0, 2))
        polygon = rng.uniform(0.0, 6.0, (3, 2))
        for obstacle_layer, keepout in ((seen, painted), (seen_too, painted_too)):
            obstacle_layer.observe(observation)
            if k % 3 == 0:
                keepout.paint(polygon, 100 if k < 6 else -1)
        box = one_by_one.update()
        assert box is not None
        assert (box.row1 - box.row0) * (box.col1 - box.col0) < GEOMETRY.rows * GEOMETRY.cols
    at_once.update()
    np.testing.assert_array_equal(one_by_one.costs, at_once.costs)
    assert one_by_one.update() is None


def test_a_reading_marks_and_a_longer_one_clears() -> None:
    costmap, seen, _ = stack()
    seen.observe(scan(3.0, 2.0))
    costmap.update()
    assert costmap.costs[20, 30] == LETHAL
    assert costmap.costs[20, 31] == INSCRIBED
    assert costmap.costs[20, 32] == 249, "252 · e^(−3 · (0.2 − 0.2 · cos(π / 16)))"
    reasons = costmap.why(20, 30)
    assert [one.layer for one in reasons] == ["static_layer", "obstacle_layer", "keepout_filter", "inflation_layer"]
    assert [one.master for one in reasons] == [0, LETHAL, LETHAL, LETHAL]
    assert reasons[1].sentence.startswith("A reading ended here")
    assert "0.20 m away at (3.05, 2.05)" in costmap.why(20, 32)[3].sentence
    seen.observe(scan(4.0, 2.0))
    costmap.update()
    assert costmap.costs[20, 30] < LETHAL
    assert costmap.costs[20, 40] == LETHAL


def test_a_point_below_or_above_the_heights_marks_nothing() -> None:
    costmap, seen, _ = stack(ObstacleConfig(min_obstacle_height=0.1, max_obstacle_height=1.0))
    for z in (0.05, 1.2):
        seen.observe(Observation(np.array([2.0, 2.0, 0.2]), np.array([[3.0, 2.0, z]])))
    costmap.update()
    assert costmap.costs[20, 30] == 0


def test_an_obstacle_that_is_not_seen_again_is_forgotten_and_the_wall_stays() -> None:
    """The moving table's exercise: what the map has stays, what walked through fades after its lifetime."""
    trail = DecayLayer(GEOMETRY, DecayConfig(lifetime=2.0, footprint_clearing_enabled=False), GENERAL)
    static = StaticLayer(GEOMETRY, values(), StaticConfig(), GENERAL)
    costmap = LayeredCostmap(GEOMETRY, GENERAL, ROBOT, [static, trail])
    trail.observe(scan(3.0, 2.0, stamp=10.0))
    costmap.update(now=10.0)
    assert costmap.costs[20, 30] == LETHAL
    costmap.update(now=11.9)
    assert costmap.costs[20, 30] == LETHAL
    assert "Marked 1.9 s ago and kept" in costmap.why(20, 30)[1].sentence
    costmap.update(now=12.1)
    assert costmap.costs[20, 30] == 0
    assert costmap.costs[0, 30] == LETHAL, "the wall of the map"


def test_the_robot_clears_what_it_stands_on() -> None:
    costmap, seen, _ = stack()
    seen.observe(scan(3.0, 2.0))
    costmap.update()
    costmap.update(pose=(3.0, 2.0, 0.3))
    assert costmap.costs[20, 30] < LETHAL


def test_unknown_is_kept_where_it_is_tracked() -> None:
    general = CostmapConfig(track_unknown_space=True)
    static = StaticLayer(GEOMETRY, values(), StaticConfig(), general)
    costmap = LayeredCostmap(GEOMETRY, general, ROBOT, [static])
    costmap.update()
    assert costmap.costs[40, 70] == NO_INFORMATION
    assert costmap.why(40, 70)[0].sentence == "The map’s value is unknown: no information."


def test_layers_of_another_shape_are_refused() -> None:
    other = GridGeometry(0.1, 61, 80)
    with pytest.raises(ConfigError, match=r"'obstacle_layer' has \(61, 80\) cells"):
        LayeredCostmap(GEOMETRY, GENERAL, ROBOT, [ObstacleLayer(other, ObstacleConfig(), GENERAL)])


def test_bad_observations_and_paintings_are_refused() -> None:
    with pytest.raises(ConfigError, match="finite"):
        Observation(np.array([0.0, 0.0, np.nan]), np.zeros((1, 3)))
    with pytest.raises(ConfigError, match="at least three"):
        KeepoutLayer(GEOMETRY).paint(np.zeros((2, 2)), 100)
    with pytest.raises(ConfigError, match="−1 … 100, not 101"):
        KeepoutLayer(GEOMETRY).paint(np.zeros((3, 2)), 101)
