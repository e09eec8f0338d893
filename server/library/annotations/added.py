"""A trajectory that a visitor has added to a log, and its row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Literal

from sqlalchemy import Connection, delete, insert, select

from mapper.core.errors import MapperError
from server.library.logs.records import Record, TrajectoryAnswer
from server.library.logs.rows import ensure_log
from server.library.store.tables import trajectories

TrajectorySource = Literal["tum", "slam", "localized"]


class TrajectoryNotFoundError(MapperError):
    """The visitor has not added such a trajectory to the log."""


@dataclass(frozen=True, slots=True)
class Added:
    """One added trajectory of a log, visible only to its ``owner`` and to guests of the owner's links.

    ``source`` is its origin: an uploaded TUM file, or the service's own SLAM or localization. ``bytes`` is the size of
    its files, ``poses`` the number of poses in them, ``length_m`` the length of the path, metres.
    """

    id: str
    owner: str
    log_id: str
    name: str
    description: str
    source: TrajectorySource
    created_s: float
    bytes: int
    poses: int
    length_m: float
    has_graph: bool = False  #: whether the pose graph from which it was computed is stored too

    def public(self) -> TrajectoryAnswer:
        """Return the answer of the HTTP interface."""
        return TrajectoryAnswer(
            self.name, self.description, self.length_m, self.source, self.created_s, self.has_graph
        )  # fmt: skip


def load_added(connection: Connection) -> Sequence[Added]:
    """Return all rows, oldest first."""
    rows = connection.execute(select(trajectories).order_by(trajectories.c.created_s))
    return [Added(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name for it


def replace_added(connection: Connection, record: Record, added: Added) -> None:
    """Write the row of a trajectory of the log ``record``, replacing the owner's one of the same name."""
    ensure_log(connection, record)
    delete_added(connection, added.owner, added.log_id, added.name)
    connection.execute(insert(trajectories).values(asdict(added)))


def delete_added(connection: Connection, owner: str, log_id: str, name: str) -> None:
    """Delete a trajectory. A missing one is no error."""
    of_it = (trajectories.c.owner == owner, trajectories.c.log_id == log_id, trajectories.c.name == name)
    connection.execute(delete(trajectories).where(*of_it))
