"""Map files are read back unchanged, and agree with the formulas of map_server."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.io.maps import load_map, occupancy_values, pgm_bytes, png_bytes, save_map, yaml_text
from tests.mapper.io.maps.map_server import served

GEOMETRY = GridGeometry(0.05, 3, 4, (-1.5, 2.25, 0.5))


def a_grid() -> OccupancyGrid:
    """Occupied at the lower left, free at the upper right, one cell undecided, the others never observed."""
    grid = OccupancyGrid(GEOMETRY)
    for (row, col), value in {(0, 0): 3.5, (2, 3): -2.0, (1, 1): 0.1}.items():
        grid.log_odds[row, col] = value
        grid.observed[row, col] = True
    return grid


@st.composite
def grids(draw: st.DrawFn) -> OccupancyGrid:
    rows, cols = draw(st.integers(1, 12)), draw(st.integers(1, 12))
    origin = tuple(draw(st.floats(-1e3, 1e3)) for _ in range(3))
    grid = OccupancyGrid(GridGeometry(draw(st.floats(0.01, 10.0)), rows, cols, (origin[0], origin[1], origin[2])))
    rng = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    # Around the thresholds' log-odds too, where rounding could carry a cell across.
    grid.log_odds[:] = rng.choice([rng.uniform(-12, 12), math.log(0.65 / 0.35), math.log(0.25 / 0.75)], (rows, cols))
    grid.log_odds += rng.choice([0.0, 1e-7, -1e-7, 0.005, -0.005, 1.0, -1.0], (rows, cols)).astype(np.float32)
    grid.observed[:] = rng.random((rows, cols)) < 0.7
    return grid


def test_a_trinary_pgm_has_map_savers_greys_and_the_top_row_first():
    image = Image.open(io.BytesIO(pgm_bytes(a_grid())))
    assert image.format == "PPM"
    assert np.asarray(image).tolist() == [[205, 205, 205, 254], [205, 205, 205, 205], [0, 205, 205, 205]]


def test_the_yaml_has_the_keys_that_map_server_reads():
    assert yaml.safe_load(yaml_text(GEOMETRY, "lab.pgm")) == {
        "image": "lab.pgm",
        "mode": "trinary",
        "resolution": 0.05,
        "origin": [-1.5, 2.25, 0.5],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }


@pytest.mark.parametrize(
    "name",
    ["plain.pgm", "a b.pgm", "on: off.pgm", "1e5.pgm", "ünïcode.pgm", 'quo"te.pgm', "#.pgm", "a\\b.pgm"]
    + [f"a{c}b.pgm" for c in "\n\t\x07\x7f\x85\u2028\u202e\ufeff\U0001f600"],
)
def test_the_yaml_quotes_what_needs_quotes(name):
    assert yaml.safe_load(yaml_text(GEOMETRY, name))["image"] == name


def test_grey_205_is_unknown_with_the_thresholds_that_are_written():
    """map_server takes a pixel for free below free_thresh: 0.25 would turn all that is unknown free."""
    written = yaml.safe_load(yaml_text(GEOMETRY, "lab.pgm"))
    assert written["free_thresh"] <= (255 - 205) / 255 <= written["occupied_thresh"]
    assert written["free_thresh"] > (255 - 254) / 255


@given(grid=grids(), mode=st.sampled_from(["trinary", "scale", "raw"]))
def test_a_saved_map_loads_with_the_same_states_in_the_same_place(tmp_path_factory, grid, mode):
    yaml_path, image_path = save_map(grid, tmp_path_factory.mktemp("map") / "lab.v2", mode)
    assert (yaml_path.name, image_path.name) == ("lab.v2.yaml", "lab.v2.png" if mode == "scale" else "lab.v2.pgm")
    loaded = load_map(yaml_path)
    assert loaded.grid.geometry == grid.geometry
    np.testing.assert_array_equal(loaded.grid.classify(), grid.classify())
    if mode != "trinary":
        np.testing.assert_array_equal(loaded.values, occupancy_values(grid))
        probability = 100.0 / (1.0 + np.exp(-grid.log_odds.astype(float)))
        assert np.abs(loaded.values - probability)[grid.observed].max(initial=0.0) <= 1.01
    assert all("is turned by" in note for note in loaded.notes)


@given(grid=grids(), mode=st.sampled_from(["trinary", "scale", "raw"]))
def test_a_saved_map_has_the_same_states_in_map_server(tmp_path_factory, grid, mode):
    yaml_path, _ = save_map(grid, tmp_path_factory.mktemp("map") / "lab", mode)
    values, keys = served(yaml_path)
    # The three states of a cell at 0.65 and 0.25, by the definition; never observed is unknown.
    p_occ = 1.0 / (1.0 + np.exp(-grid.log_odds.astype(np.float64)))
    clear = np.abs(p_occ[..., None] - [0.65, 0.25]).min(axis=-1) > 1e-6
    state = np.where(p_occ > 0.65, 100, np.where(p_occ < 0.25, 0, -1))
    state[~grid.observed] = -1
    if mode == "trinary":
        np.testing.assert_array_equal(values[clear], state[clear])
    else:
        assert ((values == -1) == ~grid.observed).all()
        assert np.abs(values - 100.0 * p_occ)[grid.observed].max(initial=0.0) <= 1.01
    geometry = grid.geometry
    assert (keys["resolution"], tuple(keys["origin"])) == (geometry.resolution, geometry.origin)
    assert (keys["mode"], keys["negate"]) == (mode, 0)


def test_other_thresholds_are_those_of_the_states():
    grid = a_grid()
    assert np.asarray(Image.open(io.BytesIO(pgm_bytes(grid, 0.98, 0.05)))).tolist() == [[205] * 4] * 3
    assert np.asarray(Image.open(io.BytesIO(pgm_bytes(grid, 0.51, 0.5))))[1].tolist() == [205, 0, 205, 205]


def test_saving_makes_folders_leaves_nothing_beside_the_files_and_replaces_them(tmp_path):
    for _ in range(2):
        save_map(a_grid(), tmp_path / "out" / "deep" / "lab")
    assert sorted(path.name for path in (tmp_path / "out" / "deep").iterdir()) == ["lab.pgm", "lab.yaml"]


def test_a_map_that_cannot_be_written_is_refused_and_leaves_nothing(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written") as caught:
        save_map(a_grid(), tmp_path / "file" / "lab")
    assert caught.value.code == "map.unwritable"
    (tmp_path / "lab.yaml").mkdir()
    with pytest.raises(ConfigError, match="cannot be written"):
        save_map(a_grid(), tmp_path / "lab")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "lab.pgm", "lab.yaml"]
    with pytest.raises(ConfigError, match="needs a file name"):
        save_map(a_grid(), "/")


def test_a_pgm_cannot_hold_transparency():
    with pytest.raises(ConfigError, match="transparency"):
        pgm_bytes(a_grid(), mode="scale")


def test_the_picture_is_white_where_free_black_where_occupied_and_blue_where_unobserved():
    image = Image.open(io.BytesIO(png_bytes(a_grid())))
    pixels = np.asarray(image.convert("RGB")).astype(int)
    assert pixels.shape == (3, 4, 3)
    expected = {(2, 0): 3.5, (0, 3): -2.0, (1, 1): 0.1}  # image rows run downwards, the grid's upwards
    for row in range(3):
        for col in range(4):
            red, green, blue = pixels[row, col]
            if (row, col) in expected:
                grey = 255.0 / (1.0 + math.exp(expected[row, col]))
                assert red == green == blue == pytest.approx(grey, abs=1.0)
            else:
                assert blue > green > red


def test_a_yaw_turns_the_map_about_its_corner(tmp_path):
    yaml_path, _ = save_map(a_grid(), tmp_path / "lab")
    centre = load_map(yaml_path).grid.geometry.cell_to_world((0, 0))
    half = 0.025
    expected = [
        -1.5 + half * (math.cos(0.5) - math.sin(0.5)),
        2.25 + half * (math.sin(0.5) + math.cos(0.5)),
    ]
    np.testing.assert_allclose(centre, expected)


def write(folder, image: Image.Image, name="m.png", **keys):
    image.save(folder / name)
    values = {
        "image": name, "resolution": 0.1, "origin": [0, 0, 0], "negate": 0, "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }  # fmt: skip
    path = folder / "m.yaml"
    path.write_text(yaml.safe_dump(values | keys))
    return path


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("negate", [0, 1])
@pytest.mark.parametrize("pixels", ["L", "RGB", "RGBA", "LA", "P", "1", "I;16"])
def test_every_kind_of_pixel_follows_map_servers_formula(tmp_path, mode, negate, pixels):
    rng = np.random.default_rng(5)
    if pixels == "I;16":
        image = Image.fromarray(rng.integers(0, 65536, (8, 9)).astype(np.uint16))
    else:
        rgba = Image.fromarray(rng.integers(0, 256, (8, 9, 4)).astype(np.uint8))
        rgba.putpixel((0, 0), (10, 20, 30, 255))
        image = rgba.convert("RGB").convert("P") if pixels == "P" else rgba.convert(pixels)
    path = write(tmp_path, image, mode=mode, negate=negate)
    expected, _ = served(path)
    loaded = load_map(path)
    np.testing.assert_array_equal(loaded.values, expected)
    np.testing.assert_array_equal(loaded.grid.observed, expected >= 0)


def test_a_transparent_palette_colour_is_unknown_in_scale_mode(tmp_path):
    image = Image.new("P", (2, 1))
    image.putpalette([0, 0, 0, 255, 255, 255])
    image.putpixel((1, 0), 1)
    image.info["transparency"] = 1
    path = write(tmp_path, image, mode="scale")
    assert load_map(path).values.tolist() == [[100, -1]]


def test_unknown_cells_that_map_server_reads_as_free_are_noted(tmp_path):
    path = write(tmp_path, Image.new("L", (2, 2), 205), free_thresh=0.25)
    loaded = load_map(path)
    assert loaded.values.tolist() == [[0, 0], [0, 0]]
    assert any("205" in note for note in loaded.notes)
