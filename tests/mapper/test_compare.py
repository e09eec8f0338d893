"""Two maps compared: counts by hand, and signs."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.compare import compare, wall_contrast
from mapper.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.integrate import grid_for, integrate_log
from mapper.metrics import entropy
from mapper.parameters import MappingConfig
from mapper.scan import ScanLog


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
    np.testing.assert_allclose(found.log_odds, [[0.0, 4.0, -2.0, -0.1]], atol=1e-6)
    assert found.entropy_bits[0] == pytest.approx(2 * float(entropy(2.0)) + 1 + float(entropy(0.1)))


def test_maps_that_lie_apart_are_laid_over_one_another() -> None:
    a, b = grid([[2.0, 2.0]]), grid([[2.0, -2.0]], (1.0, 0.0, 0.0))
    found = compare(a, b)
    assert found.geometry.shape == (1, 3)
    assert found.changed == {("occupied", "unknown"): 1, ("unknown", "free"): 1}
    np.testing.assert_allclose(found.log_odds, [[-2.0, 0.0, -2.0]])
    np.testing.assert_allclose(compare(b, a).log_odds, -found.log_odds)


def test_a_map_is_like_itself(office_log: ScanLog) -> None:
    config = MappingConfig(resolution=0.1)
    one = grid_for(office_log, config)
    integrate_log(one, office_log, config)
    found = compare(one, one)
    assert not found.changed
    assert not found.log_odds.any()
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
