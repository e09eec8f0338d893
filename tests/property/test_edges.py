"""Cells exactly at the limits of a beam's evidence: on which side of each limit they count, in closed form.

A centre on a border is a rare chance among random numbers, so each is put there: cells of 1 m, a sensor that stands on
a cell's centre, and numbers that doubles hold exactly.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import integrate_log
from mapper.mapping.parameters import MODELS, MappingConfig
from mapper.mapping.provenance import provenance
from mapper.sensors.scan import ScanLog, Trajectory

#: Ways of mapping: model, update, traversal.
THIN = [
    ("fixed_increments", "per_beam", "bresenham"),
    ("fixed_increments", "per_beam", "amanatides_woo"),
    ("step_window", "per_beam", "amanatides_woo"),
]
FIELDS = [
    ("fixed_increments", "per_scan", "bresenham"),
    ("sonar_cone", "per_beam", "bresenham"),
    ("sonar_cone", "per_scan", "bresenham"),
]


def config_of(kind: tuple[str, str, str], **values: object) -> MappingConfig:
    model, update, traversal = kind
    return MappingConfig(model=model, update=update, traversal=traversal, resolution=1.0, opening=0.52).with_values(
        values
    )


def log_of(reading: float, pose: tuple[float, float, float], bearing: float = 0.0) -> ScanLog:
    return ScanLog(
        np.array([[reading]], dtype=np.float32), bearing, 0.52, 0.0, 80.0, np.zeros(1, np.int64),
        {"one": Trajectory(np.array([pose]))},
    )  # fmt: skip


def signs(grid: OccupancyGrid) -> list[list[int]]:
    """Return −1 for a cell that is more free than at first, 1 for one that is more occupied, row by row."""
    found: list[list[int]] = np.sign(grid.log_odds).astype(int).tolist()
    return found


def mapped(shape: tuple[int, int], log: ScanLog, config: MappingConfig) -> OccupancyGrid:
    """Return the map of a log, having asked each of its cells why."""
    grid = OccupancyGrid(GridGeometry(1.0, *shape))
    integrate_log(grid, log, config)
    for cell in np.ndindex(shape):
        told = provenance(grid.geometry, log, config, cell)
        assert len(told.scans) == grid.observed[cell], f"cell {cell} and its provenance"
        assert told.after == grid.log_odds[cell]
    return grid


@pytest.mark.parametrize("kind", THIN + FIELDS)
def test_a_window_is_free_before_occupied_within_its_borders_included_and_silent_beyond(kind) -> None:
    grid = mapped((1, 10), log_of(5.0, (0.5, 0.5, 0.0)), config_of(kind, window=2.0))
    # Centres lie at s = 0 … 9 from the sensor; z − r/2 = 4 and z + r/2 = 6. A field has no cell where the sensor is,
    # for that centre has no bearing.
    here = -1 if kind in THIN else 0
    assert signs(grid) == [[here, -1, -1, -1, 1, 1, 1, 0, 0, 0]]


@pytest.mark.parametrize("kind", THIN + FIELDS)
def test_no_return_frees_a_line_to_the_cell_at_the_max_range_and_a_field_to_the_centres_before_it(kind) -> None:
    grid = mapped((1, 8), log_of(np.inf, (0.5, 0.5, 0.0)), config_of(kind, no_return="free", range_max=4.0))
    assert signs(grid) == [[-1, -1, -1, -1, -1, 0, 0, 0] if kind in THIN else [0, -1, -1, -1, 0, 0, 0, 0]]


@pytest.mark.parametrize("kind", THIN + FIELDS)
def test_no_return_as_a_hit_at_the_max_range_is_a_hit_there(kind) -> None:
    grid = mapped((1, 8), log_of(np.inf, (0.5, 0.5, 0.0)), config_of(kind, no_return="hit", range_max=4.0))
    here = -1 if kind in THIN else 0
    assert signs(grid) == [[here, -1, -1, -1, 1, 0, 0, 0]]


@pytest.mark.parametrize("kind", FIELDS)
@pytest.mark.parametrize(("bearing", "included"), [(0.26, True), (-0.26, False)])
@pytest.mark.parametrize("clockwise", [False, True])
def test_a_field_includes_its_right_edge_and_excludes_its_left_one(kind, bearing, included, clockwise) -> None:
    # The row of the sensor lies on the right edge of a beam at 0.26 rad, half an increment away, and on the left edge
    # of one at −0.26. A sweep the other way round changes nothing in that.
    increment = -0.52 if clockwise else 0.52
    log = ScanLog(
        np.full((1, 1), 6.0, dtype=np.float32), bearing, increment, 0.0, 80.0, np.zeros(1, np.int64),
        {"one": Trajectory(np.array([[0.5, 3.5, 0.0]]))},
    )  # fmt: skip
    grid = mapped((7, 7), log, config_of(kind))
    assert (grid.log_odds[3, 2:5] < 0).tolist() == [included] * 3
    beside = grid.log_odds[4 if bearing > 0 else 2, 4:6]
    assert (beside < 0).all()


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
@pytest.mark.parametrize("traversal", ["bresenham", "amanatides_woo"])
@pytest.mark.parametrize("no_return", ["ignore", "free", "hit"])
def test_readings_that_are_no_ranges(model: str, update: str, traversal: str, no_return: str) -> None:
    # A max range that float32, as readings are kept, rounds up: as a reading it must still be within the range.
    assert float(np.float32(3.9)) > 3.9
    config = config_of((model, update, traversal), no_return=no_return, range_max=3.9)

    def grid_of(reading: float) -> OccupancyGrid:
        grid = OccupancyGrid(GridGeometry(1.0, 12, 12))
        log = log_of(reading, (5.37, 5.81, 0.3))  # no centre lies on a border of the beam's field
        count = integrate_log(grid, replace(log, range_min=0.1), config)
        assert (count > 0) == grid.observed.any()
        return grid

    for reading in (np.nan, -np.inf, -1.0, 0.0, 0.05):  # REP 117: invalid, too close, below range_min
        assert not grid_of(reading).observed.any(), reading
    for reading in (np.inf, 4.5, 90.0):  # nothing returned, beyond the max range, beyond the sensor's
        grid = grid_of(reading)
        found = {sign for row in signs(grid) for sign in row}
        assert found == {"ignore": {0}, "free": {-1, 0}, "hit": {-1, 0, 1}}[no_return], reading
    assert {sign for row in signs(grid_of(3.0)) for sign in row} == {-1, 0, 1}
