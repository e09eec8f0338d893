"""The profile along a beam, against the books' tables and against the map that a reading makes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid, log_odds
from mapper.integrate import integrate_scan
from mapper.parameters import MappingConfig
from mapper.scan import LaserScan
from mapper.sensor_model import FixedIncrements, StepWindow, beam_profile


def test_fixed_increments_have_octomaps_values() -> None:
    model = FixedIncrements()
    assert (model.log_odds_miss, model.log_odds_hit, model.window) == (-0.4, 0.85, 0.0)


def test_step_window_is_table_9_2_in_log_odds() -> None:
    model = StepWindow(p_free=0.3, p_prior=0.5, p_occ=0.9, window=0.4)
    s = [0.0, 1.0, 1.79, 1.81, 2.0, 2.19, 2.21, 5.0]
    expected = [np.log(0.3 / 0.7)] * 3 + [np.log(9)] * 3 + [0.0] * 2
    np.testing.assert_allclose(beam_profile(model, 2.0, s), expected)


def test_evidence_is_counted_from_the_prior() -> None:
    model = StepWindow(p_free=0.3, p_prior=0.4, p_occ=0.9)
    assert model.log_odds_miss == pytest.approx(log_odds(0.3) - log_odds(0.4))
    assert model.log_odds_hit == pytest.approx(log_odds(0.9) - log_odds(0.4))


def test_no_return_says_nothing_or_free() -> None:
    model, s = FixedIncrements(), [0.0, 5.0, 10.0, 10.1]
    for z in (np.inf, 12.0):
        assert beam_profile(model, z, s, 10.0).tolist() == [0.0] * 4
        assert beam_profile(model, z, s, 10.0, no_return="free").tolist() == [-0.4, -0.4, -0.4, 0.0]


@pytest.mark.parametrize("z", [np.nan, -np.inf, -1.0])
def test_no_reading_says_nothing(z: float) -> None:
    assert not beam_profile(FixedIncrements(), z, np.linspace(0, 10, 50), 10.0, no_return="free").any()


@given(st.floats(0.5, 9.0), st.floats(0.05, 2.0), st.sampled_from(["per_beam", "per_scan"]))
def test_the_profile_is_what_the_map_gets(z: float, window: float, update: str) -> None:
    config = MappingConfig(update=update, window=window, clamp=False, resolution=0.1)
    z = float(np.float32(z))
    grid = OccupancyGrid(GridGeometry(0.1, 1, 130))
    integrate_scan(grid, LaserScan(np.array([z], dtype=np.float32), 0.0, 0.5, 0.0, 80.0), (0.0, 0.05, 0.0), config)
    s = np.arange(130) * 0.1 + 0.05
    expected = beam_profile(config.beam_model(), z, s)
    # The cell that holds the endpoint is a hit in any case; a centre on a zone's border goes either way.
    sure = (np.abs(np.abs(s - z) - window / 2) > 1e-6) & (np.arange(130) != int(z / 0.1))
    row = grid.geometry.world_to_cell((0.0, 0.05))[0]
    np.testing.assert_allclose(grid.log_odds[row, : len(s)][sure], expected[sure].astype(np.float32))


@pytest.mark.parametrize(
    ("make", "code"),
    [
        (lambda: FixedIncrements(log_odds_miss=0.1), "model.miss"),
        (lambda: FixedIncrements(log_odds_miss=-np.inf), "model.miss"),
        (lambda: FixedIncrements(log_odds_hit=-0.1), "model.hit"),
        (lambda: FixedIncrements(log_odds_hit=np.nan), "model.hit"),
        (lambda: FixedIncrements(window=-1.0), "model.window"),
        (lambda: StepWindow(window=np.inf), "model.window"),
        (lambda: StepWindow(p_free=0.0), "model.probabilities"),
        (lambda: StepWindow(p_free=0.6), "model.probabilities"),
        (lambda: StepWindow(p_occ=1.0), "model.probabilities"),
        (lambda: StepWindow(p_occ=0.4, p_free=0.3), "model.probabilities"),
    ],
)
def test_an_impossible_model_is_refused(make, code: str) -> None:
    with pytest.raises(ConfigError) as refused:
        make()
    assert refused.value.code == code
