"""The two ways to compute a perceptual field: along its boundary, and by the exact test near it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mapper.core.errors import ConfigError
from mapper.core.limits import Limits
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping import textbook
from mapper.mapping import update as fields
from mapper.mapping.integrate import integrate_log
from mapper.mapping.kernels.bitmask_fill import HITS
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.scan_batch import scan_batch_of_log
from mapper.mapping.update_plan import plan_update
from mapper.sensors.scan import ScanLog, Trajectory


def log_of(seed: int, n_beams: int, increment: float, pose: tuple[float, float, float]) -> ScanLog:
    random = np.random.default_rng(seed)
    ranges = random.uniform(0.1, 4.0, (1, n_beams)).astype(np.float32)
    ranges[random.random(ranges.shape) < 0.1] = np.inf
    stamps = np.zeros(1, dtype=np.int64)
    return ScanLog(ranges, -2.0, increment, 0.05, 80.0, stamps, {"one": Trajectory(np.array([pose]))})


def decline(planned: fields.PlannedFields) -> None:
    """Let no scan be sure, so that the exact test does all of them."""
    for part in planned.parts:
        starts, sure, _ = part.plan
        starts[:, :HITS] = starts[:, HITS : HITS + 1]
        sure[:] = False


def draw(log: ScanLog, config: MappingConfig, *, exactly: bool) -> tuple[OccupancyGrid, int]:
    grid = OccupancyGrid(GridGeometry(0.1, 80, 75, (-4.0, -3.0, 0.3)))
    plan = plan_update(config, log.range_min, log.range_max)
    batch = scan_batch_of_log(log, plan, None, 0, 1)
    planned = fields.plan_of_fields(batch.scans_on(grid.geometry), grid.geometry, plan, 1)
    if exactly:
        decline(planned)
    box = np.array([80, 0, 75, 0])
    if planned.rows[0] >= planned.rows[1] or planned.words[0] >= planned.words[1]:
        return grid, 0
    count = fields.drawer_of_fields(planned, grid, plan.log_odds_update)(*planned.rows, box)
    rows, cols = np.nonzero(grid.observed)
    if count:
        assert box.tolist() == [rows.min(), rows.max() + 1, cols.min(), cols.max() + 1]
    return grid, count


@given(
    seed=st.integers(0, 2**32 - 1),
    n_beams=st.integers(1, 90),
    increment=st.sampled_from([np.pi / 180, -np.pi / 180, 0.07, 2 * np.pi / 90]),
    pose=st.tuples(st.floats(-5, 5), st.floats(-4, 5), st.floats(-4, 4)),
    window=st.sampled_from([0.0, 0.4]),
)
@settings(max_examples=150)
def test_border_and_exact_test_fill_the_same_cells(seed, n_beams, increment, pose, window) -> None:
    model = "step_window" if window else "fixed_increments"
    config = MappingConfig(model=model, update="per_scan", no_return="free", range_max=5.0, window=window)
    log = log_of(seed, n_beams, increment, pose)
    along_border, n_border = draw(log, config, exactly=False)
    exact, n_exact = draw(log, config, exactly=True)
    assert n_border == n_exact
    np.testing.assert_array_equal(along_border.log_odds, exact.log_odds)
    np.testing.assert_array_equal(along_border.observed, exact.observed)


@given(
    cols=st.integers(1, 75),
    rows=st.integers(1, 40),
    corner=st.tuples(st.floats(-3, 1), st.floats(-3, 1)),
    seed=st.integers(0, 2**32 - 1),
    window=st.sampled_from([0.0, 0.4]),
)
@settings(max_examples=60, deadline=None)
def test_grids_of_every_width_are_clipped_alike(cols, rows, corner, seed, window) -> None:
    # A word holds 32 cells, and few grids are a whole number of words wide.
    model = "step_window" if window else "fixed_increments"
    config = MappingConfig(model=model, update="per_scan", no_return="free", range_max=5.0, window=window)
    log = log_of(seed, 60, np.pi / 30, (0.123, 0.456, 0.789))
    ours = OccupancyGrid(GridGeometry(0.1, rows, cols, (*corner, 0.0)))
    book = OccupancyGrid(ours.geometry)
    n_book = textbook.update_per_scan(book, log.scan(0), log.sensor_poses()[0], config)
    n_ours = integrate_log(ours, log, config)
    assert n_ours == n_book
    np.testing.assert_allclose(ours.log_odds, book.log_odds, atol=1e-6)
    np.testing.assert_array_equal(ours.observed, book.observed)


@pytest.mark.parametrize(("rows", "cols"), [(65_504, 1), (1, 65_504)])
def test_a_grid_too_long_for_a_sheet_is_refused_and_stays_as_it_was(rows, cols) -> None:
    grid = OccupancyGrid(GridGeometry(0.1, rows, cols, limits=Limits(max_side=1 << 17)))
    log = log_of(1, 60, np.pi / 30, (0.0, 0.0, 0.0))
    with pytest.raises(ConfigError, match="65504 rows and columns; choose larger cells"):
        integrate_log(grid, log, MappingConfig(update="per_scan"))
    assert not grid.observed.any()


def test_a_grid_as_large_as_the_bitmask_is_mapped_to_its_end() -> None:
    config = MappingConfig(update="per_scan", range_max=5.0)
    log = log_of(2, 60, np.pi / 30, (0.1 * 65_500, 0.05, 0.0))
    ours = OccupancyGrid(GridGeometry(0.1, 2, 65_503, limits=Limits(max_side=1 << 17)))
    book = OccupancyGrid(ours.geometry)
    textbook.update_per_scan(book, log.scan(0), log.sensor_poses()[0], config)
    integrate_log(ours, log, config)
    np.testing.assert_allclose(ours.log_odds, book.log_odds, atol=1e-6)
    assert ours.observed[:, -4:].any()
