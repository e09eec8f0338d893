"""Custom sensor models: the same map as a built-in model with the same profile, and clear errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mapper.core.errors import ConfigError, LimitError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import integrate_scan
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.mapping.sensor_model import FixedIncrements, InverseSensorModel, StepWindow
from mapper.sensors.scan import LaserScan, SonarScan


@dataclass(frozen=True)
class Step:
    """The step window again, in NumPy."""

    model: FixedIncrements | StepWindow

    @property
    def reach(self) -> float:
        return self.model.window / 2

    def increments(self, r: NDArray[np.float64], z: NDArray[np.float64], range_max: float) -> NDArray[np.float64]:
        assert (r[np.isinf(z)] <= range_max + 1.0).all()
        return np.where(r < z - self.reach, self.model.log_odds_miss, self.model.log_odds_hit)


class Says:
    """A model that says whatever it was given."""

    reach: Any = 0.0

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def increments(self, r: NDArray[np.float64], z: NDArray[np.float64], range_max: float) -> Any:
        return self.answer(r) if callable(self.answer) else self.answer


def fan(seed: int, n_beams: int = 60) -> LaserScan:
    random = np.random.default_rng(seed)
    ranges = random.uniform(0.0, 6.0, n_beams)
    ranges[random.random(n_beams) < 0.2] = np.inf
    ranges[random.random(n_beams) < 0.1] = np.nan
    return LaserScan(ranges.astype(np.float32), -2.0, 4.0 / n_beams, 0.1, 5.5)


@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from(["fixed_increments", "step_window"]),
    st.sampled_from(BY_NAME["traversal"].choices),
    st.sampled_from(BY_NAME["no_return"].choices),
    st.sampled_from([0.0, 0.05, 0.3, 1.0]),
    st.booleans(),
)
def test_the_same_profile_gives_the_same_map_to_the_last_bit(
    seed: int, name: str, traversal: str, no_return: str, window: float, clamp: bool
) -> None:
    config = MappingConfig(
        model=name, traversal=traversal, no_return=no_return, window=window, clamp=clamp, resolution=0.1, mount_x=0.1
    )
    model = config.beam_model()
    assert isinstance(model, FixedIncrements | StepWindow)
    random = np.random.default_rng(seed)
    ours, theirs = (OccupancyGrid(GridGeometry(0.1, 70, 50, (-1.0, -2.0, 0.3))) for _ in range(2))
    for turn in range(3):
        pose = random.uniform([-2, -2, -4], [2, 2, 4])
        scan = fan(seed + turn)
        one, other = integrate_scan(ours, scan, pose, config), integrate_scan(theirs, scan, pose, config, Step(model))
        assert other == one
    assert theirs.geometry == ours.geometry
    np.testing.assert_array_equal(theirs.observed, ours.observed)
    assert theirs.log_odds.tobytes() == ours.log_odds.tobytes()


def test_a_model_is_called_with_distance_reading_and_greatest_range() -> None:
    told: list[tuple[list[float], list[float], float]] = []

    class Ten:
        reach = 1.0

        def increments(self, r: NDArray[np.float64], z: NDArray[np.float64], range_max: float) -> NDArray[np.float64]:
            told.append((r.tolist(), z.tolist(), range_max))
            return 10.0 * r

    grid = OccupancyGrid(GridGeometry(1.0, 3, 12))
    scan = LaserScan(np.array([3.2], dtype=np.float32), 0.0, 0.01, 0.0, 8.0)
    config = MappingConfig(resolution=1.0, clamp=False, range_max=7.0)
    change = integrate_scan(grid, scan, (0.5, 1.5, 0.0), config, Ten())
    z = float(np.float32(3.2))
    assert told == [([0.0, 1.0, 2.0, 4.0, z], [z] * 5, 7.0)]
    np.testing.assert_allclose(grid.log_odds[1, :5], [0, 10, 20, 10 * z, 40], rtol=1e-6)
    assert change.cells_updated == 5
    assert grid.observed.sum() == 5


def test_a_scan_without_readings_changes_nothing() -> None:
    grid = OccupancyGrid(GridGeometry(1.0, 3, 12))
    scan = LaserScan(np.full(4, np.nan, dtype=np.float32), 0.0, 0.01, 0.0, 8.0)
    change = integrate_scan(grid, scan, (0.5, 1.5, 0.0), MappingConfig(resolution=1.0), Step(FixedIncrements()))
    assert (change.box, change.geometry_changed, change.cells_updated) == (None, False, 0)


def test_sonars_accept_custom_models() -> None:
    scan = SonarScan(np.array([2.0, 3.0], dtype=np.float32), np.array([0.0, 1.5]), 0.3, 0.1, 8.0)
    grid = OccupancyGrid(GridGeometry(0.5, 20, 20, (-5.0, -5.0, 0.0)))
    config = MappingConfig(model="sonar_cone", resolution=0.5)
    assert integrate_scan(grid, scan, (0.0, 0.0, 0.0), config, Step(FixedIncrements())).cells_updated > 8


@pytest.mark.parametrize(
    ("answer", "sentence"),
    [
        (0.5, r"must have the shape of r, \(\d+,\), not \(\)"),
        (lambda r: r[:-1], r"must have the shape of r"),
        (lambda r: r[:, np.newaxis], r"must have the shape of r"),
        (None, "finite log-odds|shape"),
        (lambda r: ["high"] * len(r), "not an array of numbers"),
        (lambda r: np.where(r > 1.0, np.nan, 0.1), r"at r = 1\.\d+ m of a reading z = [\d.]+ m it says nan"),
        (lambda r: np.full(len(r), np.inf), "it says inf"),
        (lambda r: np.full(len(r), 1e300), "it says 1e\\+300"),
    ],
)
def test_invalid_evidence_is_refused_and_changes_nothing(answer: Any, sentence: str) -> None:
    grid = OccupancyGrid(GridGeometry(0.5, 4, 4))
    geometry = grid.geometry
    scan = LaserScan(np.full(5, 6.1, dtype=np.float32), 0.0, 0.1, 0.0, 8.0)
    with pytest.raises(ConfigError, match=sentence):
        integrate_scan(grid, scan, (0.5, 0.5, 0.0), MappingConfig(resolution=0.5), Says(answer))
    assert grid.geometry is geometry
    assert not grid.observed.any()
    assert not grid.log_odds.any()


@pytest.mark.parametrize("value", [-0.1, np.nan, np.inf, "far", None, True])
def test_a_reach_that_is_none_is_refused(value: object) -> None:
    model = Says(lambda r: r)
    model.reach = value
    with pytest.raises(ConfigError, match="reach must be a finite number of metres"):
        integrate_scan(OccupancyGrid(GridGeometry(0.5, 4, 4)), fan(1), (0, 0, 0), MappingConfig(), model)


def test_a_model_needs_a_grid_and_a_way_of_updating_that_fit() -> None:
    model: InverseSensorModel = Step(FixedIncrements())
    grid = OccupancyGrid(GridGeometry(0.5, 4, 4))
    with pytest.raises(ConfigError, match="updates per beam"):
        integrate_scan(grid, fan(1), (0, 0, 0), MappingConfig(update="per_scan", resolution=0.5), model)
    tiny = OccupancyGrid(GridGeometry(1e-5, 4, 4))
    with pytest.raises(ConfigError, match="choose coarser"):
        integrate_scan(tiny, fan(1), (0, 0, 0), MappingConfig(), model)
    with pytest.raises(LimitError, match="coarser"):
        integrate_scan(grid, fan(1), (9e5, 0, 0), MappingConfig(resolution=0.5), model)
    integrate_scan(grid, fan(1), (0, 0, 0), MappingConfig(model="hit_counting", resolution=0.5))
    with pytest.raises(ConfigError, match="counts for another model"):
        integrate_scan(grid, fan(1), (0, 0, 0), MappingConfig(resolution=0.5), model)
