"""The provenance of a cell adds up to its value, with every kind of update."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.mapping.integrate import geometry_for
from mapper.mapping.parameters import MODELS, MappingConfig
from mapper.mapping.provenance import provenance
from mapper.replay import Replay
from mapper.sensors.scan import ScanLog, Trajectory

KINDS = list(
    itertools.product(["per_beam", "per_scan"], ["bresenham", "amanatides_woo"], [0.0, 0.3], ["ignore", "free"])
)


@pytest.mark.parametrize(("update", "traversal", "window", "no_return"), KINDS)
def test_the_last_entry_is_the_map(
    office_log: ScanLog, update: str, traversal: str, window: float, no_return: str
) -> None:
    config = MappingConfig(
        update=update, traversal=traversal, window=window, no_return=no_return, resolution=0.1, log_odds_prior=0.2
    )
    replay = Replay(office_log, config)
    replay.advance_to(60)
    grid, random = replay.grid, np.random.default_rng(5)
    occupied, seen = np.argwhere(grid.log_odds > 1.0), np.argwhere(grid.observed)
    for row, col in [*random.choice(occupied, 25), *random.choice(seen, 25)]:
        told = replay.provenance(row, col)
        assert len(told.scans) > 0
        assert told.log_odds[-1] == grid.log_odds[row, col]
        assert (np.diff(told.scans * office_log.n_beams + told.beams) > 0).all()
        assert told.scans.max() < 60
        np.testing.assert_array_equal(told.increments > 0, told.hits)
        np.testing.assert_array_equal(told.ranges, office_log.ranges[told.scans, told.beams])
    unseen = np.argwhere(~grid.observed)
    for row, col in random.choice(unseen, 25):
        assert len(replay.provenance(row, col).scans) == 0


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
@pytest.mark.parametrize("no_return", ["free", "hit"])
@pytest.mark.parametrize("model", MODELS)
def test_the_last_entry_is_the_map_of_every_model(office_log: ScanLog, model: str, update: str, no_return: str) -> None:
    config = MappingConfig(model=model, update=update, no_return=no_return, resolution=0.1, range_max=4.0, opening=0.1)
    replay = Replay(office_log, config)
    replay.advance_to(10)
    grid, random = replay.grid, np.random.default_rng(5)
    seen = np.argwhere(grid.observed)
    for row, col in random.choice(seen, 8):
        told = replay.provenance(row, col)
        assert told.log_odds[-1] == pytest.approx(float(grid.log_odds[row, col]), abs=1e-5)
        np.testing.assert_allclose(told.before + np.cumsum(told.increments)[:1], told.log_odds[:1], atol=1e-5)
    for row, col in random.choice(np.argwhere(~grid.observed), 8):
        assert len(replay.provenance(row, col).scans) == 0


@pytest.mark.parametrize("model", MODELS)
def test_the_provenance_of_several_logs_is_given_for_each_log(office_log: ScanLog, model: str) -> None:
    config = MappingConfig(model=model, resolution=0.1, range_max=4.0, opening=0.1)
    whole = Replay(office_log, config)
    whole.advance_to(12)
    row, col = np.random.default_rng(1).choice(np.argwhere(whole.grid.observed), 1)[0]
    at_once = whole.provenance(row, col)
    parts = [_part(office_log, 0, 5), _part(office_log, 5, 12)]
    first = provenance(whole.grid.geometry, parts[0], config, (row, col))
    second = provenance(whole.grid.geometry, parts[1], config, (row, col), before=first)
    assert second.before == first.after
    np.testing.assert_allclose(np.concatenate([first.log_odds, second.log_odds]), at_once.log_odds, atol=1e-5)


def _part(log: ScanLog, start: int, stop: int) -> ScanLog:
    poses = Trajectory(log.trajectory().poses[start:stop])
    return replace(
        log, ranges=log.ranges[start:stop], stamps_ns=log.stamps_ns[start:stop], trajectories={"part": poses}
    )


def test_a_cell_that_is_not_there(office_log: ScanLog) -> None:
    replay = Replay(office_log, MappingConfig(resolution=0.2))
    geometry = replay.grid.geometry
    with pytest.raises(ConfigError, match=rf"outside the grid of {geometry.cols} × {geometry.rows} cells"):
        replay.provenance(-1, 0)
    with pytest.raises(ConfigError, match="outside the grid"):
        replay.provenance(0, replay.grid.geometry.cols)


@pytest.mark.parametrize("model", ["fixed_increments", "hit_counting", "moravec_elfes", "smooth_ramp"])
def test_it_is_the_same_in_however_many_parts_the_log_is_looked_through(
    office_log: ScanLog, model: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = MappingConfig().with_values({"model": model, "resolution": 0.2})
    geometry = geometry_for(office_log, config)
    row, col = (int(n) for n in geometry.world_to_cell(office_log.sensor_poses()[20, :2] + (0.5, 0.3)))
    told = {}
    for scans in (7, 10_000):
        pauses: list[None] = []
        monkeypatch.setattr("mapper.mapping.provenance._FIRST_READINGS", scans * office_log.n_beams)
        monkeypatch.setattr("mapper.mapping.provenance.scans_at_once", lambda *_, scans=scans: scans)
        told[scans] = provenance(geometry, office_log, config, (row, col), stop=60, pause=lambda: pauses.append(None))  # noqa: B023
        assert len(pauses) == -(-60 // scans)
    few, many = told.values()
    assert len(few.scans) > 0
    for name in ("scans", "beams", "ranges", "hits", "increments", "log_odds"):
        np.testing.assert_array_equal(getattr(few, name), getattr(many, name))
