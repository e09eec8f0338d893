"""Comparison of two maps: counts by hand, and signs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.compare import compare, difference, wall_contrast
from mapper.grid.metrics import entropy
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog


def grid(log_odds: list[list[float]], origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> OccupancyGrid:
    """A map whose cells are all observed but those that are NaN."""
    values = np.array(log_odds, dtype=np.float32)
    out = OccupancyGrid(GridGeometry(1.0, values.shape[0], values.shape[1], origin))
    out.observed = ~np.isnan(values)
    out.log_odds[out.observed] = values[out.observed]
    return out


def test_states_and_differences_by_hand() -> None:
    a, b = grid([[2.0, -2.0, np.nan, 0.1]]), grid([[2.0, 2.0, -2.0, np.nan]])
    found = compare(a, b)
    assert found.changed == {("free", "occupied"): 1, ("unknown", "free"): 1}
    assert found.same == 2
    assert found.states.tolist() == [[0, 1, 0], [0, 1, 0], [1, 0, 1]]
    assert (found.only, found.both) == ((1, 1), 2)
    assert (found.mean_difference, found.max_difference, found.max_at_xy) == (2.0, 4.0, (1.5, 0.5))
    np.testing.assert_allclose(difference(a, b).log_odds, [[0.0, 4.0, -2.0, -0.1]], atol=1e-6)
    assert found.entropy_bits[0] == pytest.approx(2 * float(entropy(2.0)) + 1 + float(entropy(0.1)))


def test_maps_with_other_origins_are_aligned() -> None:
    a, b = grid([[2.0, 2.0]]), grid([[2.0, -2.0]], (1.0, 0.0, 0.0))
    found = compare(a, b)
    assert found.geometry.shape == (1, 3)
    assert found.changed == {("occupied", "unknown"): 1, ("unknown", "free"): 1}
    np.testing.assert_allclose(difference(a, b).log_odds, [[-2.0, 0.0, -2.0]])
    np.testing.assert_allclose(difference(b, a).log_odds, -difference(a, b).log_odds)
    np.testing.assert_array_equal(compare(b, a).states, found.states.T)
    assert (found.only, found.both, found.max_difference) == ((1, 1), 1, 0.0)


@given(st.integers(0, 2**32 - 1), st.tuples(st.integers(-9, 9), st.integers(-9, 9)))
def test_the_numbers_are_those_of_plain_numpy(seed: int, offset: tuple[int, int]) -> None:
    random = np.random.default_rng(seed)

    def some(shape: tuple[int, int], origin: tuple[float, float, float], prior: float) -> OccupancyGrid:
        out = OccupancyGrid(GridGeometry(1.0, *shape, origin), prior)
        out.observed = random.random(shape) < 0.6
        # Some values again and again, as maps have them.
        values = np.where(random.random(shape) < 0.5, random.uniform(-6, 6, shape), random.integers(-4, 5, shape))
        out.log_odds = np.where(out.observed, values, prior).astype(np.float32)
        return out

    a = some((7, 6), (0.0, 0.0, 0.0), 0.0)
    b = some((5, 8), (float(offset[1]), float(offset[0]), 0.0), 0.25)
    # Both on a large sheet, cell by cell.
    sheet = [(np.full((40, 40), prior), np.zeros((40, 40), dtype=bool)) for prior in (0.0, 0.25)]
    for (values, seen), grid, (row, col) in zip(sheet, (a, b), ((0, 0), offset), strict=True):
        part = np.s_[15 + row : 15 + row + grid.geometry.rows, 15 + col : 15 + col + grid.geometry.cols]
        values[part], seen[part] = grid.log_odds, grid.observed
    (la, sa), (lb, sb) = sheet
    pa, pb = 1.0 / (1.0 + np.exp(-la)), 1.0 / (1.0 + np.exp(-lb))
    state_a, state_b = (
        np.where(seen & (p < 0.25), 0, np.where(seen & (p > 0.65), 1, 2)) for p, seen in ((pa, sa), (pb, sb))
    )
    found = compare(a, b)
    table = np.array([[np.sum((state_a == i) & (state_b == j)) for j in range(3)] for i in range(3)])
    table[2, 2] += found.cells - table.sum()  # the sheet is larger than the lattice that holds both
    np.testing.assert_array_equal(found.states, table)
    assert found.cells == found.geometry.rows * found.geometry.cols
    assert found.same == np.sum((sa | sb) & (state_a == state_b))
    assert found.only == (int(np.sum(sa & ~sb)), int(np.sum(sb & ~sa)))
    assert found.both == np.sum(sa & sb)
    for p, bits in zip((pa, pb), found.entropy_bits, strict=True):
        seen_p = p[sa | sb]
        assert bits == pytest.approx(-np.sum(seen_p * np.log2(seen_p) + (1 - seen_p) * np.log2(1 - seen_p)), rel=1e-6)
    apart = np.abs(lb - la)[sa & sb]
    assert found.mean_difference == pytest.approx(apart.mean() if apart.size else 0.0, rel=1e-6)
    assert found.max_difference == pytest.approx(apart.max() if apart.size else 0.0, rel=1e-6)
    if found.max_at_xy is not None:
        col, row = (int(np.floor(v)) for v in found.max_at_xy)
        assert np.abs(lb - la)[15 + row, 15 + col] == pytest.approx(found.max_difference)
    for p, seen, contrast in ((pa, sa, found.contrast[0]), (pb, sb, found.contrast[1])):
        steps = [
            abs(p[r, c] - p[r + dr, c + dc])
            for r, c in np.argwhere(seen)
            for dr, dc in ((0, 1), (1, 0))
            if seen[r + dr, c + dc] and (p[r, c] > 0.5) != (p[r + dr, c + dc] > 0.5)
        ]
        assert contrast == pytest.approx(np.mean(steps) if steps else 0.0, rel=1e-6)


def test_a_map_is_like_itself(office_log: ScanLog) -> None:
    config = MappingConfig(resolution=0.1)
    one = grid_for(office_log, config)
    integrate_log(one, office_log, config)
    found = compare(one, one)
    assert not found.changed
    assert not difference(one, one).log_odds.any()
    assert found.mean_difference == found.max_difference == 0.0
    assert found.only == (0, 0)
    assert found.same == np.count_nonzero(one.observed)


def test_a_smeared_wall_has_less_contrast(office_log: ScanLog) -> None:
    sharp_config, smeared_config = MappingConfig(resolution=0.1), MappingConfig(resolution=0.1, mount_yaw=0.1)
    sharp, smeared = grid_for(office_log, sharp_config), grid_for(office_log, smeared_config)
    integrate_log(sharp, office_log, sharp_config)
    integrate_log(smeared, office_log, smeared_config)
    assert wall_contrast(smeared) < wall_contrast(sharp)
    assert wall_contrast(grid([[9.0, -9.0]])) == pytest.approx(1.0, abs=1e-3)
    assert wall_contrast(grid([[1.0, 1.0]])) == 0.0


def test_cells_that_do_not_coincide_are_refused() -> None:
    with pytest.raises(ConfigError, match="whole number"):
        compare(grid([[1.0]]), grid([[1.0]], (0.5, 0.0, 0.0)))
