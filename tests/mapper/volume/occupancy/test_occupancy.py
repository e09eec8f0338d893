"""Contents and queries of a map after one or two beams, by values known beforehand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.volume import (
    OccupancyVolume,
    VolumeConfig,
    cast,
    changes_between,
    distance_to_obstacle,
    project,
    voxels_in_box,
)
from mapper.volume.occupancy.queries import HIT, OUTSIDE, TOO_FAR, UNKNOWN
from tests.mapper.volume.voxel_values import log_odds_at

CONFIG = VolumeConfig(resolution=0.1)
ORIGIN, WALL = [0.05, 0.05, 0.05], [1.05, 0.05, 0.05]
HIT_LOG_ODDS, MISS_LOG_ODDS = math.log(0.7 / 0.3), math.log(0.4 / 0.6)


def one_beam(config: VolumeConfig = CONFIG, times: int = 1) -> OccupancyVolume:
    volume = OccupancyVolume(config)
    for _ in range(times):
        volume.insert_scan([WALL], ORIGIN)
    return volume


def test_a_beam_frees_what_it_passes_and_ends_in_the_last_voxel() -> None:
    places = [[x / 10 + 0.05, 0.05, 0.05] for x in range(12)]
    found = log_odds_at(one_beam(), places)
    np.testing.assert_allclose(found[:10], MISS_LOG_ODDS, rtol=1e-6)
    assert found[10] == pytest.approx(HIT_LOG_ODDS)
    assert np.isnan(found[11])
    assert np.isnan(log_odds_at(one_beam(), [[np.nan, 0.0, 0.0], [1e7, 0.0, 0.0]])).all()


def test_log_odds_are_clamped() -> None:
    free, occupied = log_odds_at(one_beam(times=50), [ORIGIN, WALL])
    assert (free, occupied) == (CONFIG.log_odds_min, CONFIG.log_odds_max)
    assert (free, occupied) == (pytest.approx(-2.0, abs=1e-3), pytest.approx(3.5, abs=0.02))


def test_log_odds_halve_with_time_and_are_forgotten() -> None:
    volume = one_beam(replace(CONFIG, half_life=10.0))
    volume.decay(10.0)
    assert log_odds_at(volume, [WALL])[0] == pytest.approx(HIT_LOG_ODDS / 2)
    volume.decay(20.0)  # now an eighth: that of the hit is 0.106, that of the misses 0.05
    assert volume.n_known == 1
    assert cast(volume, ORIGIN, [[1.0, 0.0, 0.0]]).ends[0] == HIT
    volume.decay(10.0)
    assert volume.n_known == 0
    assert cast(volume, ORIGIN, [[1.0, 0.0, 0.0]], range_max=5.0).ends[0] == TOO_FAR


def test_casts_end_where_they_should() -> None:
    volume = one_beam()
    casts = cast(volume, ORIGIN, [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]], through_unknown=False)
    assert casts.ends.tolist() == [HIT, UNKNOWN, UNKNOWN]
    np.testing.assert_allclose(casts.points, [WALL, [0.05, 0.15, 0.05], [-0.05, 0.05, 0.05]], atol=1e-6)
    assert cast(volume, ORIGIN, [[0.0, 1.0, 0.0]]).ends[0] == OUTSIDE
    assert cast(volume, [1e6, 0.0, 0.0], [[0.0, 1.0, 0.0]]).ends[0] == OUTSIDE
    with pytest.raises(ConfigError, match="length is not 0"):
        cast(volume, ORIGIN, [[0.0, 0.0, 0.0]])


def test_the_nearest_obstacle_may_be_far() -> None:
    volume = one_beam()
    volume.insert_scan([[-200.0, 0.0, 0.0]], [-200.5, 0.0, 0.0])
    apart = distance_to_obstacle(volume, [[1.05, 0.45, 0.05], [-90.0, 0.05, 0.05], [0.05, 0.05, 300.0]], 250.0)
    np.testing.assert_allclose(apart[:2], [0.4, 91.05])
    assert apart[2] == math.inf
    assert distance_to_obstacle(volume, [[1.05, 0.45, 0.05]], 0.3)[0] == math.inf


def test_a_box_has_the_voxels_whose_centres_it_holds() -> None:
    keys, values = voxels_in_box(one_beam(), [0.84, -1.0, 0.0], [5.0, 0.05, 0.05])
    assert sorted(keys[:, 0] - 32768) == [8, 9, 10]
    assert (values > 0.0).tolist().count(True) == 1


def test_a_low_table_is_under_the_plane_of_the_lidar() -> None:
    """A plane of the map has no table that is below it; the band of heights that the robot has does."""
    volume = OccupancyVolume(CONFIG)
    table = np.stack(np.meshgrid(np.arange(1.0, 1.6, 0.05), np.arange(0.0, 0.6, 0.05)), axis=-1).reshape(-1, 2)
    volume.insert_scan(np.column_stack([table, np.full(len(table), 0.42)]), [0.0, 0.0, 1.05])
    on_table = [[1.25, 0.25]]
    plane, band = project(volume, 0.95, 0.95), project(volume, 0.05, 1.2)
    row, col = band.geometry.world_to_cell(on_table)[0]
    assert band.log_odds[row, col] > 0.0
    assert not (plane.log_odds[plane.observed] > 0.0).any()
    with pytest.raises(ConfigError, match="no known voxels between 7 and 8 m"):
        project(volume, 7.0, 8.0)


def test_changes_are_those_of_voxels_that_both_maps_know() -> None:
    before, after = one_beam(), one_beam()
    after.insert_scan([[0.55, 0.05, 0.05]] * 1, ORIGIN)
    for _ in range(3):
        after.insert_scan([[1.95, 0.05, 0.05]], ORIGIN)
    found = changes_between(before, after)
    assert (found.vanished - 32768).tolist() == [[10, 0, 0]]
    assert found.appeared.tolist() == []
    assert (found.same, found.only_first, found.only_second) == (10, 0, 9)
    turned = changes_between(after, before)
    assert (turned.appeared - 32768).tolist() == [[10, 0, 0]]
    with pytest.raises(ConfigError, match=r"of one size, not 0\.1 and 0\.2 m"):
        changes_between(before, OccupancyVolume(VolumeConfig(resolution=0.2)))


def test_points_that_are_nowhere_are_left_out_and_counted() -> None:
    volume = OccupancyVolume(CONFIG)
    did = volume.insert_scan([WALL, [np.nan, 0, 0], [np.inf, 0, 0], [1e7, 0, 0], [-1e30, 0, 0]], ORIGIN)
    assert (did.beams, did.left_out) == (1, 4)
    assert volume.n_known == 11
    assert volume.insert_scan(np.empty((0, 3)), ORIGIN).beams == 0


@pytest.mark.parametrize("origin", [[np.nan, 0.0, 0.0], [1e7, 0.0, 0.0]])
def test_a_sensor_must_be_in_the_lattice(origin: list[float]) -> None:
    with pytest.raises(ConfigError, match=r"finite and within 3276\.8 m of 0"):
        OccupancyVolume(CONFIG).insert_scan([WALL], origin)


def test_a_resolution_that_would_take_all_memory_is_refused() -> None:
    volume = OccupancyVolume(VolumeConfig(resolution=0.001))
    with pytest.raises(LimitError, match=r"A scan of 60 × 60 × 30 m at 0\.001 m a voxel is too large"):
        volume.insert_scan([[30.0, 30.0, 30.0], [-30.0, -30.0, 0.0]], [0.0, 0.0, 0.0])
    few = OccupancyVolume(CONFIG, replace(DEFAULT_LIMITS, max_blocks=2))
    few.insert_scan([WALL], ORIGIN)
    with pytest.raises(LimitError, match="would need 4 blocks of 8 × 8 × 8 voxels, more than 2"):
        few.insert_scan([[2.75, 0.05, 0.05]], ORIGIN)
    few.insert_scan([WALL], ORIGIN)  # nothing of the refused scan is left in the working memory
    assert few.n_known == 11


def test_parameters_are_checked() -> None:
    with pytest.raises(ConfigError, match="must lie between the least and the greatest"):
        VolumeConfig(p_occupied=0.1, p_min=0.12)
    with pytest.raises(ConfigError, match=r"Resolution \(resolution\) must be between"):
        VolumeConfig(resolution=1e-6)
