"""The records in their database: migrated, consistent, and with one sentence for each error."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import sqlite3
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Engine, event, inspect, text

from mapper.io.logs.summary import summarise
from mapper.simulation import sample_log
from server.jobs.record import Failure
from server.library.logs.records import Record
from server.library.logs.rows import LogRows
from server.library.store.database import Database, _engine, bring_up_to_date
from server.library.store.migrations import HEAD
from server.library.store.revision import MIGRATIONS
from server.library.store.tables import metadata
from server.storage import StorageError

RECORD = Record("a", "ann", "Café 地図.log", "upload", "queued", 1 << 40, "0" * 64, 12.5, 13.5)


@pytest_asyncio.fixture(params=["sqlite", "postgresql"])
async def database(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Database]:
    url = None if request.param == "sqlite" else request.getfixturevalue("postgresql").new_database()
    opened = Database.open(url, tmp_path)
    yield opened
    opened.close()


def _empty_database(kind: str, request: pytest.FixtureRequest, folder: Path) -> Engine:
    url = None if kind == "sqlite" else request.getfixturevalue("postgresql").new_database()
    folder.mkdir()
    return _engine(url, folder)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_an_empty_database_gets_the_newest_tables(kind: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    engine = _empty_database(kind, request, tmp_path / "empty")
    with engine.begin() as connection:
        bring_up_to_date(connection)
        assert compare_metadata(MigrationContext.configure(connection), metadata) == []
        assert connection.execute(text("SELECT version_num FROM alembic_version")).scalars().all() == [HEAD]
        assert sorted(inspect(connection).get_table_names()) == sorted(["alembic_version", *metadata.tables])
    engine.dispose()
    assert ScriptDirectory(str(MIGRATIONS)).get_heads() == [HEAD]


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
async def test_a_database_of_an_earlier_revision_is_brought_up_to_date(
    kind: str, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a revision that is made here, after the newest one."""
    url = None if kind == "sqlite" else request.getfixturevalue("postgresql").new_database()
    opened = Database.open(url, tmp_path)
    await LogRows(opened).put(RECORD)
    opened.close()
    later = tmp_path / "migrations"
    shutil.copytree(MIGRATIONS, later)
    (later / "versions" / "later.py").write_text(
        f"import sqlalchemy as sa\nfrom alembic import op\nrevision, down_revision = 'later', '{HEAD}'\n"
        "def upgrade() -> None:\n    op.add_column('logs', sa.Column('colour', sa.Text))\n"
    )
    monkeypatch.setattr("server.library.store.revision.MIGRATIONS", later)
    monkeypatch.setattr("server.library.store.database.HEAD", "later")
    opened = Database.open(url, tmp_path)
    found = "SELECT id, colour, version_num FROM logs, alembic_version"
    rows = await opened.run(lambda connection: [tuple(row) for row in connection.execute(text(found))])
    opened.close()
    assert rows == [("a", None, "later")]


async def test_records_are_read_back_unchanged(database: Database) -> None:
    rows = LogRows(database)
    summary = summarise(sample_log(5))
    records = [
        RECORD,
        replace(RECORD, id="b", state="ready", progress=1.0, created_s=1.0, summary=summary),
        replace(RECORD, id="c", created_s=2.0, state="failed", error=Failure("log.binary", "It holds “\0” and 地図.")),
        replace(RECORD, id="d", created_s=3.0, state="ready", progress=1.0, summary=replace(summary, range_max=1e999)),
    ]
    for record in [replace(records[1], state="reading"), *records]:
        await rows.put(record)
    plain = replace(records[2], error=Failure("log.binary", "It holds “” and 地図."))
    assert await rows.load() == [records[1], plain, records[3], records[0]]
    await rows.delete("b")
    await rows.delete("b")
    assert [record.id for record in await rows.load()] == ["c", "d", "a"]


async def test_work_is_done_in_the_order_of_the_calls(database: Database) -> None:
    rows = LogRows(database)
    asked: list[asyncio.Future[Any]] = []
    for n in range(20):
        asked += [rows.put(replace(RECORD, name=str(n))), rows.delete("a")]
    asked.append(rows.put(replace(RECORD, name="last")))
    await asyncio.gather(*asked)
    assert [record.name for record in await rows.load()] == ["last"]


# -- SQLite ------------------------------------------------------------------------------------------------------------


def refusal(folder: Path, url: str | None = None) -> StorageError:
    with pytest.raises(StorageError) as caught:
        Database.open(url, folder).close()
    assert caught.value.message.endswith(".")
    assert str(folder) not in caught.value.message
    return caught.value


def with_file(folder: Path, statement: str) -> None:
    with contextlib.closing(sqlite3.connect(folder / "library.db")) as connection, connection:
        connection.execute(statement)


async def test_sqlite_is_configured(tmp_path: Path) -> None:
    database = Database.open(None, tmp_path)
    pragmas = ("journal_mode", "foreign_keys", "busy_timeout", "synchronous")
    found = await database.run(
        lambda connection: [connection.execute(text(f"PRAGMA {pragma}")).scalar() for pragma in pragmas]
    )
    database.close()
    assert found == ["wal", 1, 5000, 1]
    assert sorted(os.listdir(tmp_path)) == ["library.db", "library.db-reserve"]  # noqa: PTH208 - not for async functions


async def test_a_newer_database_is_refused_and_not_changed(tmp_path: Path) -> None:
    Database.open(None, tmp_path).close()
    with_file(tmp_path, "UPDATE alembic_version SET version_num = '9999'")
    before = (tmp_path / "library.db").read_bytes()
    error = refusal(tmp_path)
    assert error.code == "library.newer"
    assert "9999" in error.message
    assert (tmp_path / "library.db").read_bytes() == before


async def test_a_damaged_database_is_refused(tmp_path: Path) -> None:
    database = Database.open(None, tmp_path)
    rows = LogRows(database)
    await asyncio.gather(*(rows.put(replace(RECORD, id=str(n), name="n" * 500)) for n in range(40)))
    database.close()
    whole = (tmp_path / "library.db").read_bytes()
    for damage in (b"no database" * 100, whole[:4096] + os.urandom(8192) + whole[12288:], whole[: len(whole) // 2]):
        (tmp_path / "library.db").write_bytes(damage)
        assert refusal(tmp_path).code == "library.damaged"


async def test_a_locked_database_is_refused_after_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.store.database.BUSY_S", 0.05)
    database = Database.open(None, tmp_path)
    with contextlib.closing(sqlite3.connect(tmp_path / "library.db", isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(StorageError) as caught:
            await LogRows(database).put(RECORD)
        assert caught.value.code == "library.locked"
        assert refusal(tmp_path).code == "library.locked"
        other.execute("ROLLBACK")
    await LogRows(database).put(RECORD)
    database.close()


async def test_on_a_full_disk_a_record_is_written_completely_or_not_at_all(tmp_path: Path) -> None:
    database = Database.open(None, tmp_path)
    with contextlib.closing(sqlite3.connect(tmp_path / "library.db")) as empty:
        (pages,) = empty.execute("PRAGMA page_count").fetchone()
    event.listen(database._engine, "begin", lambda c: c.exec_driver_sql(f"PRAGMA max_page_count = {pages + 12}"))
    rows = LogRows(database)
    ends = await asyncio.gather(
        *(rows.put(replace(RECORD, id=str(n), name="n" * 5000)) for n in range(30)), return_exceptions=True
    )
    kept = ends.index(next(end for end in ends if end is not None))
    assert {end.code for end in ends[kept:] if isinstance(end, StorageError)} == {"log.storage"}
    assert 0 < kept == len(await rows.load()) < 30
    database.close()


async def test_an_unreachable_database_gives_one_sentence(tmp_path: Path) -> None:
    assert refusal(tmp_path, "sqlite:////no/such/folder/library.db").code == "library.unreachable"
    assert refusal(tmp_path, "postgresql://127.0.0.1:1/none?connect_timeout=2").code == "library.unreachable"
