"""Links: each opens a read-only view of its owner's log until the owner revokes it.

The library stores the view without interpreting it.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import asdict, dataclass

from sqlalchemy import Connection, delete, insert, select

from mapper.core.errors import LimitError, MapperError
from server.library.logs.records import Record
from server.library.logs.rows import ensure_log
from server.library.store.database import Database
from server.library.store.tables import links

MAX_LINKS_PER_OWNER = 100


class LinkGoneError(MapperError):
    """There is no such link, because it never existed, or was revoked."""


@dataclass(frozen=True, slots=True)
class Link:
    """A link of ``owner`` to a log. Anyone with the ``token`` may open it; ``view`` is JSON."""

    token: str
    owner: str
    log_id: str
    created_s: float
    view: str


class Links:
    """All links, in memory and in the database. Used from the event loop only.

    ``ended`` is called with each token that another service or worker has revoked, because visitors may still have it
    open here.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._links: dict[str, Link] = {}
        self.ended: Callable[[str], Awaitable[None]] = _ignore

    async def follow(self, _: object = None) -> None:
        """Load the stored links. Raises ``StorageError``."""
        stored = {link.token: link for link in await self._database.run(_load)}
        gone = self._links.keys() - stored.keys()
        self._links = stored
        for token in gone:
            await self.ended(token)

    async def make(self, owner: str, record: Record, view: str) -> Link:
        """Return a new link of ``owner`` to a view of a log that ``owner`` may open.

        Raises :class:`LimitError` for too many links, and ``StorageError``.
        """
        if sum(link.owner == owner for link in self._links.values()) >= MAX_LINKS_PER_OWNER:
            message = f"You have {MAX_LINKS_PER_OWNER} links, the maximum: revoke one."
            raise LimitError("link.too_many", message)
        link = Link(secrets.token_urlsafe(24), owner, record.id, time.time(), view)

        def work(connection: Connection) -> None:
            ensure_log(connection, record)
            connection.execute(insert(links).values(asdict(link)))

        await self._database.run(work)
        self._links[link.token] = link
        return link

    def get(self, token: str) -> Link:
        """Return a link. Raises :class:`LinkGoneError`."""
        link = self._links.get(token)
        if link is None:
            raise LinkGoneError("link.gone", "This link was revoked, or there never was one: ask for another.")
        return link

    def of(self, owner: str, log_id: str) -> Sequence[Link]:
        """Return the links of ``owner`` to a log, newest first."""
        of_log = [link for link in self._links.values() if link.owner == owner and link.log_id == log_id]
        return sorted(of_log, key=lambda link: link.created_s, reverse=True)

    async def revoke(self, owner: str, token: str) -> None:
        """Revoke a link of ``owner``. Raises :class:`LinkGoneError`, and ``StorageError``."""
        if self.get(token).owner != owner:
            raise LinkGoneError("link.gone", "There is no such link of yours.")
        await self._database.run_deletion(lambda connection: _delete(connection, token))
        self._links.pop(token, None)

    def drop(self, log_id: str) -> Sequence[str]:
        """Remove the links to a deleted log, whose rows were deleted with it; return their tokens."""
        gone = [link.token for link in self._links.values() if link.log_id == log_id]
        for token in gone:
            del self._links[token]
        return gone


async def _ignore(_: str) -> None:
    """Ignore the token of a revoked link."""


def _load(connection: Connection) -> Sequence[Link]:
    return [Link(**row._mapping) for row in connection.execute(select(links))]  # noqa: SLF001 - SQLAlchemy's public name for it


def _delete(connection: Connection, token: str) -> None:
    connection.execute(delete(links).where(links.c.token == token))
