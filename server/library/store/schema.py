"""The tables of the database: made in one step in an empty one, otherwise brought up to date by alembic."""

from __future__ import annotations

import logging
from pathlib import Path

from sqlalchemy import Connection, inspect, text

from server.library.store.announcing import announce_changes
from server.library.store.migrations import HEAD
from server.library.store.tables import alembic_version, metadata
from server.storage import StorageError

MIGRATIONS = Path(__file__).parent / "migrations"


def bring_up_to_date(connection: Connection) -> None:
    """Give the database the tables of :mod:`server.library.store.tables`, in the transaction of ``connection``.

    Raises :class:`StorageError` for a database that another version of the program has written.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(text("SELECT pg_advisory_xact_lock(1196574018)"))  # two services that start at once
    known = set(inspect(connection).get_table_names())
    if known.isdisjoint({alembic_version.name, *metadata.tables}):
        _create(connection)
    else:
        is_versioned = alembic_version.name in known
        version = connection.execute(alembic_version.select()).scalar() if is_versioned else None
        if version != HEAD:
            _upgrade(connection, version)
    if connection.dialect.name == "postgresql":
        announce_changes(connection)


def _create(connection: Connection) -> None:
    """Make the tables as all revisions together make them. It spares an empty database the import of alembic."""
    alembic_version.create(connection)
    metadata.create_all(connection, checkfirst=False)
    connection.execute(alembic_version.insert().values(version_num=HEAD))


def _upgrade(connection: Connection, version: str | None) -> None:
    """Run the revisions after ``version``. Raises :class:`StorageError` for an unknown one, and for none."""
    logging.getLogger("alembic").setLevel(logging.WARNING)  # do not log each step
    from alembic import command  # noqa: PLC0415 - start-up: mostly there is nothing to do
    from alembic.config import Config  # noqa: PLC0415
    from alembic.script import ScriptDirectory  # noqa: PLC0415

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    if version not in {one.revision for one in ScriptDirectory.from_config(config).walk_revisions()}:
        raise StorageError(
            "library.newer",
            f"The records were written by a newer Gridbloom, or by one from before version 0.2 (their revision is "
            f"{version or 'unknown'}, this one knows {HEAD}): install that one, or choose another database.",
        )
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
