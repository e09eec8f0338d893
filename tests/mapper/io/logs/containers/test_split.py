"""One log in several files: a recording that ROS 2 split, a ring of sonars; as a folder, and as a tar archive of it."""

from __future__ import annotations

import gzip
import io
import random
import tarfile
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin

from mapper.core.errors import ReadError
from mapper.io.logs import is_log, open_log
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.driven_robot import T0, run
from tests.marks import also_long_rows

PLUGINS = {"db3": StoragePlugin.SQLITE3, "db3.zstd": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}


def split(tmp_path: Path, suffix: str, n: int) -> tuple[Path, Path]:
    """Return a folder with a recording in ``n`` files, as ROS 2 splits it, and the same recording in one file."""
    messages = run(24)
    compression = "file" if suffix.endswith("zstd") else "none"
    whole = recorded.write_rosbag2(tmp_path / "whole", messages, PLUGINS[suffix], suffix, compression)
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    for i, part in enumerate(np.array_split(np.arange(len(messages)), n)):
        said = [messages[at] for at in part]
        one = recorded.write_rosbag2(tmp_path / f"part{i}", said, PLUGINS[suffix], suffix, compression)
        one.rename(folder / f"run_{i}.{suffix}")
    return folder, whole


def packed(folder: Path, form: int = tarfile.PAX_FORMAT, under: str = "bags/run") -> Path:
    """Return a tar archive of a folder, its files in no order."""
    target = folder.with_name("run.tar")
    files = sorted(folder.iterdir())
    random.Random(1).shuffle(files)
    with tarfile.open(target, "w", format=form) as archive:
        archive.addfile(tarfile.TarInfo("bags"), None)
        for file in files:
            archive.add(file, f"{under}/{file.name}")
    return target


@pytest.mark.parametrize(
    ("suffix", "by"),
    [
        ("db3", "folder"),
        ("db3.zstd", "tar"),
        ("mcap", "tar.gz"),
        *also_long_rows(*(("db3", by) for by in ("tar", "tar.gz"))),
        *also_long_rows(*(("db3.zstd", by) for by in ("folder", "tar.gz"))),
        *also_long_rows(*(("mcap", by) for by in ("folder", "tar"))),
    ],
)
def test_a_split_recording_is_one_log(tmp_path, suffix, by):
    folder, whole = split(tmp_path, suffix, 12)
    path = folder if by == "folder" else packed(folder)
    if by == "tar.gz":
        path.write_bytes(gzip.compress(path.read_bytes()))
    assert is_log(path)
    shares = list[float]()
    log, expected = open_log(path, progress=shares.append), open_log(whole)
    np.testing.assert_array_equal(log.ranges, expected.ranges)
    np.testing.assert_array_equal(log.stamps_ns, expected.stamps_ns)
    assert log.mount == expected.mount
    assert list(log.trajectories) == list(expected.trajectories)
    for name in expected.trajectories:
        np.testing.assert_array_equal(log.trajectory(name).poses, expected.trajectory(name).poses)
    assert log.topics == expected.topics
    assert log.notes == ("12 files are read as one recording.",)
    assert log.format == f"{expected.format.split(',')[0]}, 12 files, /scan"
    assert shares[-1] == 1.0 == max(shares)


@pytest.mark.parametrize("form", [tarfile.USTAR_FORMAT, tarfile.GNU_FORMAT, tarfile.PAX_FORMAT])
def test_the_kinds_of_tar(tmp_path, form):
    folder, whole = split(tmp_path, "mcap", 3)
    long = "b" * (60 if form == tarfile.USTAR_FORMAT else 300)
    log = open_log(packed(folder, form, f"{long}/{long}"))
    np.testing.assert_array_equal(log.stamps_ns, open_log(whole).stamps_ns)


def test_streams_of_one_file_are_not_taken_for_those_of_another(tmp_path):
    """Each file counts its channels again: in one, the first is of scans, in the other, of poses."""
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "metadata.yaml").touch()
    scans = [recorded.scan(T0 + i, [1.0, 2.0]) for i in range(3)]
    poses = [recorded.odometry(T0 + i, 0.1 * i, 0.0, 0.0) for i in range(3)]
    (folder / "run_0.mcap").write_bytes(recorded.mcap_bytes(scans))
    (folder / "run_1.mcap").write_bytes(recorded.mcap_bytes(poses))
    log = open_log(folder)
    assert log.n_scans == 3
    np.testing.assert_allclose(log.trajectory("odom").poses[:, 0], [0.0, 0.1, 0.2])
    assert [(one.name, one.count) for one in log.topics] == [("/scan", 3), ("/odom", 3)]


def test_a_file_that_is_damaged_or_missing_is_said(tmp_path):
    folder, whole = split(tmp_path, "mcap", 6)
    (folder / "run_2.mcap").unlink()
    data = (folder / "run_4.mcap").read_bytes()
    (folder / "run_4.mcap").write_bytes(data[: len(data) // 2])
    log = open_log(folder)
    assert 10 < log.n_scans < open_log(whole).n_scans
    assert "5 files are read as one recording. Between number 1 and number 3 files are missing." in log.notes
    assert any(note.startswith("run_4.mcap: The file ends early") for note in log.notes)


def test_unreadable_files_are_left_out(tmp_path):
    folder, whole = split(tmp_path, "db3", 3)
    data = (folder / "run_1.db3").read_bytes()
    (folder / "run_1.db3").write_bytes(data[:100] + bytes(len(data) - 100))
    log = open_log(folder)
    assert 10 < log.n_scans < open_log(whole).n_scans
    assert any(note.startswith("run_1.db3: It is left out: The SQLite file") for note in log.notes)


def test_several_recordings_are_not_taken_for_one(tmp_path):
    folder, _ = split(tmp_path, "mcap", 2)
    (folder / "metadata.yaml").rename(tmp_path / "metadata.yaml")
    (folder / "run_1.mcap").rename(folder / "other_1.mcap")
    for path in (folder, packed(folder)):
        with pytest.raises(ReadError, match=r"holds 2 recordings, and no metadata\.yaml .*: 'other_1\.mcap', 'run_0"):
            open_log(path)
    (folder / "other_1.mcap").rename(folder / "run_1.mcap")
    (tmp_path / "metadata.yaml").rename(folder / "metadata.yaml")
    bag = recorded.write_bag(folder / "run.bag", run())
    with pytest.raises(ReadError, match="holds 3 recordings, of different kinds"):
        open_log(folder)
    bag.unlink()
    (folder / "run_1.mcap").unlink()
    assert open_log(folder).notes == ()


def test_parts_without_metadata_are_one_recording_by_their_names(tmp_path):
    folder, whole = split(tmp_path, "mcap", 3)
    (folder / "metadata.yaml").unlink()
    for path in (folder, packed(folder)):
        log = open_log(path)
        np.testing.assert_array_equal(log.ranges, open_log(whole).ranges)
        assert "3 files are read as one recording, as their names say." in log.notes
    other = [recorded.text(1, "hello")]
    (folder / "run_2.mcap").write_bytes(recorded.mcap_bytes(other))
    with pytest.raises(ReadError, match="have no topic in common"):
        open_log(folder)


def test_of_two_recordings_in_one_archive_none_is_taken(tmp_path):
    folder, _ = split(tmp_path, "mcap", 1)
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as archive:
        for name in ("a", "b"):
            archive.add(folder, name)
    (tmp_path / "two.tar").write_bytes(out.getvalue())
    with pytest.raises(ReadError, match="holds 2 recordings, in different folders"):
        open_log(tmp_path / "two.tar")


def test_a_ring_of_sonars_and_a_single_log_in_an_archive(tmp_path):
    folder = tmp_path / "ring"
    folder.mkdir()
    (folder / "readme.md").write_text("a ring\n")
    (folder / "measurement.txt").write_text("1000 5110 1000 2500 9999\n1200 500 600 700 800\n")
    (folder / "poses.txt").write_text("1000 0 0 0\n1200 1000 -500 900\n")
    np.testing.assert_array_equal(open_log(packed(folder)).ranges, open_log(folder).ranges)
    (folder / "poses.txt").rename(folder / "other.txt")
    with pytest.raises(ReadError, match=r"there is no poses\.txt; a sonar log consists of both files"):
        open_log(packed(folder))
    (folder / "measurement.txt").write_text("FLASER 3 1 2 3 0 0 0 0 0 0 1.0 host 1.0\n")
    assert open_log(packed(folder)).name == "measurement.txt"
    (folder / "measurement.txt").unlink()
    for path in (folder, packed(folder)):
        with pytest.raises(ReadError, match="poses without readings"):
            open_log(path)
