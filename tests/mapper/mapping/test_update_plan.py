"""The update plan: the parameters, resolved once before any scan is read."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.grid import OccupancyGrid
from mapper.mapping import integrate
from mapper.mapping.integrate import geometry_for, integrate_log, integrate_parts
from mapper.mapping.kernels.cones import FLAT, GAUSSIAN, RAMP
from mapper.mapping.kernels.types import LogOddsUpdate
from mapper.mapping.parameters import MODELS, STRATEGIES, MappingConfig
from mapper.mapping.sensor_model import BeamModel
from mapper.mapping.update_plan import plan_update
from mapper.sensors.scan import ScanLog


@pytest.mark.parametrize("model", MODELS)
def test_a_long_log_builds_its_model_once(office_log: ScanLog, model: str, monkeypatch: pytest.MonkeyPatch) -> None:
    config = MappingConfig(model=model, resolution=0.2)
    grid = OccupancyGrid(geometry_for(office_log, config))
    built: list[str] = []

    def counted(config: MappingConfig) -> BeamModel:
        built.append(config.model)
        return STRATEGIES[config.model].build(config)

    monkeypatch.setattr(MappingConfig, "beam_model", counted)
    monkeypatch.setattr(integrate, "CHUNK_READINGS", office_log.n_beams)
    done: list[int] = []
    plan_update.cache_clear()
    integrate_log(grid, office_log, config, stop=4, progress=lambda n, _: done.append(n))
    assert (built, done) == ([model], [1, 2, 3, 4])
    built.clear()
    plan_update.cache_clear()
    assert [n for n, _ in integrate_parts(grid, office_log, config, None, 0, 4)][-1] == 4
    assert built == [model]
    plan_update.cache_clear()  # its models were built by the function above


def test_ranges_are_limited_by_the_sensor_and_by_the_parameters() -> None:
    config = MappingConfig(range_max=8.0, window=0.4, no_return="free")
    near, far = plan_update(config, 0.1, 5.0).reading_filter, plan_update(config, 0.1, np.inf).reading_filter
    assert near == (0.1, 5.0, 0.4, 0.0, True)
    assert far == (0.1, 8.0, 0.4, 0.0, True)
    assert plan_update(config, 0.1, 5.0).beam_length == pytest.approx(5.2)


def test_increments_are_rounded_and_the_clamp_can_be_off() -> None:
    plan = plan_update(MappingConfig(log_odds_hit=0.85, clamp=False), 0.0, 10.0)
    assert plan.log_odds_update == LogOddsUpdate(*(np.float32(n) for n in (-0.4, 0.85, -np.inf, np.inf)))
    assert plan.evidence == (-0.4, 0.85)


@pytest.mark.parametrize(
    ("values", "profile", "cones", "fields"),
    [
        ({"model": "fixed_increments"}, FLAT, False, False),
        ({"model": "fixed_increments", "update": "per_scan"}, FLAT, False, True),
        ({"model": "smooth_ramp"}, RAMP, False, False),
        ({"model": "smooth_ramp", "update": "per_scan"}, RAMP, True, True),
        ({"model": "sonar_cone", "cone_profile": "gaussian"}, GAUSSIAN, True, True),
        ({"model": "moravec_elfes", "update": "per_scan"}, FLAT, True, True),
    ],
)
def test_which_models_update_the_whole_field(values: dict[str, str], profile: int, cones: bool, fields: bool) -> None:
    plan = plan_update(MappingConfig().with_values(values), 0.0, 10.0)
    assert (plan.cone.profile, plan.draws_cones, plan.sees_fields) == (profile, cones, fields)
    assert plan.per_scan == (values.get("update") == "per_scan" and values["model"] != "moravec_elfes")
