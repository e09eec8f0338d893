"""The newest message at a moment by the index of a bag, against rosbags' reader and against a pass over the bag."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag1 import Reader

from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.contents import seeking
from mapper.io.contents.bag_index import indexed_message
from mapper.io.contents.seeking import message_at
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, cloud, scan, text, written

T0 = 1_600_000_000 * SECOND


@pytest.fixture
def never_read_through(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise AssertionError("the recording was read from its beginning")

    monkeypatch.setattr(seeking, "_Newest", refused)


def run(n: int = 40) -> list[recorded.Said]:
    said = []
    for i in range(n):
        said.append(scan(T0 + i * SECOND, [1.0 + i]))
        if i % 3 == 1:
            said.append(cloud(T0 + i * SECOND + 7, np.full((45_000, 3), float(i))))
        said.append(text(T0 + i * SECOND + 9, f"word {i}"))
    return said


@pytest.mark.usefixtures("never_read_through")
@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
@pytest.mark.parametrize("topic", ["/scan", "/points", "/chatter"])
def test_it_is_the_one_that_another_reader_finds(tmp_path: Path, compression: str, topic: str) -> None:
    path = recorded.write_bag(tmp_path / "a.bag", run(16), compression)
    with Reader(path) as reader:
        wanted = [one for one in reader.connections if one.topic == topic]
        theirs = [(stamp, bytes(data)) for _, stamp, data in reader.messages(wanted)]
        assert len(reader.chunks) > 2
    for at in [0, *(stamp + change for stamp, _ in theirs[::3] for change in (-1, 0, 1)), 1 << 62]:
        expected = next((one for one in reversed(theirs) if one[0] <= at), theirs[0])
        found = message_at(path, topic, at)
        assert (found.stamp_ns, found.data, found.cdr) == (*expected, False)


@pytest.mark.usefixtures("never_read_through")
def test_the_index_of_a_real_bag_leads_to_its_messages(data_file: Callable[..., Path]) -> None:
    path = data_file("bags/b0-tiny.bag")
    with Reader(path) as reader:
        (imu,) = [one for one in reader.connections if one.topic == "imu"]
        theirs = [(stamp, bytes(data)) for _, stamp, data in reader.messages([imu])]
    for stamp, data in theirs[::200]:
        found = message_at(path, "imu", stamp)
        assert (found.stamp_ns, found.data) == (stamp, data)


def test_a_bag_without_an_index_or_with_a_wrong_one_is_read_from_its_beginning(tmp_path: Path) -> None:
    path = recorded.write_bag(tmp_path / "a.bag", run(16))
    whole = path.read_bytes()
    at = T0 + 12 * SECOND
    expected = message_at(path, "/points", at)
    index_at = int.from_bytes(whole[whole.index(b"index_pos=") + 10 :][:8], "little")
    broken = {
        "cut": whole[: index_at - 1],
        "no index": whole.replace(b"index_pos=" + index_at.to_bytes(8, "little"), b"index_pos=" + bytes(8)),
        "beyond": whole.replace(b"index_pos=" + index_at.to_bytes(8, "little"), b"index_pos=" + b"\xff" * 8),
        "in the middle": whole.replace(
            b"index_pos=" + index_at.to_bytes(8, "little"), b"index_pos=" + (index_at - 9).to_bytes(8, "little")
        ),
        "chunks elsewhere": _with_moved_chunks(whole, index_at),
    }
    for name, data in broken.items():
        path.write_bytes(data)
        assert indexed_message(path, "/points", at, DEFAULT_LIMITS) is None, name
        found = message_at(path, "/points", at)
        assert (found.stamp_ns, found.data) == (expected.stamp_ns, expected.data), name


def _with_moved_chunks(whole: bytes, index_at: int) -> bytes:
    """The bag with each chunk stated to be one byte later than it is."""
    out, at = bytearray(whole), index_at
    while (at := whole.find(b"chunk_pos=", at)) >= 0:
        place = int.from_bytes(whole[at + 10 : at + 18], "little")
        out[at + 10 : at + 18] = (place + 1).to_bytes(8, "little")
        at += 18
    return bytes(out)


def test_of_an_sqlite_bag_only_the_data_of_the_row_that_is_found_is_read(tmp_path: Path) -> None:
    """Also without an index of times: the data of all rows before is larger than what may be read."""
    path = written(tmp_path, run(16), "db3")
    with sqlite3.connect(path) as connection:
        for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'index'").fetchall():
            connection.execute(f"DROP INDEX {name}")
        at = T0 + 13 * SECOND + 7
        (key,) = connection.execute("SELECT id FROM topics WHERE name = '/points'").fetchone()
        connection.execute(
            "UPDATE messages SET data = zeroblob(2000000) WHERE topic_id = ? AND timestamp < ?", (key, at)
        )
    connection.close()
    found = message_at(path, "/points", at + 5, replace(DEFAULT_LIMITS, max_chunk_bytes=1_000_000))
    expected = next(one for one in run(16) if one.stamp_ns == at)
    assert (found.stamp_ns, found.data) == (at, recorded.serialised(expected, 2))
