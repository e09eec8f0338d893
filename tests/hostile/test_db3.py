"""SQLite files that are no bags, or bags with values that no recorder writes."""

from __future__ import annotations

import contextlib
import sqlite3
from pathlib import Path

import pytest

from mapper.core.errors import ReadError
from mapper.io.logs import open_log
from tests.hostile.corpus import recording
from tests.hostile.damage import opened


def sqlite_file(folder: Path, *statements: str) -> bytes:
    path = folder / "made.db3"
    path.unlink(missing_ok=True)
    with contextlib.closing(sqlite3.connect(path)) as connection:
        for statement in statements:
            connection.execute(statement)
        connection.commit()
    return path.read_bytes()


TOPICS = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)"
ENDLESS = (
    "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
    "SELECT i AS id, 1 AS topic_id, i AS timestamp, x'' AS data FROM n"
)


@pytest.mark.parametrize(
    "statements",
    [
        (TOPICS, f"CREATE VIEW messages AS {ENDLESS}"),
        (
            TOPICS,
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT, data AS (zeroblob(1e9)))",
        ),
        (TOPICS, "CREATE TABLE messages(rowid TEXT, topic_id INT, timestamp INT, data BLOB)"),
        (TOPICS, "CREATE TABLE messages(id INT, topic_id INT, timestamp INT)"),
        (TOPICS, "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)"),
        (TOPICS,),
        ("CREATE TABLE something(x)",),
    ],
    ids=[
        "endless view",
        "computed column",
        "rowid of another kind",
        "no data",
        "virtual table",
        "no messages",
        "other",
    ],
)
def test_an_sqlite_file_that_is_no_bag(tmp_path, statements):
    try:
        data = sqlite_file(tmp_path, *statements)
    except sqlite3.OperationalError as without:
        pytest.skip(f"this SQLite cannot make it: {without}")
    error = opened(tmp_path / "a.log", data)
    assert isinstance(error, ReadError)
    assert error.code == "log.unknown_format"


def test_an_sqlite_file_with_values_of_other_kinds(tmp_path):
    data = sqlite_file(
        tmp_path,
        TOPICS,
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)",
        "INSERT INTO topics VALUES (1, x'ff00', 5, NULL), (2, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr')",
        "INSERT INTO messages VALUES (1, 'x', 2, x''), (2, 2, 'now', 'text'), (3, 2, 1, 5.5), (4, NULL, NULL, NULL)",
    )
    error = opened(tmp_path / "a.log", data)
    assert isinstance(error, ReadError)
    assert error.code == "log.no_scans"


@pytest.mark.parametrize("name", ["a b?mode=rw&x=1#.db3", "100%.db3"])
def test_a_db3_of_any_name(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(recording("db3"))
    assert open_log(path).n_scans == 6
    assert [one.name for one in tmp_path.iterdir()] == [name]
