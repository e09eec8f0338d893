"""Files truncated at every byte: complete parts are read and marked, or the file is refused with one sentence."""

from __future__ import annotations

import contextlib
import gzip
from pathlib import Path

import numpy as np
import pytest
import zstandard

from mapper.core.errors import ReadError
from mapper.io.logs import open_log
from mapper.sensors.scan import ScanLog
from tests.hostile.corpus import (
    BAGS,
    CLOUDS,
    MCAPS,
    PACKINGS,
    SONAR_POSES,
    SONAR_READINGS,
    T0,
    TEXTS,
    recording,
)
from tests.hostile.damage import ALL, opened, opened_from
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import scan

pytestmark = pytest.mark.sampled


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "cut.log"


def damages(log: ScanLog) -> list[str]:
    """The log's notes without the one on the sensor that is mapped."""
    return [note for note in log.notes if not note.startswith(("Only /scan is mapped", "Only /points is mapped"))]


def test_the_files_of_the_corpus_are_read(path):
    for data in (*map(str.encode, TEXTS.values()), *map(recording, (*BAGS, *MCAPS, "db3", *CLOUDS))):
        log = opened(path, data)
        assert isinstance(log, ScanLog)
        assert log.n_scans >= 5
        assert not [note for note in log.notes if any(word in note for word in ("end", "damaged", "decoded"))]


@pytest.mark.parametrize("kind", TEXTS)
def test_complete_lines_of_every_prefix_of_a_text_are_read(path, kind):
    data = TEXTS[kind].encode()
    whole = opened(path, data)
    assert isinstance(whole, ScanLog)
    sure = 0
    for n in range(0, len(data), 1 if ALL else 11):
        log = opened(path, data[:n])
        if not isinstance(log, ScanLog):
            assert sure == 0, f"{n} bytes give nothing, but fewer gave {sure} scans"
            continue
        ends = data[:n].endswith(b"\n")
        assert log.n_scans >= sure, "more bytes never give less"
        # Of a line that does not end the last numbers may be missing, or cut.
        sure = max(sure, log.n_scans - any("no line end" in note for note in log.notes))
        if sure:
            np.testing.assert_array_equal(log.ranges[:sure], whole.ranges[:sure])
            np.testing.assert_array_equal(log.stamps_ns[:sure], whole.stamps_ns[:sure])
        assert ends or any("end" in note for note in log.notes), f"{n} bytes are not marked as cut"
    assert sure >= whole.n_scans - 1


@pytest.mark.parametrize("which", ["measurement.txt", "poses.txt"])
def test_of_every_prefix_of_a_sonar_log(tmp_path, which):
    """A round of readings without a pose, or a pose without readings, is no whole log: it is refused."""
    texts = {"measurement.txt": SONAR_READINGS, "poses.txt": SONAR_POSES}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    assert isinstance(opened_from(tmp_path), ScanLog)
    data = texts[which].encode()
    for n in range(0, len(data), 1 if ALL else 3):
        (tmp_path / which).write_bytes(data[:n])
        log = opened_from(tmp_path)
        if isinstance(log, ScanLog):
            assert log.n_scans == 5
            assert any("no line end" in note for note in log.notes)


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.parametrize("packing", PACKINGS)
def test_of_every_prefix_of_a_packed_text(path, kind, packing):
    data = PACKINGS[packing](TEXTS[kind].encode())
    whole = opened(path, data)
    assert isinstance(whole, ScanLog)
    for n in range(0, len(data), 1 if ALL else 3):
        log = opened(path, data[:n])
        if isinstance(log, ScanLog):
            assert any("data ends early" in note for note in log.notes)
            np.testing.assert_array_equal(log.ranges, whole.ranges[: log.n_scans])
        elif n > 20:  # headers, and a zstd block that has not ended, give nothing
            assert "ends early" in log.message or "damaged" in log.message, (n, log)


@pytest.mark.parametrize("kind", [*BAGS, *MCAPS, *CLOUDS])
def test_complete_messages_of_every_prefix_of_a_recording_are_read(path, kind):
    data = recording(kind)
    whole = opened(path, data)
    assert isinstance(whole, ScanLog)
    assert damages(whole) == []
    scans = 0
    for n in range(0, len(data), 1 if ALL else 397):
        log = opened(path, data[:n])
        if not isinstance(log, ScanLog):
            assert isinstance(log, ReadError)
            assert scans == 0, f"{n} bytes give nothing, but fewer gave {scans} scans"
            continue
        assert log.n_scans >= scans, "more bytes never give less"
        scans = log.n_scans
        np.testing.assert_array_equal(log.ranges, whole.ranges[:scans])
        # After the last message there is only the index, which nobody misses.
        assert damages(log) or scans == whole.n_scans, f"{n} bytes are not marked as cut"
    assert scans == whole.n_scans


def test_complete_messages_of_every_prefix_of_a_db3_are_read(path):
    data = recording("db3")
    whole = opened(path, data)
    assert isinstance(whole, ScanLog)
    salvaged = 0
    for n in range(0, len(data), 1 if ALL else 907):
        log = opened(path, data[:n])
        if not isinstance(log, ScanLog):
            continue
        assert any("ends early" in note or "damaged" in note for note in log.notes)
        with contextlib.suppress(ReadError):  # SQLite may lose rows in the middle: of a sensor, perhaps all
            scans = open_log(path, topic="/scan")
            assert scans.n_scans <= whole.n_scans
            np.testing.assert_array_equal(scans.ranges, whole.ranges[: scans.n_scans])
            salvaged = max(salvaged, scans.n_scans)
    assert salvaged > 0


@pytest.mark.parametrize("pack", [gzip.compress, zstandard.compress], ids=["gzip", "zstd"])
@pytest.mark.parametrize("kind", ["bag-none", "mcap-none"])
def test_a_truncated_compressed_recording_is_read_up_to_the_cut(path, kind, pack):
    # Noise does not compress, so that a cut leaves some of it.
    noise = np.random.default_rng(1).uniform(1, 9, (4000, 50))
    messages = [scan(T0 + i, row) for i, row in enumerate(noise)]
    plain = (
        recorded.write_bag(path, messages).read_bytes()
        if kind == "bag-none"
        else recorded.mcap_bytes(messages, "none", chunk_size=3000)
    )
    packed = pack(plain)
    log = opened(path, packed[: len(packed) // 2])
    assert isinstance(log, ScanLog)
    assert 500 < log.n_scans < 3500
    assert any("ends early" in note for note in log.notes)
