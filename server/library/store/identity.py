"""Checks that a database of records and a store of blobs belong together.

Otherwise a service with the wrong store would treat all records as those of deleted logs, and delete them.
"""

from __future__ import annotations

import structlog
from sqlalchemy import Connection, text

from server.library.store.blobs import Blobs
from server.library.store.database import Database
from server.library.store.tables import store
from server.storage import StorageError

_log = structlog.get_logger(__name__)


def check_store_identity(database: Database, blobs: Blobs) -> None:
    """Write the store's id into the records; raise :class:`StorageError` if they belong to another store.

    A store whose id cannot currently be read is accepted. Blocks.
    """

    def belong(connection: Connection) -> bool:
        if connection.dialect.name == "postgresql":  # as SQLite does: a second service waits
            connection.execute(text("SELECT pg_advisory_xact_lock(1196574019)"))
        try:  # a new store gets its id under the lock, because not every store refuses the second of two writers
            identity = blobs.identity()
        except StorageError:
            _log.warning("the id of the store of blobs cannot be read: whether the records belong to it is not checked")
            return True
        known = connection.execute(store.select()).scalars().all()
        if not known:
            connection.execute(store.insert().values(id=identity))
        return not known or identity in known

    if not database.now(belong):
        raise StorageError(
            "library.another_store",
            "The database of the records belongs to the logs of another data folder or bucket: "
            "name that one, or a database of this one’s own.",
        )


def belong_together(database: Database, blobs: Blobs) -> bool:
    """Return whether the records name this store, or no store yet.

    Otherwise, also if the store's id cannot be read, neither may be deleted because the other is missing. Blocks.
    """
    known = database.now(lambda connection: connection.execute(store.select()).scalars().all())
    try:
        return not known or blobs.identity() in known
    except StorageError:
        return False
