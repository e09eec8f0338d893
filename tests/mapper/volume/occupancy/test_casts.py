"""Casts through many blocks, beside the textbook's walk from voxel to voxel."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.volume import OccupancyVolume, VolumeConfig, cast
from mapper.volume.occupancy import stop_masks, textbook
from mapper.volume.occupancy.queries import HIT, OUTSIDE, TOO_FAR, UNKNOWN

CONFIG = VolumeConfig(resolution=0.1)


def room(n: int = 4000) -> OccupancyVolume:
    """A room of 8 × 6 × 3 m whose walls have holes, seen from its middle."""
    rng = np.random.default_rng(3)
    away = rng.normal(size=(n, 3))
    ranges = (np.where(away > 0.0, [4.1, 3.2, 1.6], [-3.9, -2.8, -1.4]) / away).min(axis=1)
    volume = OccupancyVolume(CONFIG)
    volume.insert_scan((away * ranges[:, None]).astype(np.float32), [0.02, 0.03, 0.01])
    return volume


def textbook_casts(
    volume: OccupancyVolume, origins: np.ndarray, directions: np.ndarray, *, through_unknown: bool, range_max: float
) -> tuple[list[int], list[list[int]]]:
    keys, values = volume.voxels()
    voxels = dict(zip(map(tuple, keys.tolist()), values, strict=True))
    ends = [
        textbook.cast_ray(voxels, origin, away, volume.config, through_unknown=through_unknown, range_max=range_max)
        for origin, away in zip(origins, directions, strict=True)
    ]
    return [end for end, _ in ends], [list(key) for _, key in ends]


@pytest.mark.parametrize("through_unknown", [True, False])
@pytest.mark.parametrize("snapped", [False, True], ids=["any directions", "borders met at one distance"])
@pytest.mark.parametrize("most_places", [stop_masks.MOST_PLACES, 0], ids=["blocks by index", "blocks by hash"])
def test_casts_are_the_textbooks(
    monkeypatch: pytest.MonkeyPatch, *, through_unknown: bool, snapped: bool, most_places: int
) -> None:
    monkeypatch.setattr(stop_masks, "MOST_PLACES", most_places)
    volume, rng = room(), np.random.default_rng(4)
    assert (volume.stop_masks().grid.size > 0) == (most_places > 0)
    origins, directions = rng.uniform([-3, -2, -1], [3, 2, 1], (150, 3)), rng.normal(size=(150, 3))
    if snapped:
        origins, directions = np.round(origins / 0.05) * 0.05, np.round(2.0 * directions)
        directions[~directions.any(axis=1)] = [1.0, 1.0, 0.0]
    origins, directions = origins.astype(np.float32), directions.astype(np.float32)
    casts = cast(volume, origins, directions, through_unknown=through_unknown, range_max=12.0)
    ends, keys = textbook_casts(volume, origins, directions, through_unknown=through_unknown, range_max=12.0)
    assert casts.ends.tolist() == ends
    assert casts.keys.tolist() == keys
    assert set(ends) >= ({HIT, TOO_FAR} if through_unknown else {HIT, UNKNOWN})


def test_the_range_is_a_sum_in_float64() -> None:
    """The centre at 0.7 m, whose squares add up to 0.48999999 in float64 and to 0.49000001 in float32, is in range."""
    origin, away = np.array([[[0.25, 1.05, -0.85]], [[-0.35, -0.55, -0.95]]], dtype=np.float32)
    volume = OccupancyVolume(CONFIG)
    casts = cast(volume, origin, away, through_unknown=True, range_max=0.7)
    ends, keys = textbook_casts(volume, origin, away, through_unknown=True, range_max=0.7)
    assert (casts.ends.tolist(), casts.keys.tolist()) == (ends, keys) == ([TOO_FAR], [[32768, 32774, 32753]])


def test_a_ray_without_a_limit_leaves_the_lattice_where_the_textbooks_does() -> None:
    volume = OccupancyVolume(CONFIG)
    corner = np.array([3270.03, -3271.07, 3265.01], dtype=np.float32)
    volume.insert_scan(corner[None] - np.float32(2.0), corner)
    rng = np.random.default_rng(5)
    directions = np.vstack([rng.normal([4.0, -4.0, 4.0], size=(40, 3)), np.eye(3)]).astype(np.float32)
    origins = np.repeat(corner[None], len(directions), axis=0)
    casts = cast(volume, origins, directions)
    ends, keys = textbook_casts(volume, origins, directions, through_unknown=True, range_max=0.0)
    assert casts.ends.tolist() == ends
    assert casts.keys.tolist() == keys
    assert set(ends) == {OUTSIDE}


def test_casts_see_what_a_later_scan_changes() -> None:
    volume, ahead = OccupancyVolume(CONFIG), [[1.0, 0.0, 0.0]]
    volume.insert_scan([[9.05, 0.05, 0.05]], [0.05, 0.05, 0.05])
    assert cast(volume, [0.05, 0.05, 0.05], ahead).points[0, 0] == np.float32(9.05)
    for _ in range(3):
        volume.insert_scan([[4.05, 0.05, 0.05]], [0.05, 0.05, 0.05])
    assert cast(volume, [0.05, 0.05, 0.05], ahead).points[0, 0] == np.float32(4.05)
    volume.insert_scan(np.tile([[4.05, 30.05, 0.05]], (3, 1)), None)  # in a new block
    assert cast(volume, [4.05, 20.05, 0.05], [[0.0, 1.0, 0.0]]).ends[0] == HIT


def test_a_map_of_two_far_places_has_no_large_index() -> None:
    volume = OccupancyVolume(CONFIG)
    for x in (0.05, 2000.05):
        volume.insert_scan([[x + 1.0, 0.05, 0.05]], [x, 0.05, 0.05])
    casts = cast(volume, [[0.05, 0.05, 0.05], [2000.05, 0.05, 0.05]], [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert casts.ends.tolist() == [HIT, HIT]
    np.testing.assert_allclose(casts.points[:, 0], [1.05, 2001.05], rtol=1e-6)
    per_block = (2 * 8 * 8 + 1 + 1) * volume.blocks.capacity  # bits of both kinds, a byte and a flag
    bare = OccupancyVolume(CONFIG)
    bare.set_blocks(volume.blocks.codes, volume.values)
    assert volume.n_bytes <= bare.n_bytes + per_block + 4 * stop_masks.MOST_PLACES * volume.blocks.count


@pytest.mark.parametrize("length", [1e-30, 1e30])
def test_a_direction_whose_length_no_float32_has_is_refused(length: float) -> None:
    with pytest.raises(ConfigError, match="length"):
        cast(OccupancyVolume(CONFIG), [0.0, 0.0, 0.0], [[length, 0.0, 0.0]])
