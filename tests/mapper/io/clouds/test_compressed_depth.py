"""Compressed depth images in recordings: each coder against the images that were put in, and damage."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from mapper.core.errors import ReadError
from mapper.io.clouds import open_posed_clouds
from mapper.io.logs.ros.cloud_messages import DepthImage, NotDepthError
from mapper.io.logs.ros.compressed_depth import compressed_depth_image
from mapper.io.logs.ros.message_fields import BadMessageError
from tests.hostile.damage import ROUNDS, flipped
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, Said, camera, image, serialised, transform, written

T0 = 1000 * SECOND
TOPIC = "/camera/depth/image_raw"
NO_HEADER = struct.pack("<i2f", 0, 0.0, 0.0)


def png(pixels: np.ndarray[Any, Any]) -> bytes:
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "PNG")
    return out.getvalue()


def rvl(pixels: np.ndarray[Any, Any]) -> bytes:
    """The coder of Wilson's paper, nibble by nibble."""
    nibbles: list[int] = []

    def number(value: int) -> None:
        while True:
            value, low = value >> 3, value & 7
            nibbles.append(low | (8 if value else 0))
            if not value:
                return

    flat, at, before = pixels.reshape(-1).tolist(), 0, 0
    while at < len(flat):
        zeros = next((k for k, v in enumerate(flat[at:]) if v), len(flat) - at)
        at += zeros
        there = next((k for k, v in enumerate(flat[at:]) if not v), len(flat) - at)
        number(zeros)
        number(there)
        for value in flat[at : at + there]:
            number(2 * (value - before) if value >= before else -2 * (value - before) - 1)
            before = value
        at += there
    nibbles += [0] * (-len(nibbles) % 8)
    words = [sum(n << (28 - 4 * k) for k, n in enumerate(nibbles[i : i + 8])) for i in range(0, len(nibbles), 8)]
    return struct.pack(f"<2I{len(words)}I", *pixels.shape[::-1], *words)


def compressed(stamp_ns: int, form: str, data: bytes, topic: str = f"{TOPIC}/compressedDepth") -> Said:
    fields = {
        "header": recorded.header(stamp_ns, "optical"),
        "format": form,
        "data": np.frombuffer(data, dtype=np.uint8),
    }
    return Said(topic, "sensor_msgs/msg/CompressedImage", stamp_ns, fields)


def decoded(form: str, data: bytes, ros: int = 2) -> DepthImage:
    return compressed_depth_image(serialised(compressed(T0, form, data), ros), cdr=ros == 2)


@pytest.fixture(scope="module")
def room(data_file: Callable[[str], Path]) -> np.ndarray[Any, Any]:
    """A part of a real depth image (120, 160), millimetres, with places without depth."""
    whole = np.asarray(Image.open(data_file("depth/frame-000000.depth.png"))).astype(np.uint16)
    return np.where(whole == 65535, 0, whole)[::4, ::4]


@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize(
    ("form", "coder"),
    [
        ("16UC1; compressedDepth png", lambda p: NO_HEADER + png(p)),
        ("16UC1; compressedDepth", lambda p: NO_HEADER + png(p)),
        ("16UC1; compressedDepth rvl", lambda p: NO_HEADER + rvl(p)),
        ("16UC1; png compressed ", png),
    ],
)
def test_millimetres_come_back_as_they_were(
    form: str, coder: Callable[[Any], bytes], ros: int, room: np.ndarray[Any, Any]
) -> None:
    assert 0.01 < (room == 0).mean() < 0.9
    found = decoded(form, coder(room), ros)
    assert (found.stamp_ns, found.frame) == (T0, "optical")
    np.testing.assert_array_equal(found.raw, room)
    np.testing.assert_allclose(found.metres(), room * 0.001, rtol=1e-6)


@pytest.mark.parametrize(("coder", "pack"), [("png", png), ("rvl", rvl)])
def test_metres_are_quantised_as_the_transport_does_it(
    coder: str, pack: Callable[[Any], bytes], room: np.ndarray[Any, Any]
) -> None:
    """Inverse depth with depth_quantization 100 and depth_max 10, its defaults."""
    true = np.where(room == 0, np.nan, room * 0.001)
    a = 100.0 * 101.0
    b = 1.0 - a / 10.0
    coded = np.where(np.isnan(true), 0, np.nan_to_num(a / true + b)).astype(np.uint16)
    found = decoded(f"32FC1; compressedDepth {coder}", struct.pack("<i2f", 0, a, b) + pack(coded)).metres()
    np.testing.assert_array_equal(np.isnan(found), np.isnan(true))
    near = np.nanmax(np.abs(found - true) / true**2)
    assert near < 1.01 / a  # one step of 1 / depth


def test_compressed_images_of_a_recording_are_the_clouds_of_the_plain_ones(
    room: np.ndarray[Any, Any], tmp_path: Path
) -> None:
    said = [transform(T0, "odom", "optical"), transform(T0 + SECOND, "odom", "optical", 1.0)]
    said.append(camera(T0, (room.shape[1], room.shape[0]), 146.0))
    jpeg = compressed(T0, "rgb8; jpeg compressed bgr8", b"\xff\xd8", f"{TOPIC}/compressed")
    packed = [compressed(T0, "16UC1; compressedDepth png", NO_HEADER + png(room))]
    clouds = []
    for name, images in (("plain", [image(T0, room)]), ("packed", [jpeg, *packed])):
        (tmp_path / name).mkdir()
        clouds.append(list(open_posed_clouds(written(tmp_path / name, [*said, *images], "mcap"))))
    (plain,), (unpacked,) = clouds
    np.testing.assert_array_equal(unpacked.cloud.points, plain.cloud.points)
    assert unpacked.cloud.finite.any()
    colours = written(tmp_path, [*said, jpeg], "bag")
    with pytest.raises(ReadError, match="hold no depths: their encoding is 'rgb8; jpeg compressed bgr8'"):
        list(open_posed_clouds(colours))


@pytest.mark.parametrize(
    ("form", "data", "why"),
    [
        ("16UC1; compressedDepth png", b"short", "too few"),
        ("16UC1; compressedDepth png", NO_HEADER + b"\x89PNG", "PNG is damaged"),
        ("16UC1; compressedDepth png", NO_HEADER + png(np.zeros((2, 2), np.uint8)), "not grey with 16 bits"),
        ("16UC1; compressedDepth zstd", NO_HEADER, "'zstd' are not read"),
        ("16UC1; compressedDepth rvl", NO_HEADER + struct.pack("<2I", 2**31, 2**31), "2147483648 × 2147483648 pixels"),
        ("16UC1; compressedDepth rvl", NO_HEADER + struct.pack("<3I", 64, 64, 2**32 - 1), "RVL is damaged"),
        ("16UC1; compressedDepth rvl", NO_HEADER + struct.pack("<3I", 64, 64, 0), "RVL ends early"),
        ("16UC1; compressedDepth rvl", NO_HEADER, "RVL ends early"),
    ],
)
def test_bad_images_say_why(form: str, data: bytes, why: str) -> None:
    with pytest.raises(BadMessageError, match=why):
        decoded(form, data)


@pytest.mark.sampled
def test_damaged_images_are_read_or_refused(room: np.ndarray[Any, Any]) -> None:
    rng = np.random.default_rng(5)
    small = np.ascontiguousarray(room[40:60, 40:70])
    for form, data in (
        ("16UC1; compressedDepth png", NO_HEADER + png(small)),
        ("16UC1; compressedDepth rvl", NO_HEADER + rvl(small)),
    ):
        for k in range(ROUNDS):
            damaged = flipped(rng, data) if k % 2 else data[: int(rng.integers(0, len(data)))]
            try:
                assert decoded(form, damaged).metres().ndim == 2
            except (BadMessageError, NotDepthError):
                continue


def test_a_recording_without_one_good_image_says_why(tmp_path: Path) -> None:
    said = [transform(T0, "odom", "optical"), camera(T0, (4, 4), 5.0)]
    said.append(compressed(T0, "16UC1; compressedDepth zstd", NO_HEADER))
    with pytest.raises(
        ReadError, match="No image on /camera/depth/image_raw/compressedDepth can be read: depth images"
    ):
        list(open_posed_clouds(written(tmp_path, said, "mcap")))
