"""Compressed chunks, messages and files, folders and archives: the ways in which one recording is stored."""

from __future__ import annotations

import gzip
import shutil
import sqlite3
import tarfile
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import zstandard
from rosbags.rosbag2 import StoragePlugin

from mapper.core.errors import ReadError
from mapper.io.clouds import open_clouds
from mapper.io.contents.message_tree import raw_message
from mapper.io.logs import is_log, log_files, open_log
from mapper.io.logs.containers.kept_copies import KeptCopies
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.driven_robot import run
from tests.mapper.io.logs.recorded import KINDS, written


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_compressed_chunks_of_a_bag(tmp_path, compression):
    plain = open_log(written(tmp_path, run(), "bag"))
    log = open_log(recorded.write_bag(tmp_path / "packed.bag", run(), compression))
    np.testing.assert_array_equal(log.ranges, plain.ranges)
    assert log.notes == plain.notes == ()


@pytest.mark.parametrize("compression", ["none", "lz4", "zstd"])
@pytest.mark.parametrize("options", [{}, {"use_chunking": False}, {"enable_data_crcs": True}, {"chunk_size": 300}])
@pytest.mark.parametrize("ros", [1, 2])
def test_kinds_of_mcap(tmp_path, compression, options, ros):
    path = tmp_path / "a.mcap"
    path.write_bytes(recorded.mcap_bytes(run(), compression, ros, **options))
    log = open_log(path)
    assert (log.n_scans, len(log.trajectories), log.notes) == (10, 4, ())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("pack", [gzip.compress, zstandard.compress], ids=["gzip", "zstd"])
def test_the_whole_file_compressed(tmp_path, kind, pack):
    path = written(tmp_path, run(), kind)
    packed = tmp_path / "picture.png"
    packed.write_bytes(pack(path.read_bytes()))
    assert is_log(packed)
    np.testing.assert_array_equal(open_log(packed).ranges, open_log(path).ranges)


@pytest.mark.parametrize(
    ("plugin", "suffix", "compression"),
    [
        (StoragePlugin.SQLITE3, "db3.zstd", "file"),
        (StoragePlugin.SQLITE3, "db3", "message"),
        (StoragePlugin.MCAP, "mcap", "none"),
        (StoragePlugin.MCAP, "mcap.zstd", "file"),
        (StoragePlugin.MCAP, "mcap", "message"),
        (StoragePlugin.MCAP, "mcap", "storage"),
    ],
)
def test_the_ways_in_which_rosbag2_compresses(tmp_path, plugin, suffix, compression):
    log = open_log(recorded.write_rosbag2(tmp_path / "run", run(), plugin, suffix, compression))
    plain = open_log(written(tmp_path, run(), "mcap"))
    np.testing.assert_array_equal(log.ranges, plain.ranges)
    assert list(log.trajectories) == list(plain.trajectories)
    assert log.notes == ()


@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_a_ros_2_bag_is_a_folder(tmp_path, kind):
    plugin = StoragePlugin.SQLITE3 if kind == "db3" else StoragePlugin.MCAP
    file = recorded.write_rosbag2(tmp_path / "run", run(), plugin, kind)
    assert is_log(tmp_path / "run")
    assert open_log(tmp_path / "run").n_scans == 10
    assert file.with_name("metadata.yaml").exists()


def test_a_db3_that_was_not_closed_notes_what_may_be_missing(tmp_path):
    """Of a database in WAL mode the last rows are in another file, which nobody thinks of."""
    path = written(tmp_path, run(), "db3")
    with closing(sqlite3.connect(path)) as recorder:
        recorder.execute("PRAGMA journal_mode=WAL")
        recorder.execute("PRAGMA wal_autocheckpoint=0")
        recorder.execute("INSERT INTO messages SELECT id + 1000, topic_id, timestamp, data FROM messages")
        recorder.commit()
        assert path.with_name(f"{path.name}-wal").stat().st_size > 0
        single_threaded = tmp_path / "alone.db3"
        for pack in (bytes, gzip.compress):
            single_threaded.write_bytes(pack(path.read_bytes()))
            log = open_log(single_threaded)
            assert log.n_scans == 10
            assert [note for note in log.notes if "ends in -wal, which is not read" in note] == list(log.notes)


def copied_with_its_journal(path: Path, folder: Path) -> Path:
    """Copy a database and the write-ahead log beside it, as a recorder that is killed leaves both."""
    folder.mkdir()
    for name in (path.name, f"{path.name}-wal"):
        (folder / name).write_bytes(path.with_name(name).read_bytes())
    return folder / path.name


def test_of_a_db3_that_was_not_closed_the_journal_beside_it_is_read_and_left_as_it_is(tmp_path):
    path = written(tmp_path, run(), "db3")
    with closing(sqlite3.connect(path)) as recorder:
        recorder.execute("PRAGMA journal_mode=WAL")
        recorder.execute("PRAGMA wal_autocheckpoint=0")
        recorder.execute("DELETE FROM messages WHERE id > (SELECT max(id) / 2 FROM messages)")
        recorder.commit()
        left = copied_with_its_journal(path, tmp_path / "left")
    before = {file.name: file.read_bytes() for file in left.parent.iterdir()}
    alone = tmp_path / "alone.db3"
    alone.write_bytes(left.read_bytes())
    assert open_log(alone).n_scans == 10
    for opened in (left, left.parent):
        log = open_log(opened)
        assert 0 < log.n_scans < 10
        assert [note for note in log.notes if "read from the file beside it (-wal)" in note] == list(log.notes)
    assert {file.name: file.read_bytes() for file in left.parent.iterdir()} == before


def test_a_db3_whose_messages_are_all_in_the_journal_beside_it_is_read(tmp_path):
    source = written(tmp_path, run(), "db3")
    with closing(sqlite3.connect(source)) as whole, closing(sqlite3.connect(tmp_path / "run.db3")) as recorder:
        recorder.execute("PRAGMA journal_mode=WAL")
        recorder.execute("PRAGMA wal_autocheckpoint=0")
        recorder.executescript("\n".join(whole.iterdump()))
        left = copied_with_its_journal(tmp_path / "run.db3", tmp_path / "left")
    np.testing.assert_array_equal(open_log(left).ranges, open_log(source).ranges)
    assert raw_message(left, "/scan", 0).tree == raw_message(source, "/scan", 0).tree


@pytest.mark.parametrize("packed", [False, True])
def test_the_journal_beside_a_db3_is_read_in_an_archive_too(tmp_path, packed, monkeypatch):
    """As the page and ``gridbloom upload`` send both; look-ups of messages share one copy."""
    source = written(tmp_path, run(), "db3")
    with closing(sqlite3.connect(source)) as whole, closing(sqlite3.connect(tmp_path / "run.db3")) as recorder:
        recorder.execute("PRAGMA journal_mode=WAL")
        recorder.execute("PRAGMA wal_autocheckpoint=0")
        recorder.executescript("\n".join(whole.iterdump()))
        left = copied_with_its_journal(tmp_path / "run.db3", tmp_path / "left")
    assert [file.name for file in log_files(left)] == [file.name for file in log_files(left.parent)]
    path = tmp_path / "left.tar"
    with tarfile.open(path, "w:gz" if packed else "w") as archive:
        for file in log_files(left):
            archive.add(file, file.name)
    log = open_log(path)
    assert [note for note in log.notes if "read from the file beside it (-wal)" in note] == list(log.notes)
    np.testing.assert_array_equal(log.ranges, open_log(source).ranges)
    copies: list[None] = []
    copyfileobj = shutil.copyfileobj
    monkeypatch.setattr("shutil.copyfileobj", lambda *files: copies.append(copyfileobj(*files)))
    for _ in range(3):
        assert raw_message(path, "/scan", 0).tree == raw_message(source, "/scan", 0).tree
    assert len(copies) == 2  # the database and its journal
    path.write_bytes(path.read_bytes() + bytes(512))  # another file
    assert raw_message(path, "/scan", 0).tree == raw_message(source, "/scan", 0).tree
    assert len(copies) == 4


def test_copies_for_look_ups_are_closed_where_they_are_too_large_together(tmp_path):
    kept = KeptCopies(most_bytes=100)
    made: list[sqlite3.Connection] = []
    files = [tmp_path / name for name in "abc"]

    def connected() -> tuple[sqlite3.Connection, int]:
        made.append(sqlite3.connect(":memory:"))
        return made[-1], 60

    for file in files:
        file.write_bytes(b"")
    for file, count in ((files[0], 1), (files[0], 1), (files[1], 2), (files[0], 3), (files[0], 3)):
        with kept.lent(file, connected) as connection:
            assert connection.execute("SELECT 1").fetchone() == (1,)
        assert len(made) == count
    with pytest.raises(sqlite3.ProgrammingError, match="closed"):
        made[1].execute("SELECT 1")
    with kept.lent(files[2], lambda: (connected()[0], 101)) as large:
        pass
    with pytest.raises(sqlite3.ProgrammingError, match="closed"):
        large.execute("SELECT 1")
    for one in made:
        one.close()


@pytest.mark.parametrize("journal", [b"no journal at all" * 100, b""])
def test_a_journal_beside_a_db3_that_is_none_takes_nothing_away(tmp_path, journal):
    path = written(tmp_path, run(), "db3")
    with closing(sqlite3.connect(path)) as recorder:
        recorder.execute("PRAGMA journal_mode=WAL")
    path.with_name(f"{path.name}-wal").write_bytes(journal)
    assert open_log(path).n_scans == 10


@pytest.mark.parametrize("kept", [4, 500])
def test_an_mcap_file_that_ends_within_its_one_chunk_says_so(tmp_path, kept):
    """One block of Zstandard, which gives nothing before its end."""
    data = recorded.mcap_bytes(run(), "zstd", chunk_size=1 << 24)
    path = tmp_path / "a.mcap"
    path.write_bytes(data[: data.index(b"\x28\xb5\x2f\xfd") + kept])
    with pytest.raises(ReadError, match=r"ends within the chunk at byte \d+, whose zstd data cannot be unpacked"):
        open_log(path)


@pytest.mark.parametrize("has_clouds", [True, False])
def test_a_db3_with_a_journal_is_read_for_what_it_holds_beside_scans(tmp_path, has_clouds):
    """rosbag2's resilient preset writes all files so; a reader of clouds takes no scan."""
    points = recorded.cloud(run()[0].stamp_ns, np.array([[1.0, 0.0, 0.5]]))
    path = written(tmp_path, [*run(), points] if has_clouds else run(), "db3")
    with closing(sqlite3.connect(path)) as recorder:
        recorder.execute("PRAGMA journal_mode=WAL")
    if not has_clouds:
        with pytest.raises(ReadError, match="holds no point clouds") as caught:
            open_clouds(path)
        assert "-wal" not in caught.value.message
    else:
        assert len(list(open_clouds(path)["/points"])) == 1


def test_a_database_that_cannot_be_opened_is_closed(tmp_path, monkeypatch):
    path = written(tmp_path, run(), "db3")
    data = bytearray(path.read_bytes())
    data[19] = 9  # a version of the file that SQLite does not read
    path.write_bytes(data)
    made: list[sqlite3.Connection] = []
    connect = sqlite3.connect

    def noted(*given, **options):
        made.append(connect(*given, **options))
        return made[-1]

    monkeypatch.setattr(sqlite3, "connect", noted)
    with pytest.raises(ReadError):
        open_log(path)
    assert made
    for one in made:
        with pytest.raises(sqlite3.ProgrammingError, match="closed"):
            one.execute("SELECT 1")


def test_a_db3_with_all_data_in_its_journal_gives_advice(tmp_path):
    with closing(sqlite3.connect(tmp_path / "run.db3")) as recorder:
        recorder.execute("PRAGMA journal_mode=WAL")
        recorder.execute("CREATE TABLE topics (id, name, type, serialization_format)")
        recorder.commit()
        single_threaded = tmp_path / "alone.db3"
        single_threaded.write_bytes((tmp_path / "run.db3").read_bytes())
        with pytest.raises(ReadError, match=r"no table 'topics'\. .* ends in -wal; .* wal_checkpoint"):
            open_log(single_threaded)
        recorder.execute("CREATE TABLE messages (topic_id, timestamp, data)")
        recorder.commit()
        recorder.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        single_threaded.write_bytes((tmp_path / "run.db3").read_bytes())
        with pytest.raises(ReadError, match=r"holds no messages\. .* ends in -wal; .* wal_checkpoint"):
            open_log(single_threaded)
        recorder.execute("INSERT INTO topics VALUES (1, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr')")
        recorder.commit()
        single_threaded.write_bytes((tmp_path / "run.db3-wal").read_bytes())
        with pytest.raises(ReadError, match=r"write-ahead log of an SQLite file, of no use without the \.db3"):
            open_log(single_threaded)


def test_an_archive_of_a_recording_gives_advice(tmp_path):
    recorded.write_rosbag2(tmp_path / "in" / "run", run(), StoragePlugin.MCAP, "mcap")
    archive = shutil.make_archive(str(tmp_path / "run"), "zip", tmp_path / "in")
    with pytest.raises(ReadError, match=r"The file is a zip archive: unpack it, and take") as caught:
        open_log(archive)
    assert caught.value.code == "log.archive"
