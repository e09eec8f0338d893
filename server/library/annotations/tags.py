"""Tags: words by which a visitor sorts the accessible logs, including those of the server."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from sqlalchemy import Connection, delete, insert, select

from mapper.core.errors import LimitError, MapperError
from server.library.logs.records import Record
from server.library.logs.rows import ensure_log
from server.library.store.database import Database
from server.library.store.tables import log_tags

MAX_TAGS = 12  #: of one visitor on one log
MAX_TAG_LENGTH = 40
MAX_TAGS_PER_OWNER = 5000


def clean_tags(tags: Iterable[str]) -> tuple[str, ...]:
    """Return tags in lower case with single spaces, without duplicates, in alphabetical order.

    Raises :class:`MapperError` for an empty or a long tag, and :class:`LimitError` for too many.
    """
    cleaned = {" ".join(tag.casefold().split()) for tag in tags}
    if any(not 1 <= len(tag) <= MAX_TAG_LENGTH or not tag.isprintable() or "," in tag for tag in cleaned):
        raise MapperError("tag.invalid", f"A tag has 1 to {MAX_TAG_LENGTH} characters and no comma.")
    if len(cleaned) > MAX_TAGS:
        raise LimitError("tag.too_many", f"A log can have {MAX_TAGS} tags.")
    return tuple(sorted(cleaned))


class Tags:
    """The tags of all visitors, in memory and in the database. Used from the event loop only."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._tags: dict[tuple[str, str], tuple[str, ...]] = {}  #: owner, log → tags

    async def follow(self, _: object = None) -> None:
        """Load the stored tags. Raises ``StorageError``."""
        tags_of: dict[tuple[str, str], list[str]] = {}
        for owner, log_id, tag in await self._database.run(_load):
            tags_of.setdefault((owner, log_id), []).append(tag)
        self._tags = {key: tuple(sorted(tags)) for key, tags in tags_of.items()}

    def of(self, owner: str, log_id: str) -> tuple[str, ...]:
        """Return the tags that ``owner`` has given to a log."""
        return self._tags.get((owner, log_id), ())

    async def put(self, owner: str, record: Record, tags: Iterable[str]) -> tuple[str, ...]:
        """Replace the tags that ``owner`` has given a log. Raises like :func:`clean_tags`."""
        fresh = clean_tags(tags)
        others = sum(len(known) for (who, log), known in self._tags.items() if who == owner and log != record.id)
        if others + len(fresh) > MAX_TAGS_PER_OWNER:
            raise LimitError("tag.too_many", f"You have {MAX_TAGS_PER_OWNER} tags, the maximum.")

        def work(connection: Connection) -> None:
            ensure_log(connection, record)
            own = (log_tags.c.owner == owner) & (log_tags.c.log_id == record.id)
            connection.execute(delete(log_tags).where(own))
            rows = [{"owner": owner, "log_id": record.id, "tag": tag} for tag in fresh]
            if rows:
                connection.execute(insert(log_tags), rows)

        await self._database.run(work)
        self._tags[(owner, record.id)] = fresh
        return fresh

    def drop(self, log_id: str) -> None:
        """Remove the tags of a deleted log, whose rows were deleted with it."""
        for key in [key for key in self._tags if key[1] == log_id]:
            del self._tags[key]


def _load(connection: Connection) -> Sequence[tuple[str, str, str]]:
    rows = connection.execute(select(log_tags.c.owner, log_tags.c.log_id, log_tags.c.tag))
    return [(owner, log_id, tag) for owner, log_id, tag in rows]
