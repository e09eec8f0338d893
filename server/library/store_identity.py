"""Checks that a database of records and a store of blobs belong together.

Otherwise a service with the wrong store would take all records for records of deleted logs, and delete them.
"""

from __future__ import annotations

import structlog
from sqlalchemy import Connection, text

from server.library.blobs import Blobs
from server.library.database import Database
from server.library.storage import StorageError
from server.library.tables import store

_log = structlog.get_logger(__name__)


def check_store_identity(database: Database, blobs: Blobs) -> None:
    """Note in the records which store they belong to; raise :class:`StorageError` where they belong to another.

    A store whose id cannot be read now is accepted. Blocks.
    """
    try:
        identity = blobs.identity()
    except StorageError:
        _log.warning("the store of blobs does not say who it is: whether the records are its own is not checked")
        return

    def belong(connection: Connection) -> bool:
        if connection.dialect.name == "postgresql":  # of two that begin at once, the second waits, as with SQLite
            connection.execute(text("SELECT pg_advisory_xact_lock(1196574019)"))
        known = connection.execute(store.select()).scalars().all()
        if not known:
            connection.execute(store.insert().values(id=identity))
        return not known or identity in known

    if not database.now(belong):
        raise StorageError(
            "library.another_store",
            "The database of the records belongs to the logs of another data folder or bucket: "
            "name that one, or a database of this one's own.",
        )


def is_sure_to_belong(database: Database, blobs: Blobs) -> bool:
    """Return whether the records know this store, or none yet: only then may be deleted what the other has not.

    Blocks.
    """
    known = database.now(lambda connection: connection.execute(store.select()).scalars().all())
    try:
        return not known or blobs.identity() in known
    except StorageError:
        return False
