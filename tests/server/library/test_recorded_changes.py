"""What several connections to one SQLite database tell each other, and leases in it."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import Connection, delete, insert, select, update

from server.library.store import recorded_changes
from server.library.store.database import Database
from server.library.store.lease_rows import LeaseRows
from server.library.store.recorded_changes import RecordedChanges
from server.library.store.tables import ended_sign_ins, leases

OTHER = """
import sys
from pathlib import Path
from sqlalchemy import insert
from server.library.store.database import Database
from server.library.store.tables import ended_sign_ins
other = Database.open(None, Path(sys.argv[1]), of_workers=True)
other.now(lambda c: c.execute(insert(ended_sign_ins).values(name="theirs", given_s=1)).rowcount)
other.close()
"""


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    opened = Database.open(None, tmp_path, of_workers=True)
    yield opened
    opened.close()


@pytest.fixture
def changes(database: Database) -> Iterator[RecordedChanges]:
    assert database.file is not None
    found = RecordedChanges(database.file)
    yield found
    found.close()


def ends(name: str) -> object:
    return lambda connection: connection.execute(insert(ended_sign_ins).values(name=name, given_s=1)).rowcount


def test_only_what_another_process_has_changed_is_told(database: Database, changes: RecordedChanges) -> None:
    assert changes.new() is None  # what came before the first look is unknown
    database.now(ends("mine"))  # type: ignore[arg-type]
    assert list(changes.new() or ()) == []
    assert database.file is not None
    subprocess.run([sys.executable, "-c", OTHER, database.file.parent], check=True)
    assert list(changes.new() or ()) == [("ended_sign_ins", "theirs")]
    assert list(changes.new() or ()) == []


@pytest.mark.parametrize("how", ["insert", "update", "delete"])
def test_each_kind_of_change_is_recorded(
    database: Database, changes: RecordedChanges, how: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = ended_sign_ins
    work = {
        "insert": insert(table).values(name="b", given_s=1),
        "update": update(table).where(table.c.name == "a").values(given_s=2),
        "delete": delete(table).where(table.c.name == "a"),
    }[how]
    database.now(ends("a"))  # type: ignore[arg-type]
    changes.new()
    monkeypatch.setattr(recorded_changes.os, "getpid", lambda: -1)  # type: ignore[attr-defined] # read by another one
    database.now(lambda connection: connection.execute(work).rowcount)
    assert list(changes.new() or ()) == [("ended_sign_ins", "b" if how == "insert" else "a")]


def test_who_has_missed_changes_is_told_that_all_may_have_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorded_changes, "KEPT", 3)
    database = Database.open(None, tmp_path, of_workers=True)
    assert database.file is not None
    changes = RecordedChanges(database.file)
    changes.new()
    for n in range(5):
        database.now(ends(str(n)))  # type: ignore[arg-type]
    assert changes.new() is None
    kept = database.now(lambda c: c.exec_driver_sql("SELECT count(*) FROM recorded_changes").scalar())
    assert kept == 3
    changes.close()
    database.close()


def test_a_lease_in_sqlite_is_held_by_one_and_runs_out(database: Database) -> None:
    async def work() -> None:
        mine, theirs = LeaseRows(database, 60.0), LeaseRows(database, 60.0)
        assert await mine.take("job")
        assert not await theirs.take("job")
        assert await mine.renew("job", 0.5)
        assert await theirs.fraction("job") == 0.5
        await database.run(end_now)
        assert await theirs.take("job")
        assert not await mine.renew("job", 0.6)

    def end_now(connection: Connection) -> None:
        until = connection.execute(select(leases.c.until_s)).scalar_one()
        connection.execute(update(leases).values(until_s=until - 61.0))

    asyncio.run(work())
