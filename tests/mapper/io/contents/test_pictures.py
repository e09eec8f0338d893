"""Pictures of images and clouds: colours and sizes against what was put in; absurd sizes refused in one sentence."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.io.contents.model import PICTURED
from mapper.io.contents.pictures import _DRAWN, picture_of
from mapper.io.contents.seeking import message_at
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, Said, serialised

T0 = 1_700_000_000 * SECOND
ORANGE = (230, 120, 20)


def image(pixels: np.ndarray[Any, Any], encoding: str, stamp_ns: int = T0, **changes: int) -> Said:
    """A sensor_msgs/Image with its rows as they are, or with other claims about its size."""
    fields = {
        "header": recorded.header(stamp_ns, "camera"),
        "height": pixels.shape[0],
        "width": pixels.shape[1],
        "encoding": encoding,
        "is_bigendian": 0,
        "step": pixels.strides[0],
        "data": np.frombuffer(pixels.tobytes(), dtype=np.uint8),
    }
    return Said("/camera", "sensor_msgs/msg/Image", stamp_ns, fields | changes)


def compressed(data: bytes, stamp_ns: int = T0) -> Said:
    fields = {
        "header": recorded.header(stamp_ns, "camera"),
        "format": "jpeg",
        "data": np.frombuffer(data, dtype=np.uint8),
    }
    return Said("/camera", "sensor_msgs/msg/CompressedImage", stamp_ns, fields)


def shown(said: Said, ros: int = 2) -> np.ndarray[Any, Any]:
    data, media = picture_of(said.kind.replace("/msg/", "/"), serialised(said, ros), cdr=ros == 2)
    picture = Image.open(io.BytesIO(data))
    assert media == f"image/{str(picture.format).lower()}"
    return np.asarray(picture).astype(int)


def filled(colour: tuple[int, ...], rows: int = 24, cols: int = 32) -> np.ndarray[Any, Any]:
    return np.full((rows, cols, len(colour)), colour, dtype=np.uint8)


@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize(
    ("encoding", "stored"),
    [("rgb8", ORANGE), ("bgr8", ORANGE[::-1]), ("rgba8", (*ORANGE, 255)), ("bgra8", (*ORANGE[::-1], 255))],
)
def test_colours_in_every_order(encoding: str, stored: tuple[int, ...], ros: int) -> None:
    picture = shown(image(filled(stored), encoding), ros)
    assert picture.shape == (24, 32, 3)
    np.testing.assert_allclose(picture.reshape(-1, 3).mean(axis=0), ORANGE, atol=4)


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_bayer_patterns(pattern: str) -> None:
    colour = dict(zip("rgb", ORANGE, strict=True))
    tile = np.array([colour[c] for c in pattern], dtype=np.uint8).reshape(2, 2)
    picture = shown(image(np.tile(tile, (16, 16)), f"bayer_{pattern}8"))
    np.testing.assert_allclose(picture.reshape(-1, 3).mean(axis=0), ORANGE, atol=4)


def test_depth_is_shades_of_grey_and_large_images_are_made_small() -> None:
    ramp = np.tile(np.linspace(1000, 5000, 2000, dtype=np.uint16), (500, 1))
    picture = shown(image(ramp, "16UC1"))
    assert picture.shape == (160, 640)
    np.testing.assert_allclose(picture[80, [10, 320, 630]], [4, 128, 251], atol=8)


@pytest.mark.parametrize("form", ["JPEG", "PNG"])
def test_compressed_images(form: str) -> None:
    out = io.BytesIO()
    Image.fromarray(filled(ORANGE, 900, 1200)).save(out, form)
    picture = shown(compressed(out.getvalue()))
    assert picture.shape == (480, 640, 3)
    np.testing.assert_allclose(picture.reshape(-1, 3).mean(axis=0), ORANGE, atol=4)


@pytest.mark.parametrize(
    ("said", "error", "words"),
    [
        (image(filled(ORANGE), "rgb8", width=40_000, height=25_000, step=120_000), LimitError, "40000 × 25000 pixels"),
        (image(filled(ORANGE), "rgb8", height=25), ReadError, "do not fit its 2304 bytes"),
        (image(filled(ORANGE), "rgb8", step=10), ReadError, "do not fit"),
        (image(filled(ORANGE), "rgb8", width=0), ReadError, "which cannot be a picture"),
        (image(filled(ORANGE), "jpeg2000"), ReadError, "'jpeg2000' are not shown"),
        (compressed(b"\xff\xd8\xff and no more"), ReadError, "not a JPEG or PNG"),
        (compressed(b"GIF89a"), ReadError, "not a JPEG or PNG"),
    ],
)
def test_what_is_absurd_or_damaged_is_one_sentence(said: Said, error: type[MapperError], words: str) -> None:
    with pytest.raises(error) as caught:
        shown(said)
    assert words in caught.value.message


def test_a_png_that_claims_a_billion_pixels_is_not_decoded() -> None:
    out = io.BytesIO()
    Image.new("1", (8, 8)).save(out, "PNG")
    data = bytearray(out.getvalue())
    data[16:24] = (40_000).to_bytes(4, "big") + (30_000).to_bytes(4, "big")
    with pytest.raises(MapperError):
        shown(compressed(bytes(data)))


def test_every_type_has_its_drawing() -> None:
    assert set(_DRAWN) == PICTURED


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_the_newest_message_at_a_moment(tmp_path: Path, kind: str) -> None:
    said = [image(filled((n, 0, 0), 4, 4), "rgb8", T0 + n * SECOND) for n in range(1, 6)]
    said.insert(3, recorded.scan(T0 + 3 * SECOND, [1.0, 2.0]))
    path = recorded.written(tmp_path, said, kind)
    ros = 1 if kind == "bag" else 2
    for after_s, expected in ((0.5, 1), (1.0, 1), (3.7, 3), (5.0, 5), (99.0, 5)):
        found = message_at(path, "/camera", T0 + int(after_s * SECOND))
        assert (found.stamp_ns, found.type) == (T0 + expected * SECOND, "sensor_msgs/Image")
        assert found.data == serialised(image(filled((expected, 0, 0), 4, 4), "rgb8", T0 + expected * SECOND), ros)
    with pytest.raises(ReadError, match="no messages on '/nothing'"):
        message_at(path, "/nothing", T0)
