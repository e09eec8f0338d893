"""Damaged recordings looked into: something usable, or one of our own errors; never another exception."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import MapperError
from mapper.core.limits import Limits
from mapper.io.contents.inspection import inspect
from mapper.io.contents.model import Contents
from mapper.io.contents.pictures import picture_of
from mapper.io.contents.seeking import FoundMessage, message_at
from tests.hostile.damage import ROUNDS, flipped
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import serialised

pytestmark = pytest.mark.sampled

FEWER = -(-ROUNDS // 5)  #: damaged recordings of each kind
LIMITS = Limits(max_chunk_bytes=1 << 22, max_messages=100_000)
CAMERA = image(np.arange(48, dtype=np.uint8).reshape(4, 12), "rgb8", T0 + 1, width=4)


def seeded(name: str) -> np.random.Generator:
    return np.random.default_rng(list(name.encode()))


def looked_into(path: Path) -> Contents | MapperError:
    try:
        return inspect(path, limits=LIMITS)
    except MapperError as error:
        return error


def sought(path: Path) -> FoundMessage | MapperError:
    try:
        return message_at(path, "/camera", T0 + 2, LIMITS)
    except MapperError as error:
        return error


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_flipped_bits_in_a_recording(tmp_path: Path, kind: str) -> None:
    data = recorded.written(tmp_path, [*robot(1), CAMERA], kind).read_bytes()
    path = tmp_path / "damaged"
    rng = seeded(kind)
    contents = found = 0
    for _ in range(FEWER):
        path.write_bytes(flipped(rng, data))
        contents += isinstance(looked_into(path), Contents)
        found += isinstance(sought(path), FoundMessage)
    assert contents > 0
    assert found > 0


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_recordings_that_end_early(tmp_path: Path, kind: str) -> None:
    data = recorded.written(tmp_path, [*robot(1), CAMERA], kind).read_bytes()
    path = tmp_path / "cut"
    contents = 0
    for end in range(0, len(data), max(1, len(data) // FEWER)):
        path.write_bytes(data[:end])
        contents += isinstance(looked_into(path), Contents)
        sought(path)
    assert contents > 0


def test_flipped_bits_in_an_image() -> None:
    data = serialised(CAMERA, 2)
    rng = seeded("image")
    pictures = 0
    for _ in range(ROUNDS):
        try:
            picture, _ = picture_of("sensor_msgs/Image", flipped(rng, data), cdr=True)
        except MapperError:
            continue
        pictures += picture.startswith(b"\xff\xd8")
    assert pictures > 0
