"""Cells, world coordinates and images; growth; the three states."""

import io
import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import Limits
from mapper.grid import FREE, OCCUPIED, TILE, UNKNOWN, GridGeometry, OccupancyGrid, log_odds, probability

geometries = st.builds(
    GridGeometry,
    st.floats(0.01, 1),
    st.integers(1, 50),
    st.integers(1, 50),
    st.tuples(st.floats(-10, 10), st.floats(-10, 10), st.floats(-4, 4)),
)


def test_the_first_cell_is_up_and_right_of_the_origin() -> None:
    geometry = GridGeometry(0.5, 4, 6, (-1.0, 2.0, 0.0))
    assert geometry.world_to_cell([-1.0, 2.0]).tolist() == [0, 0]
    assert geometry.world_to_cell([-0.6, 3.9]).tolist() == [3, 0]
    assert geometry.world_to_cell([-1.0001, 2.0]).tolist() == [0, -1]
    assert geometry.cell_to_world([0, 0]).tolist() == [-0.75, 2.25]
    assert geometry.to_lattice([-0.75, 2.5]).tolist() == [0.5, 1.0]


def test_yaw_turns_the_lattice_about_the_origin() -> None:
    geometry = GridGeometry(1.0, 5, 5, (10.0, 20.0, np.pi / 2))
    # Columns run along the map's y, rows against its x.
    assert geometry.world_to_cell([9.5, 23.5]).tolist() == [0, 3]
    np.testing.assert_allclose(geometry.cell_to_world([2, 1]), [7.5, 21.5])


@given(geometries, st.tuples(st.integers(-100, 100), st.integers(-100, 100)))
def test_the_centre_of_a_cell_is_inside_it(geometry: GridGeometry, cell: tuple[int, int]) -> None:
    assert tuple(geometry.world_to_cell(geometry.cell_to_world(cell))) == cell
    inside = 0 <= cell[0] < geometry.rows and 0 <= cell[1] < geometry.cols
    assert geometry.contains(cell) == inside


@given(
    st.floats(-500, 500), st.floats(-500, 500), st.floats(0, 40), st.floats(0, 40), st.sampled_from([0.05, 0.1, 0.3])
)
def test_covering_contains_its_box_in_whole_tiles(x: float, y: float, width: float, height: float, side: float) -> None:
    geometry = GridGeometry.covering((x, y), (x + width, y + height), side)
    assert geometry.rows % TILE == geometry.cols % TILE == 0
    tiles = np.array(geometry.origin[:2]) / (TILE * side)
    np.testing.assert_allclose(tiles, np.round(tiles), atol=1e-9)
    # A corner on a tile's border may be rounded to either side of it.
    inwards = 1e-9 * np.array([[1, 1], [-1, -1]])
    corners = np.array([[x, y], [x + width, y + height]]) + inwards
    assert geometry.contains(geometry.world_to_cell(corners)).all() or min(width, height) < 1e-8


def test_grids_of_one_resolution_coincide() -> None:
    a, b = (GridGeometry.covering((x, 0.0), (x + 5.0, 5.0), 0.05) for x in (0.0, -123.4))
    shift = b.to_lattice(a.origin[:2])
    np.testing.assert_allclose(shift, np.round(shift), atol=1e-9)


def test_images_have_their_first_row_on_top() -> None:
    cells = np.arange(6).reshape(3, 2)
    assert GridGeometry.to_image(cells)[0].tolist() == [4, 5]
    np.testing.assert_array_equal(GridGeometry.to_image(GridGeometry.to_image(cells)), cells)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ((0.0, 1, 1), "grid.resolution"),
        ((-1.0, 1, 1), "grid.resolution"),
        ((np.nan, 1, 1), "grid.resolution"),
        ((0.1, 0, 1), "grid.size"),
        ((0.1, 1, -1), "grid.size"),
        ((0.1, 1, 1, (0.0, np.inf, 0.0)), "grid.origin"),
        ((0.1, 1, 1, (0.0, 0.0)), "grid.origin"),
    ],
)
def test_an_impossible_geometry_is_refused(arguments: tuple[object, ...], code: str) -> None:
    with pytest.raises(ConfigError) as refused:
        GridGeometry(*arguments)  # type: ignore[arg-type]
    assert refused.value.code == code


def test_a_grid_above_the_limits_is_refused() -> None:
    with pytest.raises(LimitError, match="coarser"):
        GridGeometry(0.05, 1 << 15, 1 << 15)


def test_errors_state_sizes_as_width_by_height() -> None:
    with pytest.raises(LimitError, match="65536 × 1024 cells"):
        GridGeometry(0.05, rows=1 << 10, cols=1 << 16)
    with pytest.raises(ConfigError, match="not 7 × 0"):
        GridGeometry(0.05, rows=0, cols=7)
    with pytest.raises(LimitError, match="coarser"):
        GridGeometry(0.05, 1, 40_000)
    with pytest.raises(LimitError, match="coarser"):
        GridGeometry.covering((0, 0), (1e300, 1.0), 0.05)
    with pytest.raises(ConfigError, match="finite"):
        GridGeometry.covering((0, np.nan), (1, 1), 0.05)
    with pytest.raises(ConfigError, match="resolution"):
        GridGeometry.covering((0, 0), (1, 1), 0.0)


def test_a_point_that_is_not_finite_has_no_cell() -> None:
    with pytest.raises(ConfigError, match="no cell"):
        GridGeometry(0.1, 2, 2).world_to_cell([[0.1, 0.1], [np.nan, 0.0]])


@given(st.floats(-30, 30), st.floats(-30, 30))
def test_growing_keeps_the_values_of_cells(x: float, y: float) -> None:
    grid = OccupancyGrid(GridGeometry(0.25, 20, 30, (1.0, -2.0, 0.0)), log_odds_prior=0.5)
    grid.log_odds[:] = np.arange(600, dtype=np.float32).reshape(20, 30)
    grid.observed[3, 4] = True
    old = grid.geometry
    place = old.cell_to_world((7, 11))
    changed = grid.grow_to_include((x, y), (x, y))
    assert changed == (grid.geometry != old) == (not old.contains(old.world_to_cell((x, y))))
    assert grid.geometry.contains(grid.geometry.world_to_cell((x, y)))
    row, col = grid.geometry.world_to_cell(place)
    assert grid.log_odds[row, col] == 7 * 30 + 11
    assert grid.observed.sum() == 1
    assert np.count_nonzero(grid.log_odds == 0.5) == grid.log_odds.size - 600
    row, col = grid.geometry.world_to_cell(old.cell_to_world((3, 4)))
    assert grid.observed[row, col]


def test_growth_beyond_the_limits_changes_nothing() -> None:
    grid = OccupancyGrid(GridGeometry(0.1, 64, 64, limits=Limits(max_cells=10_000)))
    with pytest.raises(LimitError):
        grid.grow_to_include((0, 0), (20, 20))
    assert grid.log_odds.shape == grid.geometry.shape == (64, 64)


def test_three_states() -> None:
    grid = OccupancyGrid(GridGeometry(1.0, 1, 6))
    grid.log_odds[0] = [3.0, -3.0, 0.0, 0.3, -3.0, 3.0]
    grid.observed[0, :4] = True
    assert grid.classify().tolist() == [[OCCUPIED, FREE, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN]]
    assert grid.classify(0.55, 0.45).tolist() == [[OCCUPIED, FREE, UNKNOWN, OCCUPIED, UNKNOWN, UNKNOWN]]
    with pytest.raises(ConfigError, match="free ≤ occupied"):
        grid.classify(0.2, 0.6)


def test_a_prior_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ConfigError, match="prior"):
        OccupancyGrid(GridGeometry(1.0, 1, 1), log_odds_prior=np.inf)


@given(st.floats(-700, 700))
def test_log_odds_and_probability_are_inverse(value: float) -> None:
    p = probability(value)
    assert p == pytest.approx(1 - 1 / (1 + np.exp(value)), abs=1e-12)
    if abs(value) < 30:
        assert log_odds(p) == pytest.approx(value, abs=1e-2 if value > 20 else 1e-6)


def test_certainty_is_infinite() -> None:
    assert log_odds([0.0, 0.5, 1.0]).tolist() == [-np.inf, 0.0, np.inf]
    assert probability([-np.inf, np.inf]).tolist() == [0.0, 1.0]


def test_the_repr_of_a_grid_is_one_line() -> None:
    grid = OccupancyGrid(GridGeometry(0.05, 384, 960, (-12.8, 3.2, 0.5)))
    grid.observed[3, :7] = True
    assert repr(grid) == "<OccupancyGrid 960 × 384 cells of 0.05 m, origin (-12.8, 3.2, 0.5), 7 known>"


def test_a_notebook_shows_a_picture_of_the_map() -> None:
    grid = OccupancyGrid(GridGeometry(0.1, 2, 3))
    grid.log_odds[:] = [[0.0, 2.0, -2.0], [np.inf, -np.inf, 1.0]]
    grid.observed[:] = [[True, True, True], [True, True, False]]
    picture = Image.open(io.BytesIO(grid._repr_png_()))
    assert picture.format == "PNG"
    pixels = np.asarray(picture.convert("RGB")).astype(int)
    assert pixels.shape == (2, 3, 3)
    shade = [round(255 * (1 - 1 / (1 + math.exp(-value)))) for value in (0.0, 2.0, -2.0)]
    np.testing.assert_allclose(pixels[1], [[grey] * 3 for grey in shade], atol=1)  # row 0 is at the bottom
    assert pixels[0, 0].tolist() == [0, 0, 0]
    assert pixels[0, 1].tolist() == [255, 255, 255]
    assert pixels[0, 2].tolist() == [176, 196, 222]


@pytest.mark.parametrize("shape", [(1025, 3), (3, 5000), (3000, 4000)])
def test_the_picture_of_a_large_map_is_bounded_and_keeps_thin_walls(shape: tuple[int, int]) -> None:
    grid = OccupancyGrid(GridGeometry(0.1, *shape))
    grid.observed[:] = True
    grid.log_odds[:] = -3.0
    at = (shape[0] * 2 // 3, shape[1] // 4)
    grid.log_odds[at] = 3.0
    grid._repr_png_()  # Pillow is loaded
    tracemalloc.start()
    try:
        data = grid._repr_png_()
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 40e6
    picture = Image.open(io.BytesIO(data))
    assert 1 <= max(picture.size) <= 1024
    factor = -(-max(shape) // 1024)
    dark = np.argwhere(np.asarray(picture.convert("L"))[::-1] < 128)
    assert dark.tolist() == [[at[0] // factor, at[1] // factor]]
