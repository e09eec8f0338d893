"""The 3D map has the map's place, and its values."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.grid import OCCUPIED, GridGeometry, OccupancyGrid
from server.scenes.map_mesh import HEIGHTS, MAX_SIDE, changed_tiles, first_column, map_levels, tile_columns

Vector = tuple[float, float, float]


def grid_of(rows: int, cols: int, seed: int = 0) -> OccupancyGrid:
    grid = OccupancyGrid(GridGeometry(0.1, rows, cols, (1.0, 2.0, 0.0)))
    rng = np.random.default_rng(seed)
    grid.log_odds[:] = rng.uniform(-2.0, 3.5, grid.geometry.shape)
    grid.observed[:] = rng.random(grid.geometry.shape) < 0.8
    return grid


def covered(vertices: np.ndarray, cell: float, shape: tuple[int, int]) -> np.ndarray:
    """The height of the boxes over each cell's centre."""
    heights = np.zeros(shape)
    for box in vertices.reshape(-1, 8, 3):
        (c0, r0), (c1, r1) = (
            np.round(box[:, :2].min(0) / cell).astype(int),
            np.round(box[:, :2].max(0) / cell).astype(int),
        )
        assert (heights[r0:r1, c0:c1] == 0.0).all(), "columns do not overlap"
        heights[r0:r1, c0:c1] = box[:, 2].max()
    return heights


def test_occupied_cells_and_no_others_have_columns() -> None:
    grid = grid_of(100, 150)
    drawn = map_levels(grid.geometry, grid.log_odds, grid.observed)
    assert drawn.cell == 0.1
    assert drawn.size_m == (15.0, 10.0)
    heights = np.zeros(grid.geometry.shape)
    for tile in changed_tiles(drawn.levels, None):
        heights += covered(tile_columns(drawn.levels, tile, drawn.cell)[0], drawn.cell, grid.geometry.shape)
    np.testing.assert_array_equal(heights > 0.0, grid.classify() == OCCUPIED)
    np.testing.assert_allclose(heights, HEIGHTS[drawn.levels], rtol=1e-6)
    # The surer, the taller.
    order = np.argsort(grid.log_odds[grid.observed])
    assert (np.diff(heights[grid.observed][order]) >= 0.0).all()


def test_a_vertical_wall_is_one_box_as_a_horizontal_one_is() -> None:
    levels = np.zeros((64, 64), dtype=np.uint8)
    levels[:, 5] = 3
    assert len(tile_columns(levels, (0, 0), 0.1)[0]) == 8
    assert len(tile_columns(levels.T.copy(), (0, 0), 0.1)[0]) == 8


def test_the_floor_shows_what_was_observed() -> None:
    grid = grid_of(64, 64)
    floor = map_levels(grid.geometry, grid.log_odds, grid.observed).floor
    np.testing.assert_array_equal(floor[..., 3] > 0, grid.observed)
    free, occupied = grid.log_odds < -1.5, grid.log_odds > 3.0
    on_light, on_dark = (shown_over(floor, background) for background in ((0xFA, 0xF8, 0xF2), (0x11, 0x15, 0x1D)))
    for colours in (on_light, on_dark):
        blue, orange = colours[grid.observed & free], colours[grid.observed & occupied]
        assert (blue[:, 2] > blue[:, 0] + 25.0).all()
        assert (orange[:, 0] > orange[:, 2] + 40.0).all()
    # What is free is light on a light page and dark on a dark one, and differs from the page itself.
    assert (on_light[grid.observed & free].mean(axis=1) > 200.0).all()
    assert (on_dark[grid.observed & free].mean(axis=1) < 110.0).all()
    assert (on_dark[grid.observed & free].mean(axis=1) > 50.0).all()


def shown_over(colours: np.ndarray, background: tuple[int, int, int]) -> np.ndarray:
    """The colours (..., 3) that a picture (..., 4) has over a background."""
    opacity = colours[..., 3:] / 255.0
    return np.asarray(opacity * colours[..., :3] + (1.0 - opacity) * np.array(background))


def test_only_changed_tiles_are_sent_again() -> None:
    grid = grid_of(200, 130)
    before = map_levels(grid.geometry, grid.log_odds, grid.observed).levels
    assert changed_tiles(before, before) == []
    grid.log_odds[150, 70] = -2.0 if before[150, 70] else 3.5
    grid.observed[150, 70] = True
    after = map_levels(grid.geometry, grid.log_odds, grid.observed).levels
    assert changed_tiles(after, before) == [(2, 1)]
    # A cell that becomes free empties its tile: that is a change as well.
    assert changed_tiles(np.zeros_like(before), before) == [(r, c) for r in range(4) for c in range(3)]


def test_a_large_grid_is_drawn_by_blocks_that_keep_thin_walls() -> None:
    side = 2 * MAX_SIDE + 100
    geometry = GridGeometry(0.05, side, 300)
    log_odds = np.full(geometry.shape, -1.0, dtype=np.float32)
    observed = np.ones(geometry.shape, dtype=np.bool_)
    log_odds[1000, :] = 3.5
    drawn = map_levels(geometry, log_odds, observed)
    assert max(drawn.levels.shape) <= MAX_SIDE
    assert drawn.cell == pytest.approx(0.15)
    assert (drawn.levels[1000 // 3] == 4).all()
    assert (drawn.levels != 0).sum() == drawn.levels.shape[1]


@pytest.mark.parametrize(
    ("start", "along", "place"),
    [
        # The column of cell (row 4, col 6), 0.5 m high, is 0.6 … 0.7 m along x, 0.4 … 0.5 m along y.
        ((0.65, 0.45, 3.0), (0.0, 0.0, -1.0), (0.65, 0.45, 0.25)),  # from above
        ((0.65, 0.4, 3.0), (0.0, -0.0, -1.0), (0.65, 0.4, 0.25)),  # along its side
        ((-1.0, 0.45, 0.3), (2.0, 0.0, 0.0), (0.65, 0.45, 0.3)),  # along the floor
        ((0.05, 0.45, 0.75), (0.5, 0.0, -0.5), (0.65, 0.45, 0.15)),  # from above, 0.2 … 0.1 m above the floor
        ((0.05, 0.45, 1.1), (1.0, 0.0, -1.0), (0.675, 0.45, 0.475)),  # through its top
        ((0.0, 1.002, 0.3), (1.0, -1.0, 0.0), (0.601, 0.401, 0.3)),  # 3 mm of a corner
        ((0.65, 0.35, 3.0), (0.0, 0.0, -1.0), None),  # beside it
        ((-1.0, 0.45, 0.6), (1.0, 0.0, 0.0), None),  # above it
        ((0.75, 0.45, 0.3), (1.0, 0.0, 0.0), None),  # away from it
        ((0.65, 0.45, 3.0), (0.0, 0.0, 1.0), None),
        ((0.65, 0.45, 3.0), (0.0, 0.0, 0.0), None),
    ],
)
def test_a_line_of_sight_meets_the_first_column(start: Vector, along: Vector, place: Vector | None) -> None:
    geometry = GridGeometry(0.1, 8, 12)
    log_odds = np.full(geometry.shape, -2.0, dtype=np.float32)
    log_odds[4, 6] = 3.5
    drawn = map_levels(geometry, log_odds, np.ones(geometry.shape, dtype=np.bool_))
    met = first_column(drawn, 1.0, np.array(start), np.array(along))
    if place is None:
        assert met is None
    else:
        assert met is not None
        np.testing.assert_allclose(met, place, atol=1e-9)


def test_no_column_is_before_the_first_that_is_met() -> None:
    rng = np.random.default_rng(5)
    grid = grid_of(40, 30)
    drawn = map_levels(grid.geometry, grid.log_odds, grid.observed & (rng.random(grid.geometry.shape) < 0.1))

    def in_column(places: np.ndarray) -> np.ndarray:
        cols, rows = np.floor(places[:, :2] / 0.1).astype(int).T
        inside = (rows >= 0) & (rows < 40) & (cols >= 0) & (cols < 30)
        heights = HEIGHTS[drawn.levels[np.where(inside, rows, 0), np.where(inside, cols, 0)]]
        return np.asarray(inside & (places[:, 2] >= 0.0) & (places[:, 2] < heights))

    met = 0
    for _ in range(300):
        start = rng.uniform((-2.0, -2.0, 0.1), (5.0, 6.0, 2.0))
        along = rng.uniform((0.0, 0.0, 0.0), (3.0, 4.0, 0.5)) - start
        place = first_column(drawn, 1.0, start, along)
        # Steps of at most 4 mm; half of a line's way through a column is at most 0.26 m.
        before = start + np.linspace(0.0, 1.0, 2000)[:, None] * (5.0 * along if place is None else place - start)
        if place is not None:
            met += 1
            assert in_column(place[None])[0]
            before = before[np.linalg.norm(before - place, axis=1) > 0.26]
        assert not in_column(before).any()
    assert 50 < met < 250


def test_in_a_block_of_a_large_map_the_cell_is_met() -> None:
    geometry = GridGeometry(0.1, 2 * MAX_SIDE, 4)
    log_odds = np.full(geometry.shape, -2.0, dtype=np.float32)
    for row, col in ((10, 1), (11, 1), (21, 2)):
        log_odds[row, col] = 3.5
    drawn = map_levels(geometry, log_odds, np.ones(geometry.shape, dtype=np.bool_))
    assert drawn.cell == 0.2

    def cell(start: Vector, along: Vector) -> tuple[int, int]:
        place = first_column(drawn, 1.0, np.array(start), np.array(along))
        assert place is not None
        return int(place[1] // 0.1), int(place[0] // 0.1)

    # From the right through free and occupied cells of a block, from above onto two, and past the occupied one.
    assert cell((9.0, 1.05, 0.1), (-1.0, 0.0, 0.0)) == (10, 1)
    assert cell((0.15, 9.0, 0.1), (0.0, -1.0, 0.0)) == (11, 1)
    assert cell((0.15, 1.02, 3.0), (0.0, 0.0, -1.0)) == (10, 1)
    assert cell((0.02, 1.12, 3.0), (0.0, 0.0, -1.0)) == (11, 1)
    assert cell((9.0, 2.05, 0.1), (-1.0, 0.0, 0.0)) == (21, 2)
    assert first_column(drawn, 1.0, np.array((9.0, 1.85, 0.1)), np.array((-1.0, 0.0, 0.0))) is None


def test_columns_that_are_drawn_higher_are_met_higher() -> None:
    drawn = map_levels(GridGeometry(0.1, 1, 1), np.array([[3.5]], dtype=np.float32), np.array([[True]]))
    start, along = np.array([0.05, 0.05, 4.0]), np.array([0.0, 0.0, -1.0])
    met = first_column(drawn, 5.0, start, along)
    assert met is not None
    assert met[2] == pytest.approx(0.5 * 5.0 * HEIGHTS[-1])
