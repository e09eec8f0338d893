"""Logs in tar archives that are packed with gzip or Zstandard, against the same logs outside of them."""

from __future__ import annotations

import gzip
import io
import random
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import zstandard

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.contents.seeking import message_at
from mapper.io.logs import is_log, open_log
from mapper.io.logs.archives.archive import HEAD_BYTES
from mapper.io.logs.archives.packed_archive import MOST_PACKED_FILES, _UnpackedFile, unpacked_file
from mapper.sensors.scan import ScanLog
from tests.hostile.archives import tarred
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.logs import recorded
from tests.server.library.small_logs import carmen

PACKING = {"gzip": gzip.compress, "zstd": zstandard.ZstdCompressor().compress}


@pytest.mark.parametrize("packing", PACKING)
def test_the_recording_beside_other_files(tmp_path: Path, packing: str) -> None:
    recording = recorded.mcap_bytes(robot())
    (tmp_path / "run.mcap").write_bytes(recording)
    path = tmp_path / "run.tar.packed"
    path.write_bytes(PACKING[packing](tarred({"run/notes.md": b"on Monday\n", "run/run.mcap": recording})))
    assert is_log(path)
    log, alone = open_log(path), open_log(tmp_path / "run.mcap")
    np.testing.assert_array_equal(log.ranges, alone.ranges)
    assert (list(log.trajectories), log.topics, log.notes) == (list(alone.trajectories), alone.topics, alone.notes)
    at_ns = T0 + 2 * recorded.SECOND
    assert message_at(path, "/odom", at_ns) == message_at(tmp_path / "run.mcap", "/odom", at_ns)


def test_a_packed_text_log_and_a_bag_in_a_packed_archive(tmp_path: Path) -> None:
    bag = recorded.write_bag(tmp_path / "run.bag", list(robot())).read_bytes()
    for name, data, scans in (("a.log.gz", gzip.compress(carmen(5)), 5), ("run.bag", bag, 40)):
        (tmp_path / "a.tgz").write_bytes(gzip.compress(tarred({name: data})))
        assert open_log(tmp_path / "a.tgz").n_scans == scans


def test_what_holds_no_log_or_several_or_too_many_files_is_refused_in_words(tmp_path: Path) -> None:
    path = tmp_path / "a.tgz"
    for files, words in (
        ({"a.txt": b"hello\n"}, "of no known kind: it starts with 'hello'"),
        ({"a/run.log": carmen(3), "b/run.log": carmen(3)}, "holds 2 recordings, in different folders"),
        ({"in.tar": tarred({"a.log": carmen(3)})}, "a tar archive: unpack it"),
    ):
        path.write_bytes(gzip.compress(tarred(files)))
        with pytest.raises(ReadError, match=words):
            open_log(path)
    path.write_bytes(gzip.compress(tarred({f"{i}.txt": b"" for i in range(MOST_PACKED_FILES + 1)})))
    with pytest.raises(LimitError, match=f"more than {MOST_PACKED_FILES} files.*: unpack it"):
        open_log(path)


def test_an_archive_of_many_files_is_not_unpacked_once_for_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, begun = tmp_path / "a.tgz", []
    notes = {f"{i}.txt": b"hello\n" * 100 for i in range(MOST_PACKED_FILES - 2)}
    long = gzip.compress(random.Random(4).randbytes(HEAD_BYTES) + b"no log\n")  # of which a part is kept
    path.write_bytes(gzip.compress(tarred({**notes, "long.gz": long, "a.log": carmen(5)})))
    begin = _UnpackedFile._begin

    def counted(file: _UnpackedFile) -> None:
        begun.append(file)
        begin(file)

    monkeypatch.setattr(_UnpackedFile, "_begin", counted)
    assert open_log(path).n_scans == 5
    assert len(begun) < 8


def test_of_an_archive_that_ends_early_what_came_out_is_read_with_a_note(tmp_path: Path) -> None:
    text = carmen(1000)
    whole = gzip.compress(tarred({"a.log": text}))
    path = tmp_path / "a.tgz"
    path.write_bytes(whole[: len(whole) // 2])
    log = open_log(path)
    assert 100 < log.n_scans < 1000
    assert any("ends early" in note for note in log.notes)
    for size in range(0, len(whole), max(1, len(whole) // 12)):
        path.write_bytes(whole[:size])
        try:
            assert isinstance(open_log(path), ScanLog)
        except MapperError as error:
            assert error.message.endswith(".")  # noqa: PT017 - either is right


def test_any_place_of_the_unpacked_file_as_of_its_bytes(tmp_path: Path) -> None:
    chance = random.Random(3)
    data = chance.randbytes(700_000)
    (tmp_path / "a.gz").write_bytes(gzip.compress(data))
    expected = io.BytesIO(data)
    with unpacked_file(tmp_path / "a.gz", DEFAULT_LIMITS) as file:
        for _ in range(60):
            offset, whence = chance.choice([(chance.randrange(900_000), 0), (-chance.randrange(700_000), 2)])
            assert file.seek(offset, whence) == expected.seek(offset, whence)
            size = chance.randrange(1 << 19)
            assert file.read(size) == expected.read(size)


def test_memory_does_not_grow_with_what_is_unpacked(tmp_path: Path) -> None:
    (tmp_path / "a.gz").write_bytes(gzip.compress(bytes(100_000_000), 1))
    tracemalloc.start()
    try:
        with unpacked_file(tmp_path / "a.gz", DEFAULT_LIMITS) as file:
            assert file.seek(0, io.SEEK_END) == 100_000_000
            file.seek(50_000_000)
            assert file.read(3) == bytes(3)
        assert tracemalloc.get_traced_memory()[1] < 4_000_000
    finally:
        tracemalloc.stop()
