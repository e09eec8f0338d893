"""Maps of CMU's course: which way round they are, and what is refused."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import MapperError
from mapper.core.limits import Limits
from mapper.grid import FREE, OCCUPIED, UNKNOWN
from mapper.io.maps import load_map

HEAD = (
    "robot_specifications->global_mapsize_x 30\nrobot_specifications->resolution 10\n"
    "robot_specifications->autoshifted_x 100\nrobot_specifications->autoshifted_y 0\n\nglobal_map[0]: 3 2\n"
)
CELLS = "1.000 0.000\n-1.000 0.5\n1 0.25\n"


def written(folder: Path, text: str, name: str = "hall.dat.gz") -> Path:
    path = folder / name
    path.write_bytes(gzip.compress(text.encode()) if name.endswith("gz") else text.encode())
    return path


@pytest.mark.parametrize("name", ["hall.dat.gz", "hall.dat"])
def test_a_row_of_the_text_is_a_column_of_the_map_and_1_is_free(tmp_path: Path, name: str):
    grid = load_map(written(tmp_path, HEAD + CELLS, name)).grid
    assert grid.geometry.shape == (2, 3)
    assert (grid.geometry.resolution, grid.geometry.origin) == (0.1, (1.0, 0.0, 0.0))
    np.testing.assert_array_equal(grid.classify(), [[FREE, UNKNOWN, FREE], [OCCUPIED, UNKNOWN, OCCUPIED]])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + "1 0 1", "has 3 values for its 6 cells"),
        (HEAD + CELLS + "1 1", "has 8 values for its 6 cells"),
        (HEAD + CELLS.replace("0.25", "2"), "neither -1 nor between 0 and 1"),
        (HEAD + CELLS.replace("0.25", "nan"), "neither -1 nor between 0 and 1"),
        (HEAD + CELLS.replace("0.25", "wall"), "is not a number"),
        (HEAD.replace("resolution 10", "resolution 0") + CELLS, "states no resolution"),
        (HEAD.replace("global_map[0]: 3 2", "") + CELLS, "lacks the line"),
        (HEAD + CELLS + " " * 500, "longer than"),
        (HEAD.replace("3 2", "9999999 2") + CELLS, "larger than the limit"),
    ],
)
def test_maps_that_are_damaged(tmp_path: Path, text: str, said: str):
    with pytest.raises(MapperError, match=said):
        load_map(written(tmp_path, text), Limits(max_side=1000))


def test_gzip_that_ends_early(tmp_path: Path):
    path = written(tmp_path, HEAD + CELLS * 1)
    path.write_bytes(path.read_bytes()[:-12])
    with pytest.raises(MapperError, match=r"cannot be read|of its"):
        load_map(path)
