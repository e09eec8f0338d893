"""Ground points against the classification by hand of the ISPRS samples, and against scenes made of known parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError, WorkCancelledError
from mapper.io.clouds import read_cloud
from mapper.terrain import GroundConfig, agreement, find_ground
from tests.airborne import SCENES, labelled_cloud
from tests.marks import also_long

#: Cohen's kappa that the first values of the parameters reach, in percent
KAPPA = {"11": 83.2, "12": 94.1, "21": 95.3, "22": 91.1, "23": 88.9, "24": 91.0, "31": 96.3}

#: Cohen's kappa that simulated clouds reach at least, in percent; SMRF alone has 99.9, 37, 36, 50, 69 and 88
LEAST = {
    "town": 99.0,
    "quarry": 71.0,
    "quarry, dense": 74.0,
    "ridges": 88.0,
    "bank with terraces": 77.0,
    "gardens on terraces": 94.0,
}


@pytest.mark.data
@pytest.mark.parametrize("name", ["21", "24", "31", *also_long("11", "12", "22", "23")])
def test_an_isprs_sample_has_its_ground(data_dir: Path, name: str) -> None:
    cloud = read_cloud(data_dir / "pointclouds" / f"samp{name}-utm.pcd").points
    truth = read_cloud(data_dir / "pointclouds" / f"samp{name}-utm-ground.pcd").points
    places = set(map(tuple, truth.tolist()))
    is_ground = np.array([tuple(place) in places for place in cloud.tolist()])
    assert agreement(find_ground(cloud).is_ground, is_ground)["kappa"] == pytest.approx(KAPPA[name], abs=0.1)


def test_a_house_and_a_bird_are_no_ground_and_a_slope_is() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(0.0, 60.0, (8000, 3))
    points[:, 2] = 0.1 * points[:, 0]
    house = np.asarray((np.abs(points[:, :2] - 30.0) < 6.0).all(axis=1))
    points[house, 2] += 5.0
    points[0, 2] -= 20.0  # a reflection
    found = find_ground(points)
    np.testing.assert_array_equal(found.is_ground[1:], ~house[1:])
    assert not found.is_ground[0]


@pytest.mark.parametrize(
    "name", ["town", "quarry", *also_long(*(name for name in SCENES if name not in ("town", "quarry")))]
)
def test_a_simulated_cloud_has_its_ground_and_what_is_wrong_is_mostly_unsure(name: str) -> None:
    points, is_ground = labelled_cloud(name, seed=1)
    found = find_ground(points)
    assert agreement(found.is_ground, is_ground)["kappa"] > LEAST.get(name, 80.0)
    is_wrong = found.is_ground != is_ground
    assert is_wrong[found.is_unsure].mean() >= 2.0 * is_wrong[~found.is_unsure].mean()
    assert found.is_unsure.mean() < 0.2


def test_a_crest_with_steep_flanks_is_ground_and_a_gable_roof_of_the_same_slope_is_none() -> None:
    rng = np.random.default_rng(4)
    points = rng.uniform(0.0, 80.0, (12_000, 3))
    crest = np.maximum(9.0 - 0.9 * np.abs(points[:, 0] - 20.0), 0.0)
    roof = (np.abs(points[:, 0] - 60.0) < 6.0) & (np.abs(points[:, 1] - 40.0) < 9.0)
    points[:, 2] = crest + np.where(roof, 3.0 + 0.9 * (6.0 - np.abs(points[:, 0] - 60.0)), 0.0)
    found = find_ground(points)
    assert not found.is_ground[roof].any()
    assert found.is_ground[~roof].mean() > 0.99  # 0.88 by SMRF alone


def test_the_edge_of_a_terrace_is_ground_and_a_deck_between_two_banks_is_none() -> None:
    rng = np.random.default_rng(5)
    points = rng.uniform(0.0, 90.0, (2_500, 3))  # 0.3 points per m²: the cells at the edge are between points
    x, y = points[:, 0], points[:, 1]
    deck = (np.abs(x - 45.0) < 12.0) & (np.abs(y - 45.0) < 4.0)
    points[:, 2] = np.where((np.abs(x - 45.0) < 12.0) & ~deck, 0.0, 8.0)
    found = find_ground(points)
    assert found.is_ground[~deck].mean() > 0.985  # 0.974 by SMRF alone
    assert found.is_ground[deck].mean() < 0.35  # where it meets the banks it continues them


def test_the_upper_border_of_terraces_is_ground_and_a_house_there_is_none() -> None:
    rng = np.random.default_rng(6)
    points = rng.uniform(0.0, 60.0, (7_200, 3))
    x, y = points[:, 0], points[:, 1]
    house = (x > 50.0) & (np.abs(y - 30.0) < 8.0)
    points[:, 2] = 2.4 * np.floor(0.4 * x / 2.4) + np.where(house, 7.0, 0.0)
    found = find_ground(points)
    assert found.is_ground[~house].mean() > 0.98
    assert found.is_ground[house].mean() < 0.02


def test_a_spur_with_a_drop_on_three_sides_is_ground() -> None:
    rng = np.random.default_rng(7)
    points = rng.uniform(0.0, 140.0, (20_000, 3))
    x, y = points[:, 0], points[:, 1]
    spur = (x > 45.0) & (x < 110.0) & (np.abs(y - 70.0) < 14.0)
    points[:, 2] = np.where(spur | (x < 45.0), 9.0, 0.0)
    found = find_ground(points)
    assert found.is_ground[spur].mean() > 0.95


def test_points_that_are_not_finite_are_left_out_in_order() -> None:
    points = np.random.default_rng(0).uniform(0.0, 5.0, (50, 3)) * (1.0, 1.0, 0.01)
    with_holes = np.insert(points, [3, 20], np.nan, axis=0)
    found = find_ground(with_holes)
    assert found.left_out == 2
    np.testing.assert_array_equal(np.flatnonzero(~found.is_ground), [3, 21])


def test_kappa_is_that_of_a_table_worked_by_hand() -> None:
    ours = np.repeat([True, True, False, False], [20, 5, 10, 15])
    truth = np.repeat([True, False, True, False], [20, 5, 10, 15])
    right = agreement(ours, truth)  # Cohen 1960: agreement 0.7, by chance 0.5
    assert right == pytest.approx({"kappa": 40.0, "total_error": 30.0, "type_1": 100 / 3, "type_2": 25.0})


def test_bad_clouds_are_named() -> None:
    with pytest.raises(ConfigError, match="no finite points"):
        find_ground(np.full((3, 3), np.inf))
    with pytest.raises(LimitError, match=r"more than 4194304 cells"):
        find_ground(np.array([[0.0, 0, 0], [1e7, 1e7, 0]]))
    with pytest.raises(LimitError, match="smaller window"):
        find_ground(np.array([[0.0, 0, 0], [1900.0, 1900.0, 0]]), GroundConfig(window=100.0))
    with pytest.raises(ConfigError, match=r"\(cell\) must be between"):
        GroundConfig(cell=0.0)


def test_the_filter_tells_its_progress_and_ends_when_it_is_told_to() -> None:
    points = np.random.default_rng(2).uniform(0.0, 30.0, (3000, 3)) * [1.0, 1.0, 0.05]
    shares: list[float] = []
    whole = find_ground(points, progress=shares.append)
    assert len(shares) > 18
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
    np.testing.assert_array_equal(whole.is_ground, find_ground(points).is_ground)

    def end(share: float) -> None:
        if share > 0.3:
            raise WorkCancelledError("terrain.cancelled", "Cancelled.")

    with pytest.raises(WorkCancelledError, match="Cancelled"):
        find_ground(points, progress=end)
