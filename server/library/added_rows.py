"""The trajectories that visitors add to logs as rows of a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from sqlalchemy import Connection, delete, insert, select

from server.library.added import Added
from server.library.log_rows import ensure_log
from server.library.records import Record
from server.library.tables import trajectories


def load_added(connection: Connection) -> Sequence[Added]:
    """Return all rows, oldest first."""
    rows = connection.execute(select(trajectories).order_by(trajectories.c.created_s))
    return [Added(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name for it


def replace_added(connection: Connection, record: Record, added: Added) -> None:
    """Write the row of a trajectory of the log ``record`` in the place of the owner's one of the same name."""
    ensure_log(connection, record)
    delete_added(connection, added.owner, added.log_id, added.name)
    connection.execute(insert(trajectories).values(asdict(added)))


def delete_added(connection: Connection, owner: str, log_id: str, name: str) -> None:
    """Forget a trajectory; one that is not there is no error."""
    of_it = (trajectories.c.owner == owner, trajectories.c.log_id == log_id, trajectories.c.name == name)
    connection.execute(delete(trajectories).where(*of_it))
