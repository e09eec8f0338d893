"""The picture and its tiles against the formula of the protocol, decoded independently."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from mapper.grid import CellBox, GridGeometry, OccupancyGrid
from mapper.mapping.parameters import MappingConfig
from server.stream.grid_layer import TilePicture, picture_range
from server.stream.protocol import TilePayload


def payload_of(picture: TilePicture, ty: int, tx: int) -> TilePayload:
    (payload,) = picture.payloads(np.array([[ty, tx]]))
    return payload


def decoded(picture: TilePicture) -> NDArray[np.int8]:
    """The whole picture from its payloads."""
    rows, cols = picture.geometry.shape
    whole = np.full((picture.revision.shape[0] * 64, picture.revision.shape[1] * 64), -128, dtype=np.int8)
    tiles = np.argwhere(picture.revision > 0)
    for (ty, tx), payload in zip(tiles.tolist(), picture.payloads(tiles), strict=True):
        assert (payload.tx, payload.ty) == (tx, ty)
        tile = np.frombuffer(zstandard.decompress(payload.data), dtype=np.int8).reshape(64, 64)
        whole[ty * 64 : ty * 64 + 64, tx * 64 : tx * 64 + 64] = tile
    assert (whole[rows:] == -128).all()
    assert (whole[:, cols:] == -128).all()
    return whole[:rows, :cols]


@given(st.integers(1, 200), st.integers(1, 200), st.integers(0, 2**32 - 1))
def test_tiles_have_the_values_of_the_grid(rows: int, cols: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid(GridGeometry(0.05, rows, cols))
    grid.log_odds[:] = rng.uniform(-3.0, 5.0, grid.log_odds.shape)
    grid.observed[:] = rng.random(grid.observed.shape) < 0.5
    picture = TilePicture(grid.geometry, -2.0, 3.5)
    picture.update(grid, CellBox(0, rows, 0, cols))
    picture.publish()
    q = decoded(picture).astype(np.float64)
    assert ((q == -128) == ~grid.observed).all()
    value = -2.0 + (q + 127.0) / 254.0 * 5.5
    error = np.abs(value - np.clip(grid.log_odds, -2.0, 3.5))[grid.observed]
    # Half a step; a whole one where the nearest value would be another state's.
    logit = np.log([0.25 / 0.75, 0.65 / 0.35])
    near = np.abs(grid.log_odds[grid.observed][:, None] - logit).min(axis=1) < 5.5 / 254.0
    assert (error <= 5.5 / 254.0 / np.where(near, 1.0, 2.0) + 1e-6).all()
    state = np.where(q == -128, 0, np.where(value > logit[1], 1, np.where(value < logit[0], -1, 0)))
    np.testing.assert_array_equal(np.select([state == 1, state == -1], [100, 0], -1), grid.classify())


def test_one_tile_of_a_large_grid_takes_the_memory_of_one_tile() -> None:
    picture = TilePicture(GridGeometry(0.05, 4001, 4001), -2.0, 3.5)
    payload_of(picture, 0, 0)  # this thread's compressor
    tracemalloc.start()
    try:
        payload_of(picture, 62, 62)
        assert tracemalloc.get_traced_memory()[1] < 100_000
    finally:
        tracemalloc.stop()


def test_only_changed_tiles_get_a_new_revision_and_each_is_compressed_once() -> None:
    grid = OccupancyGrid(GridGeometry(0.05, 256, 256))
    picture = TilePicture(grid.geometry, -2.0, 3.5, revision=7)
    whole = CellBox(0, 256, 0, 256)
    assert picture.publish() == 0
    assert picture.newest == 7
    grid.observed[100, 200] = True
    picture.update(grid, whole)
    assert picture.publish() == 1
    assert picture.revision[1, 3] == 8
    assert np.count_nonzero(picture.revision) == 1
    first = payload_of(picture, 1, 3)
    assert payload_of(picture, 1, 3) is first
    picture.update(grid, whole)
    assert picture.publish() == 0
    assert payload_of(picture, 1, 3) is first
    grid.log_odds[100, 200] = 1.0
    picture.update(grid, CellBox(100, 101, 200, 201))
    assert picture.publish() == 1
    assert payload_of(picture, 1, 3).revision == 9
    assert payload_of(picture, 1, 3).data != first.data


@given(st.integers(1, 150), st.integers(1, 150), st.integers(0, 2**32 - 1), st.booleans())
def test_values_of_a_linear_scale_are_within_half_a_step(rows: int, cols: int, seed: int, whole_numbers: bool) -> None:
    rng = np.random.default_rng(seed)
    low, high = (0.0, 255.0) if whole_numbers else (-1.5, 4.0)
    values = rng.uniform(low - 1.0, high + 1.0, (rows, cols)).clip(*((0, 255) if whole_numbers else (None, None)))
    shown: Any = values.astype(np.uint8 if whole_numbers else np.float32)
    missing = rng.random((rows, cols)) < 0.3
    picture = TilePicture(GridGeometry(0.05, rows, cols), low, high)
    picture.set(shown, missing)
    picture.publish()
    q = decoded(picture).astype(np.float64)
    np.testing.assert_array_equal(q == -128, missing)
    told = low + (q + 127.0) / 254.0 * (high - low)
    assert (np.abs(told - np.clip(shown, low, high))[~missing] <= (high - low) / 508.0 + 1e-5).all()


def test_values_set_in_a_box_are_those_of_a_whole_picture() -> None:
    geometry = GridGeometry(0.05, 150, 200)
    rng = np.random.default_rng(4)
    values = rng.integers(0, 255, geometry.shape).astype(np.uint8)
    by_box, whole = TilePicture(geometry, 0.0, 254.0), TilePicture(geometry, 0.0, 254.0)
    by_box.set(values)
    by_box.publish()
    for box in (CellBox(0, 1, 0, 1), CellBox(60, 70, 120, 200), CellBox(149, 150, 199, 200)):
        values[box.row0 : box.row1, box.col0 : box.col1] ^= 85
        by_box.set(values, box=box)
        tiles = (-(-box.row1 // 64) - box.row0 // 64) * (-(-box.col1 // 64) - box.col0 // 64)
        assert by_box.publish() == tiles
    whole.set(values)
    whole.publish()
    assert (decoded(by_box) == decoded(whole)).all()


def test_values_that_stay_are_not_sent_again() -> None:
    values = np.zeros((100, 200), dtype=np.float32)
    picture = TilePicture(GridGeometry(0.05, 100, 200), 0.0, 1.0)
    picture.set(values)
    assert picture.publish() == 2 * 4
    picture.set(values)
    assert picture.publish() == 0
    values[70, 130] = np.nan
    picture.set(values)
    assert picture.publish() == 1
    assert np.argwhere(picture.revision == picture.newest).tolist() == [[1, 2]]
    assert decoded(picture)[70, 130] == -128


@pytest.mark.parametrize(
    ("config", "expected"),
    [
        (MappingConfig(), (-2.0, 3.5)),
        (MappingConfig(log_odds_min=-4.0, log_odds_max=5.0), (-4.0, 5.0)),
        (MappingConfig(clamp=False), (-10.0, 10.0)),
    ],
)
def test_the_range_of_the_picture_is_the_clamps(config: MappingConfig, expected: tuple[float, float]) -> None:
    assert picture_range(config) == expected
