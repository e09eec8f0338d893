"""The parameter table, and the config with one value for each row."""

from dataclasses import fields

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter
from mapper.mapping.parameters import BY_NAME, PARAMETERS, MappingConfig
from mapper.mapping.sensor_model import FixedIncrements, StepWindow

NUMBERS = [row for row in PARAMETERS if row.kind == "number"]
CHOICES = [row for row in PARAMETERS if row.kind == "choice"]


def test_the_table_and_the_config_name_the_same_things() -> None:
    assert [f.name for f in fields(MappingConfig)] == [row.name for row in PARAMETERS]
    assert MappingConfig() == MappingConfig(**{row.name: row.initial for row in PARAMETERS})  # type: ignore[arg-type]


@pytest.mark.parametrize("row", PARAMETERS, ids=lambda row: row.name)
def test_each_row_is_complete(row: Parameter) -> None:
    assert row.sentence.endswith(".")
    assert row.label
    assert row.check(row.initial) == row.initial
    assert set(row.only_for) <= set(BY_NAME["model"].choices)
    if row.kind == "number":
        assert row.low < row.high
        assert 0 < row.step <= row.high - row.low


def name(row: Parameter) -> str:
    return row.name


@pytest.mark.parametrize("row", NUMBERS, ids=name)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, "1", None, True, [1.0]])
def test_a_value_that_is_no_number_is_refused_with_the_parameters_name(row: Parameter, value: object) -> None:
    with pytest.raises(ConfigError, match=rf"\({row.name}\) must be a finite number") as refused:
        MappingConfig().with_values({row.name: value})
    assert refused.value.code == f"parameter.{row.name}"


@pytest.mark.parametrize("row", NUMBERS, ids=name)
def test_a_number_out_of_its_bounds_is_refused_by_name(row: Parameter) -> None:
    for value in (row.low - row.step, row.high + row.step):
        with pytest.raises(ConfigError, match=rf"\({row.name}\) must be between") as refused:
            MappingConfig().with_values({row.name: value})
        assert refused.value.code == f"parameter.{row.name}"


@pytest.mark.parametrize("row", CHOICES, ids=name)
def test_an_unknown_choice_is_refused_by_name(row: Parameter) -> None:
    for value in ("nonsense", 1, None, True):
        with pytest.raises(ConfigError, match=rf"\({row.name}\) must be one of"):
            MappingConfig().with_values({row.name: value})
    for choice in row.choices:
        assert getattr(MappingConfig().with_values({row.name: choice}), row.name) == choice


def test_a_flag_is_true_or_false() -> None:
    with pytest.raises(ConfigError, match="true or false"):
        MappingConfig().with_values({"clamp": 1})
    assert MappingConfig(clamp=False).clamp_limits == (-np.inf, np.inf)
    assert MappingConfig().clamp_limits == (-2.0, 3.5)


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(ConfigError, match="no parameter 'hit'"):
        MappingConfig().with_values({"hit": 1.0})


def test_constraints_between_two_parameters_are_checked() -> None:
    with pytest.raises(ConfigError, match="below the upper clamp"):
        MappingConfig(log_odds_min=0.0, log_odds_max=0.0)
    with pytest.raises(ConfigError, match="p_free ≤ p_prior"):
        MappingConfig(model="step_window", p_free=0.6)
    # The other model does not use p_free, so it may stand at any value.
    assert MappingConfig(p_free=0.6).beam_model() == FixedIncrements()


def test_models_are_made_from_the_values() -> None:
    config = MappingConfig(model="step_window", p_free=0.2, p_occ=0.8, window=0.3, log_odds_prior=0.1)
    model = config.beam_model()
    assert isinstance(model, StepWindow)
    assert (model.p_free, model.p_occ, model.window) == (0.2, 0.8, 0.3)
    assert model.p_prior == pytest.approx(1 / (1 + np.exp(-0.1)))
    assert MappingConfig(mount_x=1, mount_y=-1, mount_yaw=0.5).mount == (1.0, -1.0, 0.5)
