"""Map files that are wrong or malicious: each has its own error, which names the key or the image."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, PpmImagePlugin

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.maps import LoadedMap, load_map
from mapper.io.maps.reading import open_plain_image
from mapper.io.untrusted_yaml import UntrustedLoader
from tests.hostile.corpus import MAP_YAML, images
from tests.hostile.damage import ALL, ROUNDS, check_sentence, flipped, mangled

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
    "a key twice": (GOOD + "resolution: 0.1\n", "map.yaml", "'resolution' twice, in line 7"),
    "a key that is no word": ("[1, 2]: 3\n" + GOOD, "map.yaml", "a key that is not a word"),
    "a list within itself": ("a: &a [*a]\n" + GOOD, "map.yaml", "'a' is within itself"),
    "billion laughs": (
        "a: &a [x, x]\n" + "".join(f"{c}: &{c} [*{p}, *{p}]\n" for p, c in zip("abcdefgh", "bcdefghi", strict=True)),
        "map.yaml", "nested too deeply",
    ),
    "nested too deeply": ("a: " + "[" * 30000 + "\n", "map.yaml", "line 1: it is nested too deeply"),
    "nested too deeply, in braces": ("a: " + "{" * 30000 + "\n", "map.yaml", "line 1: it is nested too deeply"),
    "nested too deeply, in dashes": ("- " * 30000 + "\n", "map.yaml", "line 1: it is nested too deeply"),
    "an object of Python": ("!!python/object/apply:os.system ['true']\n" + GOOD, "map.yaml", "malformed in line 2"),
    "only an object of Python": ("!!python/object/apply:os.system ['true']\n", "map.yaml", "list of keys"),
    "image python": (with_value("image", "!!python/object/new:os.stat [/]"), "map.value", "needs one value"),
    "resolution with a tag": (with_value("resolution", "!!python/name:os.getcwd"), "map.value", "not ''"),
    "no image": (GOOD.replace("image", "picture"), "map.key_missing", "'image'"),
    "no resolution": (GOOD.replace("resolution", "res"), "map.key_missing", "'resolution'"),
    "no origin": (GOOD.replace("origin", "place"), "map.key_missing", "'origin'"),
    "no negate": (GOOD.replace("negate", "inverse"), "map.key_missing", "'negate'"),
    "no threshold": (GOOD.replace("free_thresh", "f"), "map.key_missing", "'free_thresh'"),
    "resolution 1:30": (with_value("resolution", "1:30"), "map.value", "'resolution' of the map’s yaml must be"),
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
    "threshold in per cent": (with_value("occupied_thresh", "65"), "map.thresholds", "not 0.196 and 65"),
    "negate 2": (with_value("negate", "2"), "map.value", "must be 0 or 1, not '2'"),
    "mode unknown": (GOOD + "mode: ternary\n", "map.mode", "not 'ternary'"),
    "image absolute": (with_value("image", "/etc/passwd"), "map.image_outside", "no 'passwd' beside the yaml"),
    "image absolute elsewhere": (with_value("image", "C:\\n.pgm"), "map.image_missing", "no 'n.pgm' beside the yaml"),
    "image in the parent": (with_value("image", "../n.pgm"), "map.image_outside", "outside the yaml’s own folder"),
    "image in the parent, hidden": (with_value("image", "a/../../n.pgm"), "map.image_outside", "outside the yaml’s"),
    "image the parent": (with_value("image", ".."), "map.image_outside", "outside the yaml’s own folder"),
    "image empty": (with_value("image", '""'), "map.image_name", "names no image"),
    "image with NUL": (with_value("image", '"m\\0.pgm"'), "map.image_name", "names no image"),
    "image a list": (with_value("image", "[m.pgm]"), "map.value", "needs one value"),
    "image missing": (with_value("image", "gone.png"), "map.image_missing", "'gone.png', which does not exist"),
    "image a folder": (with_value("image", "."), "map.image_missing", "does not exist"),
    "image with a very long name": (with_value("image", "m" * 5000), "map.image_missing", "mmm"),
}  # fmt: skip


@pytest.mark.parametrize("case", YAMLS)
def test_a_bad_yaml_is_refused_with_the_reason(tmp_path, case):
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
    large = refused(folder_with(tmp_path, GOOD + "x: " + "[" * 100_000))
    assert (type(large), large.code) == (LimitError, "map.yaml_too_large")
    assert "a character that YAML forbids" in refused(folder_with(tmp_path, b"image: \x81\n")).message


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
        (b"", "not a PGM, PNG or BMP"),
        (b"hello", "not a PGM, PNG or BMP"),
        (b"GIF89a\x01\0\x01\0\x80\0\0\0\0\0\xff\xff\xff;", "not a PGM, PNG or BMP"),
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


@pytest.mark.parametrize(
    "image",
    [
        b"P5\n16000 16000\n255\n" + bytes(12),
        b"P5\n16000 16000\n65535\n" + bytes(12),
        b"P2\n16000 16000\n255\n0 1 2\n",
        b"P4\n16000 16000\n" + bytes(12),
        _png_header(16_000, 16_000),
    ],
    ids=["pgm", "pgm of 16 bits", "pgm as text", "bits", "png"],
)
def test_an_image_larger_than_its_bytes_allow_is_refused(tmp_path, image):
    error = refused(folder_with(tmp_path, image=image))
    assert (type(error), error.code) == (ReadError, "map.image")
    assert "claims 16000 × 16000 pixels, which its" in error.message


def test_twenty_thousand_cells_a_side_are_over_the_limit(tmp_path):
    error = refused(folder_with(tmp_path, image=_png_header(20_000, 20_000)))
    assert (type(error), error.code) == (LimitError, "map.image_too_large")
    assert "20000 × 20000" in error.message


def test_the_cap_on_pixels_is_ours_alone(tmp_path, monkeypatch):
    """Pillow's own, of 179 million, would refuse maps of 16,000 cells a side."""
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 5)
    for image in (PGM, images()["png grey"], images()["bmp"]):
        assert load_map(folder_with(tmp_path, image=image)).grid.geometry.shape in ((3, 4), (6, 10))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


@pytest.mark.parametrize("kind", [b"zTXt", b"iCCP"])
def test_a_png_with_a_bomb_beside_its_pixels(tmp_path, kind):
    packed = zlib.compress(bytes(8 << 20))
    png = images()["png grey"]
    bomb = png[:33] + _chunk(kind, b"a\0\0" + packed) + png[33:]
    assert refused(folder_with(tmp_path, image=bomb)).code == "map.image"


@pytest.mark.parametrize(
    "image",
    [
        b"P5 # a remark\n# another 9 9 9\n4 3\n#\n255\n" + bytes(range(0, 240, 20)),
        b"P5\n#" + b"x" * 100_000 + b"\n4 3\n255\n" + bytes(range(0, 240, 20)),
        b"P2\n4 3\n255\n" + b" ".join(b"%d" % grey for grey in range(0, 240, 20)),
        b"P2\r\n4 3\r\n255\r\n" + b"\r\n".join(b"%d" % grey for grey in range(0, 240, 20)),
        b"P5\n4 3\n255\n" + bytes(range(0, 240, 20)) + b"what follows is not looked at",
    ],
    ids=["remarks", "a long remark", "text", "text of Windows", "more bytes"],
)
def test_a_pgm_that_is_odd_and_good(tmp_path, image):
    plain = load_map(folder_with(tmp_path))
    np.testing.assert_array_equal(load_map(folder_with(tmp_path, image=image)).values, plain.values)


@pytest.mark.parametrize("maximum", [100, 1000, 65535])
def test_a_pgm_of_other_depths(tmp_path, maximum):
    """A grey counts as its share of the greatest."""
    greys = [round(share * maximum) for share in (0.0, 0.3, 0.36, 0.5, 0.79, 0.81, 1.0)]
    pixels = bytes(greys) if maximum < 256 else struct.pack(f">{len(greys)}H", *greys)
    loaded = load_map(folder_with(tmp_path, image=b"P5\n7 1\n%d\n" % maximum + pixels))
    assert loaded.values.tolist() == [[100, 100, -1, -1, -1, 0, 0]]


def _outcome(folder: Path, text: bytes, image: bytes) -> LoadedMap | MapperError:
    """The map, or the error in one sentence; anything else is a defect."""
    path = folder_with(folder, text, image)
    refusal = None
    try:
        loaded = load_map(path)
    except MapperError as error:
        refusal = error
    if refusal is not None:
        check_sentence(refusal, path, "map", "grid")
        return refusal
    assert np.isfinite(loaded.grid.log_odds).all()
    assert ((loaded.values >= -1) & (loaded.values <= 100)).all()
    return loaded


@pytest.mark.sampled
@pytest.mark.parametrize("kind", images())
def test_flipped_bits_in_an_image(tmp_path, kind):
    rng = np.random.default_rng(list(kind.encode()))
    for n in range(ROUNDS if ALL else ROUNDS // 3):
        text = MAP_YAML.replace("trinary", ("trinary", "scale", "raw")[n % 3])
        _outcome(tmp_path, text.encode(), flipped(rng, images()[kind]))


@pytest.mark.sampled
@pytest.mark.parametrize(
    "damage", [lambda rng: flipped(rng, MAP_YAML.encode()), lambda rng: mangled(rng, MAP_YAML, ": ")]
)
def test_flipped_bits_and_mistakes_in_a_yaml(tmp_path, damage):
    rng = np.random.default_rng(7)
    found = [_outcome(tmp_path, damage(rng), PGM) for _ in range(ROUNDS)]
    assert 0 < sum(isinstance(one, LoadedMap) for one in found) < ROUNDS


@pytest.mark.sampled
@pytest.mark.parametrize("kind", images())
def test_every_prefix_of_an_image(tmp_path, kind):
    data = images()[kind]
    whole = _outcome(tmp_path, MAP_YAML.encode(), data)
    assert isinstance(whole, LoadedMap)
    sure = whole.values.size - kind.endswith("text")  # the last number of a text may be cut and still be one
    for n in range(0, len(data), 1 if ALL else 9):
        found = _outcome(tmp_path, MAP_YAML.encode(), data[:n])
        if isinstance(found, LoadedMap):  # what is missing is not of the pixels
            np.testing.assert_array_equal(found.values[::-1].ravel()[:sure], whole.values[::-1].ravel()[:sure])


def test_every_prefix_of_a_yaml(tmp_path):
    for n in range(len(MAP_YAML)):
        found = _outcome(tmp_path, MAP_YAML[:n].encode(), PGM)
        assert isinstance(found, MapperError) or n > MAP_YAML.index("free_thresh")


@pytest.mark.parametrize("opening", ["[", "{", "- ", "? "])
def test_the_work_on_a_deeply_nested_yaml_does_not_grow_with_its_depth(tmp_path, monkeypatch, opening):
    calls = 0
    peek = UntrustedLoader.peek_event

    def counted(loader):
        nonlocal calls
        calls += 1
        return peek(loader)

    monkeypatch.setattr(UntrustedLoader, "peek_event", counted, raising=False)  # an event is a step of the parser
    refused(folder_with(tmp_path, opening * (60_000 // len(opening))))
    assert 0 < calls < 100


class _Counted(io.BytesIO):
    reads = 0

    def read(self, size=-1):
        self.reads += 1
        return super().read(size)


@pytest.mark.parametrize("filler", [b"#" + b"x" * 1_000_000 + b"\n", b"#\n" * 500_000, b" " * 1_000_000])
@pytest.mark.parametrize("magic", [b"P5", b"P2"])
def test_a_pgm_with_a_header_of_a_megabyte_is_refused(tmp_path, filler, magic):
    image = magic + b"\n" + filler + b"\n4 3\n255\n" + b"1 " * 12
    error = refused(folder_with(tmp_path, image=image))
    assert (type(error), error.code) == (LimitError, "map.image_header")
    assert "'m.pgm' has a header of more than 131072 bytes" in error.message
    file = _Counted(image)
    with pytest.raises(LimitError):
        open_plain_image(file, "It")
    assert file.reads == 1
    long = magic + b"\n#" + b"x" * 10_000 + b"\n4 3\n255\n" + b"1 " * 12
    assert load_map(folder_with(tmp_path, image=long)).grid.geometry.shape == (3, 4)


def test_comments_of_a_text_pgm_are_removed_before_pillow_reads_it(monkeypatch):
    """Pillow copies a block of up to 1 MB for each: half a million of them took it half a minute."""
    few = b"P2 # a\n4 #b\n 3\n255\n0 1# c\r 2 3 # 9 9\n\n 4 5 6 7 8 9 10 11 # end"
    pixels = np.asarray(Image.open(io.BytesIO(few)))
    assert pixels.tolist() == np.arange(12).reshape(3, 4).tolist()
    comments = b"#" + b"y" * 1_500_000 + b"\n" + b"# x\n" * 300_000
    many = few.replace(b"4 5", b"4 " + comments + b" 5")
    blocks: list[bytes] = []

    def seen(_: object, block: bytes) -> bytes:
        blocks.append(block)
        return block

    monkeypatch.setattr(PpmImagePlugin.PpmPlainDecoder, "_ignore_comments", seen)
    with open_plain_image(io.BytesIO(many), "It") as image:
        assert np.asarray(image).tolist() == pixels.tolist()
    assert blocks
    assert not any(b"#" in block for block in blocks)
