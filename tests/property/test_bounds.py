"""The bounds of a whole log: computed once for all parameters that do not move them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mapper.mapping import integrate
from mapper.mapping.integrate import bounds_of_log, geometry_for
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.replay import Replay, replay
from mapper.sensors.scan import ScanLog, Trajectory

OTHER: dict[str, Any] = {
    "log_odds_hit": 1.5, "log_odds_miss": -0.1, "p_free": 0.3, "p_occ": 0.9, "cone_profile": "gaussian",
    "prior_weight": 7.0, "hit_and_passed": "only_hits", "traversal": "amanatides_woo", "clamp": False,
    "log_odds_min": -4.0, "log_odds_max": 6.0, "log_odds_prior": 0.5,
}  # fmt: skip
MOVING: dict[str, Any] = {
    "range_max": 4.0, "no_return": "hit", "resolution": 0.3, "mount_x": 0.5, "mount_y": -0.5, "mount_yaw": 0.3,
    "mount_upside_down": True, "model": "step_window", "update": "per_scan",
    "deskew": "off", "time_offset": 0.5,
}  # fmt: skip


@pytest.fixture(scope="module")
def log() -> ScanLog:
    random = np.random.default_rng(5)
    poses = np.cumsum(random.normal(0, [0.3, 0.3, 0.2], (12, 3)), axis=0)
    ranges = random.uniform(0.2, 12, (12, 40)).astype(np.float32)
    walks = {"walk": Trajectory(poses), "still": Trajectory(np.zeros((12, 3)))}
    return ScanLog(ranges, -2.0, 0.1, 0.1, 8.0, np.arange(12, dtype=np.int64), walks, mount=(0.2, 0.0, 0.1))


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[MappingConfig]:
    """The parameters for which bounds were computed."""
    found = []

    def counted(log: ScanLog, config: MappingConfig, trajectory: str | None = None) -> integrate.Bounds:
        found.append(config)
        return bounds_of_log(log, config, trajectory)

    monkeypatch.setattr(replay, "bounds_of_log", counted)
    return found


@pytest.mark.parametrize("model", BY_NAME["model"].choices)
@pytest.mark.parametrize("update", BY_NAME["update"].choices)
def test_the_parameters_without_effect_have_none(log: ScanLog, model: str, update: str) -> None:
    assert set(OTHER) == replay.WITHOUT_EFFECT
    config = MappingConfig(model=model, update=update)
    expected = np.array(bounds_of_log(log, config))
    for name, value in OTHER.items():
        changed = replace(config, **{name: value})
        assert getattr(changed, name) != getattr(config, name)
        np.testing.assert_array_equal(bounds_of_log(log, changed), expected)


def test_a_slider_that_moves_no_bounds_computes_none(log: ScanLog, computed: list[MappingConfig]) -> None:
    replay = Replay(log, MappingConfig())
    replay.advance_to(7)
    for step in range(5):
        replay.reconfigure(replace(replay.config, log_odds_hit=0.5 + 0.1 * step, clamp=step % 2 == 0))
    assert len(computed) == 1


@pytest.mark.parametrize("name", MOVING)
def test_any_other_parameter_computes_them_again(log: ScanLog, computed: list[MappingConfig], name: str) -> None:
    first = MappingConfig()
    replay = Replay(log, first)
    second = replace(first, **{name: MOVING[name]})
    replay.reconfigure(second)
    assert computed == [first, second]
    assert replay.grid.geometry == geometry_for(log, second)
    replay.reconfigure(first)
    assert len(computed) == 2, "the bounds of the first parameters are kept"
    assert replay.grid.geometry == geometry_for(log, first)


def test_only_the_last_bounds_are_kept(log: ScanLog, computed: list[MappingConfig]) -> None:
    cache = replay.BoundsCache()
    for _ in range(2):
        for n in range(replay.BOUNDS_KEPT + 1):
            cache(log, MappingConfig(mount_x=0.1 * n), "walk")
    assert len(computed) == 2 * (replay.BOUNDS_KEPT + 1)
    cache(log, MappingConfig(mount_x=0.1 * replay.BOUNDS_KEPT), "still")
    assert len(computed) == 2 * (replay.BOUNDS_KEPT + 1) + 1
