"""The log-odds of blocks in parts: what is written is read, and only known parts take memory."""

from __future__ import annotations

import numpy as np

from mapper.volume import OccupancyVolume, VolumeConfig

CONFIG = VolumeConfig(resolution=0.1)
CODES = np.array([0, 1 << 13, (1 << 26) + 5, 7])


def random_blocks(seed: int) -> np.ndarray:
    """Values of four blocks: known at random, in few places, in one row along x, nowhere."""
    rng = np.random.default_rng(seed)
    values = rng.uniform(-2.0, 3.5, (4, 8, 8, 8)).astype(np.float32)
    values[0][rng.random((8, 8, 8)) < 0.5] = np.nan
    values[1][rng.random((8, 8, 8)) < 0.99] = np.nan
    values[2, :5], values[2, 6:], values[2, 5, :2], values[2, 5, 3:] = np.nan, np.nan, np.nan, np.nan
    values[3] = np.nan
    return values


def test_blocks_that_are_set_again_have_the_new_values() -> None:
    volume = OccupancyVolume(CONFIG)
    for seed, order in ((0, [0, 1, 2, 3]), (1, [3, 2, 1, 0]), (2, [1, 0, 3, 2])):
        values = random_blocks(seed)[order]
        volume.set_blocks(CODES, values)
        np.testing.assert_array_equal(volume.values, values)
        np.testing.assert_array_equal(volume.values_of(np.array([2, 0])), values[[2, 0]])
        assert volume.n_known == (~np.isnan(values)).sum()
        assert volume.count_states()[0] == (values >= CONFIG.log_odds_occupied).sum()
        corners = np.stack([CODES & 8191, CODES >> 13 & 8191, CODES >> 26], axis=1) * 8
        slot, z, y, x = np.nonzero(np.ones_like(values))
        found = volume.log_odds_of(corners[slot] + np.stack([x, y, z], axis=1))
        np.testing.assert_array_equal(found, values.ravel())


def test_parts_of_blocks_without_known_voxels_take_no_memory() -> None:
    volume = OccupancyVolume(CONFIG)
    for seed in range(2):  # the second time more parts become known
        volume.set_blocks(CODES[seed * 2 : seed * 2 + 2], random_blocks(seed)[[1, 2]])
    parts = (~np.isnan(volume.values)).reshape(4, 4, 2, 4, 2, 8).any(axis=(2, 4, 5)).sum()
    table = volume.blocks.table
    blocks = 4 * (8 + 4 + 4 + 16 * 4)  # of each its code, maximum, number of known voxels and numbers of parts
    assert volume.n_bytes == (1 + parts) * 32 * 4 + blocks + table.codes.nbytes + table.slots.nbytes
    assert parts < 16


def test_a_scan_makes_the_parts_that_its_beams_pass() -> None:
    volume = OccupancyVolume(CONFIG)
    volume.insert_scan([[1.05, 0.05, 0.05]], [0.05, 0.05, 0.05])
    one = volume.n_bytes
    volume.insert_scan([[1.05, 0.15, 0.15]], [0.05, 0.15, 0.15])  # in the same parts of the same two blocks
    assert volume.n_bytes == one
    volume.insert_scan([[1.05, 0.25, 0.05]], [0.05, 0.25, 0.05])  # in the parts beside them
    assert volume.n_bytes == one + 2 * 32 * 4
    assert volume.n_known == 33
