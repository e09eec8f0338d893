"""Expected pictures of tiny maps, and thin walls at reduced size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.text import density, three_state

#: One character a cell, top row first: # occupied, + rather occupied, o undecided, - rather free, . free, blank unseen.
LOG_ODDS = {"#": 3.5, "+": 0.5, "o": 0.0, "-": -0.5, ".": -2.0}


def drawn(*rows: str) -> OccupancyGrid:
    grid = OccupancyGrid(GridGeometry(0.1, len(rows), len(rows[0])))
    for row, text in enumerate(reversed(rows)):
        for col, character in enumerate(text):
            if character != " ":
                grid.log_odds[row, col] = LOG_ODDS[character]
                grid.observed[row, col] = True
    return grid


ROOM = (
    "          ",
    "  #####   ",
    "  #..o#   ",
    "  #.-.    ",
    "  ##+.    ",
    "          ",
)


def test_three_states_of_a_small_map_two_characters_a_cell():
    assert three_state(drawn(*ROOM), 20) == "##########\n##....??##\n##..??..??\n####??..??"


def test_density_of_a_small_map():
    # p_occ of the log-odds −2, −0.5, 0, 0.5 and 3.5 is 0.12, 0.38, 0.5, 0.62 and 0.97: ninths 1, 3, 4, 5 and 8
    assert density(drawn(*ROOM), 20) == "@@@@@@@@@@\n@@::::++@@\n@@::==::\n@@@@**::"


def test_a_map_wider_than_the_picture_has_blocks_twice_as_high_as_wide():
    grid = drawn("#" * 8, *["#......#"] * 6, "#" * 8)
    assert three_state(grid, 8) == "########\n#......#\n#......#\n########"
    assert three_state(grid, 4) == "####\n####"


def test_unobserved_cells_are_blank_or_unknown():
    grid = OccupancyGrid(GridGeometry(0.1, 4, 4))
    assert set(three_state(grid, 80)) == {"?", "\n"}
    assert density(grid, 80).strip() == ""


@given(
    rows=st.integers(1, 90),
    cols=st.integers(1, 90),
    width=st.integers(1, 60),
    wall=st.integers(0, 89),
    upright=st.booleans(),
)
def test_a_wall_of_one_cell_survives_every_width(rows, cols, width, wall, upright):
    grid = OccupancyGrid(GridGeometry(0.1, rows, cols))
    grid.log_odds[:], grid.observed[:] = -2.0, True
    if upright:
        grid.log_odds[:, wall % cols] = 3.5
    else:
        grid.log_odds[wall % rows] = 3.5
    for picture, character in ((three_state(grid, width), "#"), (density(grid, width), "@")):
        lines = picture.split("\n")
        assert max(len(line) for line in lines) <= width
        if upright:
            assert all(character in line for line in lines)
        else:
            assert any(set(line) == {character} for line in lines)


def test_a_picture_has_the_maps_proportions():
    grid = OccupancyGrid(GridGeometry(0.1, 200, 300))
    grid.observed[:] = True
    lines = three_state(grid, 100).split("\n")
    assert len(lines[0]) == 100
    # A character stands twice as high as wide: 200 cells of 300 are 2/3 · 100 / 2 lines.
    assert len(lines) == pytest.approx(100 * 200 / 300 / 2, abs=1)


def test_the_top_of_the_picture_is_the_greatest_y():
    grid = OccupancyGrid(GridGeometry(0.1, 2, 1))
    grid.observed[:] = True
    grid.log_odds[:] = np.array([[-2.0], [3.5]])
    assert three_state(grid, 2) == "##\n.."


def test_a_width_of_nothing_is_refused():
    with pytest.raises(ConfigError, match="at least one character"):
        three_state(drawn(*ROOM), 0)
