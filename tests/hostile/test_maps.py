"""Map files that are wrong, or meant to harm: each gets its own error, which names the key or the image."""

from __future__ import annotations

import struct
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from mapper.errors import LimitError, MapperError, ReadError
from mapper.limits import DEFAULT_LIMITS, Limits
from mapper.maps import load_map

GOOD = "image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
PGM = b"P5\n4 3\n255\n" + bytes(range(0, 240, 20))


def folder_with(folder: Path, text: str | bytes = GOOD, image: bytes | None = PGM, name: str = "m.pgm") -> Path:
    if image is not None:
        (folder / name).write_bytes(image)
    path = folder / "m.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def refused(path: Path, limits: Limits = DEFAULT_LIMITS) -> MapperError:
    with pytest.raises(MapperError) as caught:
        load_map(path, limits)
    assert str(path.parent) not in caught.value.message, "an error must not tell where files lie on the server"
    return caught.value


def with_value(key: str, value: str) -> str:
    lines = [f"{key}: {value}" if line.startswith(f"{key}:") else line for line in GOOD.splitlines()]
    return "\n".join(lines) + "\n"


YAMLS = {
    "empty": ("", "map.yaml", "list of keys"),
    "a list": ("- 1\n- 2\n", "map.yaml", "list of keys"),
    "malformed": ("image: [m.pgm\nresolution: 1\n", "map.yaml", "malformed in line"),
    "a tab": (GOOD + "\tmode: raw\n", "map.yaml", "malformed in line"),
    "a control character": (GOOD + "x: \x07\n", "map.yaml", "forbids"),
    "two documents": (GOOD + "---\n" + GOOD, "map.yaml", "malformed in line 7"),
    "a key twice": (GOOD + "resolution: 0.1\n", "map.yaml", "'resolution' twice, in line 7"),
    "a key that is no word": ("[1, 2]: 3\n" + GOOD, "map.yaml", "a key that is no word"),
    "an alias": ("a: &a [1]\nb: *a\n" + GOOD, "map.yaml", "aliases are not allowed"),
    "billion laughs": (
        "a: &a [x, x]\n" + "".join(f"{c}: &{c} [*{p}, *{p}]\n" for p, c in zip("abcdefgh", "bcdefghi", strict=True)),
        "map.yaml", "aliases are not allowed",
    ),
    "a merge": ("a: &a {image: x}\n<<: *a\n" + GOOD, "map.yaml", "aliases are not allowed"),
    "nested too deeply": ("a: " + "[" * 30000 + "\n", "map.yaml", "nested too deeply"),
    "no image": (GOOD.replace("image", "picture"), "map.key_missing", "'image'"),
    "no resolution": (GOOD.replace("resolution", "res"), "map.key_missing", "'resolution'"),
    "no origin": (GOOD.replace("origin", "place"), "map.key_missing", "'origin'"),
    "no negate": (GOOD.replace("negate", "inverse"), "map.key_missing", "'negate'"),
    "no threshold": (GOOD.replace("free_thresh", "f"), "map.key_missing", "'free_thresh'"),
    "resolution 1:30": (with_value("resolution", "1:30"), "map.value", "'resolution' of the map's yaml must be"),
    "resolution nan": (with_value("resolution", ".nan"), "map.value", "not '.nan'"),
    "resolution inf": (with_value("resolution", ".inf"), "map.value", "not '.inf'"),
    "resolution 1e999": (with_value("resolution", "1e999"), "map.value", "not '1e999'"),
    "resolution in hex": (with_value("resolution", "0x10"), "map.value", "not '0x10'"),
    "resolution with underscore": (with_value("resolution", "1_0"), "map.value", "not '1_0'"),
    "resolution true": (with_value("resolution", "true"), "map.value", "not 'true'"),
    "resolution missing": (with_value("resolution", ""), "map.value", "not ''"),
    "resolution a list": (with_value("resolution", "[1]"), "map.value", "needs one value"),
    "resolution python": (with_value("resolution", "!!python/object/apply:os.getcwd []"), "map.value", "one value"),
    "resolution 0": (with_value("resolution", "0"), "map.resolution", "must be positive"),
    "resolution -1": (with_value("resolution", "-0.05"), "map.resolution", "must be positive"),
    "origin short": (with_value("origin", "[0, 0]"), "map.origin", "three numbers"),
    "origin a word": (with_value("origin", "here"), "map.origin", "three numbers"),
    "origin nan": (with_value("origin", "[0, .nan, 0]"), "map.value", "'origin'"),
    "origin far": (with_value("origin", "[0, 1e300, 0]"), "map.origin", "beyond"),
    "thresholds swapped": (with_value("free_thresh", "0.9"), "map.thresholds", "free_thresh < occupied_thresh"),
    "threshold in per cent": (with_value("occupied_thresh", "65"), "map.thresholds", "not 0.196 and 65"),
    "negate 2": (with_value("negate", "2"), "map.value", "must be 0 or 1, not '2'"),
    "mode unknown": (GOOD + "mode: ternary\n", "map.mode", "not 'ternary'"),
    "image absolute": (with_value("image", "/etc/passwd"), "map.image_outside", "absolute path, '/etc/passwd'"),
    "image absolute elsewhere": (with_value("image", "C:\\m.pgm"), "map.image_outside", "absolute path"),
    "image in the parent": (with_value("image", "../m.pgm"), "map.image_outside", "outside its own folder"),
    "image in the parent, hidden": (with_value("image", "a/../../m.pgm"), "map.image_outside", "outside its own"),
    "image in the parent, backslash": (with_value("image", "..\\m.pgm"), "map.image_outside", "outside its own"),
    "image empty": (with_value("image", '""'), "map.image_name", "names no image"),
    "image with NUL": (with_value("image", '"m\\0.pgm"'), "map.image_name", "names no image"),
    "image a list": (with_value("image", "[m.pgm]"), "map.value", "needs one value"),
    "image missing": (with_value("image", "gone.png"), "map.image_missing", "'gone.png', which does not exist"),
    "image a folder": (with_value("image", "."), "map.image_missing", "does not exist"),
    "image with a very long name": (with_value("image", "m" * 5000), "map.image_missing", "mmm"),
}  # fmt: skip


@pytest.mark.parametrize("case", YAMLS)
def test_a_bad_yaml_is_refused_with_what_is_wrong(tmp_path, case):
    text, code, words = YAMLS[case]
    error = refused(folder_with(tmp_path, text))
    assert isinstance(error, ReadError)
    assert (error.code, words in error.message) == (code, True), error.message
    assert len(error.message) < 300


def test_the_good_yaml_is_good(tmp_path):
    assert load_map(folder_with(tmp_path)).grid.geometry.shape == (3, 4)


def test_a_yaml_that_is_missing_a_folder_too_large_or_not_text(tmp_path):
    assert refused(tmp_path / "gone.yaml").code == "map.missing"
    (tmp_path / "folder").mkdir()
    assert refused(tmp_path / "folder").code == "map.unreadable"
    large = refused(folder_with(tmp_path, GOOD + "#" * (1 << 17)))
    assert (type(large), large.code) == (LimitError, "map.yaml_too_large")
    assert "not UTF-8" in refused(folder_with(tmp_path, b"image: \xff\n")).message


def test_a_link_that_leaves_the_folder_is_refused_and_one_within_it_is_followed(tmp_path):
    inside = tmp_path / "inside"
    inside.mkdir()
    (tmp_path / "outside.pgm").write_bytes(PGM)
    path = folder_with(inside, image=None)
    (inside / "m.pgm").symlink_to("../outside.pgm")
    assert refused(path).code == "map.image_outside"
    (inside / "m.pgm").unlink()
    (inside / "real.pgm").write_bytes(PGM)
    (inside / "m.pgm").symlink_to("real.pgm")
    assert load_map(path).grid.geometry.shape == (3, 4)
    (inside / "m.pgm").unlink()
    (inside / "m.pgm").symlink_to("m.pgm")
    assert refused(path).code == "map.image_missing"


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (b"", "no PGM, PNG or BMP"),
        (b"hello", "no PGM, PNG or BMP"),
        (b"GIF89a\x01\0\x01\0\x80\0\0\0\0\0\xff\xff\xff;", "no PGM, PNG or BMP"),
        (PGM[:-3], "damaged"),
        (b"P5\n4 x\n255\n" + bytes(12), "damaged"),
        (b"P5\n0 0\n255\n", "damaged"),
        (b"P5\n-4 3\n255\n" + bytes(12), "damaged"),
    ],
)
def test_a_damaged_image_is_refused(tmp_path, image, words):
    error = refused(folder_with(tmp_path, image=image))
    assert error.code == "map.image"
    assert words in error.message


def _png_header(width: int, height: int) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(bytes(100))) + chunk(b"IEND", b"")


@pytest.mark.parametrize(("width", "height"), [(60_000, 60_000), (12_000, 12_000), (40_000, 1), (2_000_000_000, 2)])
def test_an_image_of_too_many_pixels_is_refused_before_it_is_decoded(tmp_path, width, height):
    limits = replace(DEFAULT_LIMITS, max_cells=100_000_000)
    for image in (_png_header(width, height), f"P5\n{width} {height}\n255\n".encode()):
        error = refused(folder_with(tmp_path, image=image), limits)
        assert (type(error), error.code) == (LimitError, "map.image_too_large")


def test_an_image_of_too_many_bytes_is_refused(tmp_path):
    error = refused(folder_with(tmp_path), replace(DEFAULT_LIMITS, max_image_bytes=10))
    assert (type(error), error.code) == (LimitError, "map.image_too_large")


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    folder = tmp_path_factory.mktemp("images")
    pixels = Image.fromarray(np.arange(240, dtype=np.uint8).reshape(6, 10, 4))
    found = [PGM]
    for name, mode in (("a.png", "RGBA"), ("b.png", "P"), ("c.bmp", "RGB"), ("d.bmp", "P"), ("e.pgm", "L")):
        pixels.convert(mode).save(folder / name)
        found.append((folder / name).read_bytes())
    return found


@settings(max_examples=400)
@given(data=st.data())
def test_nothing_but_our_own_errors_escapes(tmp_path_factory, images, data):
    image = bytearray(data.draw(st.sampled_from(images)))
    text = bytearray(GOOD.encode())
    for target in (image, text):
        for _ in range(data.draw(st.integers(0, 3))):
            place = data.draw(st.integers(0, max(0, len(target) - 1)))
            kind = data.draw(st.sampled_from(["replace", "cut", "insert"]))
            if kind == "cut":
                del target[place:]
            elif kind == "insert":
                target[place:place] = data.draw(st.binary(max_size=6))
            elif target:
                target[place] = data.draw(st.integers(0, 255))
    path = folder_with(tmp_path_factory.mktemp("fuzz"), bytes(text), bytes(image))
    refusal = None
    try:
        loaded = load_map(path)
    except MapperError as error:
        refusal = error
    if refusal is not None:
        assert refusal.code.split(".")[0] in ("map", "grid")
        assert refusal.message.endswith(".")
    else:
        assert np.isfinite(loaded.grid.log_odds).all()
