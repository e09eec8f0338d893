"""Real maps, decoded independently with Pillow and the formulas of map_server."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from mapper.core.errors import ReadError
from mapper.io.maps import load_map

#: name, image, mode, negate, occupied_thresh, free_thresh, resolution, origin: as the yaml files say, written down here
MAPS = [
    ("depot", "depot.pgm", "trinary", 0, 0.65, 0.25, 0.05, (0, 0, 0)),
    ("tb3_sandbox", "tb3_sandbox.pgm", "trinary", 0, 0.65, 0.196, 0.05, (-10, -10, 0)),
    ("depot_speed", "depot_speed.pgm", "scale", 0, 1.0, 0.0, 0.05, (0, 0, 0)),
    ("speed_mask", "speed_mask.pgm", "scale", 0, 0.99, 0.01, 0.05, (-10, -10, 0)),
    ("100by100_10", "100by100_10.pgm", "trinary", 1, 0.65, 0.196, 0.05, (0, 0, 0)),
    ("testmap", "testmap.png", "trinary", 0, 0.65, 0.196, 0.1, (2, 3, 1)),
]


def decoded(path: Path, mode: str, negate: int, occupied: float, free: float) -> NDArray[np.int64]:
    shade = np.asarray(Image.open(path).convert("RGB")).astype(float).mean(axis=2) / 255.0
    occupancy = shade if negate else 1.0 - shade
    values = np.full(shade.shape, -1)
    if mode == "scale":
        values = np.rint(100.0 * (occupancy - free) / (occupied - free)).astype(int)
    values[occupancy > occupied] = 100
    values[occupancy < free] = 0
    return values[::-1]


@pytest.mark.parametrize(("name", "image", "mode", "negate", "occupied", "free", "resolution", "origin"), MAPS)
def test_real_map(data_file, name, image, mode, negate, occupied, free, resolution, origin):
    loaded = load_map(data_file(f"maps/{name}.yaml"))
    np.testing.assert_array_equal(loaded.values, decoded(data_file(f"maps/{image}"), mode, negate, occupied, free))
    geometry = loaded.grid.geometry
    assert (geometry.resolution, geometry.origin) == (resolution, origin)
    assert loaded.description.mode == mode


@pytest.mark.parametrize("kind", ["pgm", "png", "bmp"])
def test_the_same_map_as_pgm_png_and_bmp(data_file, tmp_path, kind):
    shutil.copy(data_file(f"maps/testmap.{kind}"), tmp_path)
    text = data_file("maps/testmap.yaml").read_text().replace("testmap.png", f"testmap.{kind}")
    (tmp_path / "m.yaml").write_text(text)
    # Nine rows of ten tell a map that is upside down from one that is not.
    reference = decoded(data_file("maps/testmap.png"), "trinary", 0, 0.65, 0.196)
    assert not np.array_equal(reference, reference[::-1])
    np.testing.assert_array_equal(load_map(tmp_path / "m.yaml").values, reference)


def test_the_yaml_that_names_a_missing_image(data_file):
    with pytest.raises(ReadError, match=r"names the image 'invalid\.png', which does not exist") as caught:
        load_map(data_file("maps/invalid_image.yaml"))
    assert caught.value.code == "map.image_missing"
