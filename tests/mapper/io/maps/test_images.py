"""Images made in bands have the pixels that Pillow gives for the whole map, in bounded memory."""

from __future__ import annotations

import gc
import io
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.compare import difference
from mapper.io.maps import load_map, occupancy_values, pgm_bytes, png_bytes, save_map
from mapper.io.maps.images import pgm_pieces, png_pieces
from mapper.io.maps.pixels import (
    APART_RGB,
    BAND_CELLS,
    DIFFERENCE_PALETTE,
    DIFFERENCE_RGB,
    UNOBSERVED_RGB,
    difference_pixels,
    probability_pixels,
    row_bands,
    trinary_pixels,
)

TALL, WIDE = (700, 300), (9, 30_000)  #: more cells than one band; WIDE has four rows in a band


def a_grid(
    shape: tuple[int, int], seed: int = 0, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> OccupancyGrid:
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid(GridGeometry(0.1, *shape, origin))
    grid.log_odds[:] = rng.normal(0.0, 3.0, shape)
    grid.observed[:] = rng.random(shape) < 0.8
    return grid


def bands_of(pixels: NDArray[np.uint8], heights: list[int]) -> list[NDArray[np.uint8]]:
    return np.split(pixels, np.cumsum(heights)[:-1])


@given(
    heights=st.lists(st.integers(1, 9), min_size=1, max_size=6),
    cols=st.integers(1, 70),
    kind=st.sampled_from(["L", "P", "LA"]),
    seed=st.integers(0, 99),
)
def test_pillow_decodes_the_rows_that_went_in(heights, cols, kind, seed):
    rng = np.random.default_rng(seed)
    shape = (sum(heights), cols)
    pixels = rng.integers(0, 256, shape + ((2,) if kind == "LA" else ()), dtype=np.uint8)
    palette = rng.bytes(768) if kind == "P" else None
    image = Image.open(io.BytesIO(b"".join(png_pieces(shape, bands_of(pixels, heights), palette))))
    image.load()
    assert (image.format, image.mode, image.size) == ("PNG", kind, (cols, shape[0]))
    np.testing.assert_array_equal(np.asarray(image), pixels)
    if palette is not None:
        assert bytes(image.palette.palette) == palette  # type: ignore[union-attr]


def test_pixels_that_do_not_compress_fill_many_chunks():
    pixels = np.random.default_rng(1).integers(0, 256, (1500, 1000), dtype=np.uint8)
    pieces = list(png_pieces(pixels.shape, bands_of(pixels, [100] * 15)))
    assert len(pieces) > 4
    np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(b"".join(pieces)))), pixels)


@pytest.mark.parametrize("shape", [(1, 1), (64, 64), TALL, WIDE])
def test_the_png_equals_that_of_pillow(shape):
    grid = a_grid(shape)
    p_occ = 1.0 / (1.0 + np.exp(-grid.log_odds.astype(np.float64)))
    index = np.rint(254.0 * (1.0 - p_occ)).astype(np.uint8)
    index[~grid.observed] = 255
    whole = Image.fromarray(np.ascontiguousarray(index[::-1]))
    greys = np.rint(np.arange(255) * 255.0 / 254.0).astype(int)
    whole.putpalette([*np.repeat(greys, 3).tolist(), *UNOBSERVED_RGB])
    out = io.BytesIO()
    whole.save(out, "PNG")
    made, expected = Image.open(io.BytesIO(png_bytes(grid))), Image.open(out)
    assert made.mode == expected.mode == "P"
    np.testing.assert_array_equal(np.asarray(made.convert("RGB")), np.asarray(expected.convert("RGB")))


@pytest.mark.parametrize("shape", [(1, 1), TALL, WIDE])
def test_a_pgm_written_in_bands_has_the_states_of_the_grid(shape):
    grid = a_grid(shape)
    greys = np.array([254, 0, 205], dtype=np.uint8)[np.where(grid.classify() == 100, 1, grid.classify())]
    assert pgm_bytes(grid) == f"P5\n{shape[1]} {shape[0]}\n255\n".encode() + greys[::-1].tobytes()
    raw = Image.open(io.BytesIO(pgm_bytes(grid, mode="raw")))
    np.testing.assert_array_equal(np.asarray(raw).astype(np.int8)[::-1], occupancy_values(grid))


def test_a_map_of_many_bands_is_saved_and_loaded(tmp_path):
    grid = a_grid(TALL, origin=(3.0, -2.0, 0.5))
    yaml_path, _ = save_map(grid, tmp_path / "tall", "scale")
    loaded = load_map(yaml_path)
    np.testing.assert_array_equal(loaded.values, occupancy_values(grid))
    assert loaded.grid.geometry == grid.geometry


@pytest.mark.parametrize(("shape_b", "origin_b"), [(TALL, (0.0, 0.0, 0.0)), ((500, 400), (-3.2, 12.8, 0.0))])
def test_the_difference_in_bands_equals_that_of_the_whole_grids(shape_b, origin_b):
    a, b = a_grid(TALL, 1), a_grid(shape_b, 2, origin_b)
    whole = difference(a, b)
    shape, pixels = difference_pixels(a, b)
    assert shape == whole.geometry.shape
    made = np.concatenate(list(pixels))[::-1]
    known = whole.observed_a & whole.observed_b
    most = float(np.abs(whole.log_odds[known]).max())
    strength = np.rint(np.sqrt(np.abs(whole.log_odds) / np.float32(most)) * 126.0)
    np.testing.assert_array_equal(made[known], (129 + np.copysign(strength, whole.log_odds))[known].astype(np.uint8))
    states = whole.observed_a + 2 * whole.observed_b.astype(int)
    np.testing.assert_array_equal(made[~known], states[~known])
    for rows in row_bands(shape):
        part = difference(a, b, rows)
        np.testing.assert_array_equal(part.log_odds, whole.log_odds[rows])
        centre = part.geometry.cell_to_world((0, 0))
        np.testing.assert_allclose(centre, whole.geometry.cell_to_world((rows.start, 0)))


def test_the_colours_of_a_difference():
    colours = np.frombuffer(DIFFERENCE_PALETTE, np.uint8).reshape(256, 3)
    assert bytes(colours[:3]) == bytes(APART_RGB)
    for index, rgb in zip((3, 129, 255), DIFFERENCE_RGB, strict=True):
        assert tuple(colours[index]) == rgb


def test_an_image_is_made_in_memory_that_the_size_of_the_map_does_not_set():
    def most(rows: int) -> int:
        grid = a_grid((rows, 1024))
        gc.collect()
        tracemalloc.start()
        for bands, encode in ((trinary_pixels(grid), pgm_pieces), (probability_pixels(grid), png_pieces)):
            for _ in encode(grid.geometry.shape, bands):
                pass
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak

    most(BAND_CELLS // 1024)  # what is allocated once, by the first image, does not count
    assert most(8 * BAND_CELLS // 1024) < 1.1 * most(2 * BAND_CELLS // 1024) < 32 * BAND_CELLS * 4
