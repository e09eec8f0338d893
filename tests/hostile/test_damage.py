"""Flipped bits, errors in lines, and wrong lengths: something usable, or one of our own errors."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from mapper.sensors.scan import ScanLog
from tests.hostile import lengths
from tests.hostile.corpus import (
    BAGS,
    CLOUDS,
    MCAPS,
    PACKINGS,
    RECORDINGS,
    SONAR_POSES,
    SONAR_READINGS,
    TEXTS,
    recording,
    said,
)
from tests.hostile.damage import ALL, ROUNDS, flipped, mangled, opened, opened_from
from tests.mapper.io.logs import recorded
from tests.marks import also_long

pytestmark = pytest.mark.sampled

SEPARATORS = {"csv": ","}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "damaged.log"


def seeded(name: str) -> np.random.Generator:
    return np.random.default_rng(list(name.encode()))


@pytest.mark.parametrize("kind", RECORDINGS)
def test_flipped_bits_in_a_recording(path, kind):
    data = recording(kind)
    family = [one for one in RECORDINGS if one[:3] == kind[:3]]
    rng = seeded(kind)
    logs = sum(isinstance(opened(path, flipped(rng, data)), ScanLog) for _ in range(-(-ROUNDS // len(family))))
    assert logs > 0


@pytest.mark.parametrize("kind", TEXTS)
def test_flipped_bits_in_a_text(path, kind):
    data = TEXTS[kind].encode()
    rng = seeded(kind)
    logs = sum(isinstance(opened(path, flipped(rng, data)), ScanLog) for _ in range(ROUNDS))
    assert 0 < logs < ROUNDS


@pytest.mark.parametrize("kind", TEXTS)
def test_mistakes_in_the_lines_of_a_text(path, kind):
    rng = seeded(kind)
    files = (mangled(rng, TEXTS[kind], SEPARATORS.get(kind, " ")) for _ in range(ROUNDS))
    logs = sum(isinstance(opened(path, data), ScanLog) for data in files)
    assert 0 < logs < ROUNDS


@pytest.mark.parametrize("which", ["measurement.txt", "poses.txt"])
def test_a_damaged_file_of_a_sonar_ring(tmp_path, which):
    texts = {"measurement.txt": SONAR_READINGS, "poses.txt": SONAR_POSES}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    rng = seeded(which)
    logs = 0
    for i in range(ROUNDS):
        text = texts[which]
        (tmp_path / which).write_bytes(mangled(rng, text) if i % 2 else flipped(rng, text.encode()))
        logs += isinstance(opened_from(tmp_path), ScanLog)
    assert 0 < logs < ROUNDS


@pytest.mark.parametrize("kind", [*TEXTS, "bag-none", "mcap-none", "db3"])
@pytest.mark.parametrize("packing", PACKINGS)
def test_flipped_bits_in_packed_data(path, kind, packing):
    data = PACKINGS[packing](recording(kind) if kind in RECORDINGS else TEXTS[kind].encode())
    rng = seeded(f"{packing} of {kind}")
    for _ in range(ROUNDS if ALL else ROUNDS // 5):
        opened(path, flipped(rng, data))


def test_a_wrong_value_in_every_length_of_a_bag(path):
    data = recorded.write_bag(path, said(1)).read_bytes()
    places = list(lengths.in_bag(data))
    assert len(places) > 100
    for at, size in places[:: 1 if ALL else 4]:
        for lie in lengths.lies(size):
            opened(path, data[:at] + lie + data[at + size :])


@pytest.mark.parametrize("chunks", [True, *also_long(False)])
def test_a_wrong_value_in_every_length_of_an_mcap(path, chunks):
    # Without checksums, which would tell of the lie before it is met.
    data = recorded.mcap_bytes(said(1), "none", use_chunking=chunks, enable_crcs=False)
    places = list(lengths.in_mcap(data))
    assert len(places) > 80
    for at, size in places[:: 1 if ALL else 4]:
        for lie in lengths.lies(size):
            opened(path, data[:at] + lie + data[at + size :])


def test_a_wrong_value_at_every_offset_of_the_messages_in_a_db3(path):
    """A length stands at a place that is a multiple of four from the message's begin: at some, that is all of them."""
    messages = said(1)
    data = recording("db3")
    for message in messages:
        content = recorded.serialised(message, 2)
        start = data.index(content)
        for at in range(start, start + min(len(content), 160), 4 if ALL else 28):
            for lie in lengths.lies(4) if ALL else lengths.lies(4)[:2]:
                opened(path, data[:at] + lie + data[at + 4 :])


@pytest.mark.parametrize("kind", [*BAGS, *MCAPS, "db3", *CLOUDS])
def test_a_length_of_four_billion_anywhere(path, kind):
    data = recording(kind)
    for at in range(0, len(data) - 4, 1 if ALL else len(data) // 20):
        opened(path, data[:at] + b"\xff\xff\xff\xff" + data[at + 4 :])


ODD = [
    *(struct.pack("<f", value) for value in (np.nan, np.inf, -np.inf, 3e38, 1e-40, 0.0, -0.0, -1.0, 1e5, 99.0, 6.3)),
    *(struct.pack("<d", value) for value in (np.nan, np.inf, -np.inf, 1e308, 1e-310, 0.0, -0.0, -1.0, 1e6, 9.99e5)),
]


def test_odd_numbers_anywhere_in_the_messages(path):
    """Well-formed messages of what no sensor measures: nan, infinities, numbers whose sum overflows."""
    rng = seeded("odd")
    messages = said(3)
    data = recorded.mcap_bytes(messages, "none", use_chunking=False, enable_crcs=False)
    places = [(data.index(content), len(content)) for content in (recorded.serialised(one, 2) for one in messages)]
    for _ in range(ROUNDS):
        odd = bytearray(data)
        for _ in range(int(rng.integers(1, 4))):
            start, size = places[int(rng.integers(0, len(places)))]
            number = ODD[int(rng.integers(0, len(ODD)))]
            at = start + 4 + len(number) * int(rng.integers(0, (size - 4) // len(number)))
            odd[at : at + len(number)] = number
        opened(path, bytes(odd))
