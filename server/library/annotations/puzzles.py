"""Visitors' puzzles: the specification of each, stored until its owner removes it.

The library stores the specification, a text, without interpreting it.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, delete, insert, select

from mapper.core.errors import LimitError, MapperError
from server.library.logs.records import Record
from server.library.logs.rows import ensure_log
from server.library.store.database import Database
from server.library.store.tables import puzzles

MAX_PUZZLES_PER_OWNER = 50
MAX_SPEC_BYTES = 1 << 20  #: a story has at most a thousand actions


class PuzzleGoneError(MapperError):
    """There is no such puzzle, because it never existed, or was removed."""


@dataclass(frozen=True, slots=True)
class MadePuzzle:
    """A puzzle of ``owner``, created from a log (``log_id``) or a history of the lab (None) according to ``spec``.

    Anyone with the ``token`` may solve it.
    """

    token: str
    owner: str
    log_id: str | None
    created_s: float
    title: str
    spec: str


class MadePuzzles:
    """All visitors' puzzles, in memory and in the database. Used from the event loop only."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._made: dict[str, MadePuzzle] = {}

    async def follow(self, _: object = None) -> None:
        """Load the stored puzzles. Raises ``StorageError``."""
        self._made = {puzzle.token: puzzle for puzzle in await self._database.run(_load)}

    async def make(self, owner: str, record: Record | None, title: str, spec: str) -> MadePuzzle:
        """Return a new puzzle of ``owner``; ``record`` is that of its log.

        Raises :class:`LimitError` for too many puzzles and for a history that is too long, and ``StorageError``.
        """
        if sum(puzzle.owner == owner for puzzle in self._made.values()) >= MAX_PUZZLES_PER_OWNER:
            message = f"You have {MAX_PUZZLES_PER_OWNER} puzzles, the maximum: remove one."
            raise LimitError("puzzle.too_many", message)
        if len(spec) > MAX_SPEC_BYTES:
            raise LimitError("puzzle.large", "The history of this world is too long for a puzzle: reset it first.")
        log_id = None if record is None else record.id
        made = MadePuzzle(secrets.token_urlsafe(24), owner, log_id, time.time(), title, spec)

        def work(connection: Connection) -> None:
            if record is not None:
                ensure_log(connection, record)
            values = {"token": made.token, "owner": owner, "log_id": log_id, "created_s": made.created_s}
            connection.execute(insert(puzzles).values(**values, title=title, spec=spec))

        await self._database.run(work)
        self._made[made.token] = made
        return made

    def get(self, token: str) -> MadePuzzle:
        """Return a puzzle. Raises :class:`PuzzleGoneError`."""
        puzzle = self._made.get(token)
        if puzzle is None:
            raise PuzzleGoneError("puzzle.gone", "There is no such puzzle; it may have been removed.")
        return puzzle

    def of(self, owner: str) -> Sequence[MadePuzzle]:
        """Return the puzzles of ``owner``, newest first."""
        return sorted(
            (puzzle for puzzle in self._made.values() if puzzle.owner == owner), key=lambda puzzle: -puzzle.created_s
        )

    async def remove(self, owner: str, token: str) -> None:
        """Remove a puzzle of ``owner``. Raises :class:`PuzzleGoneError`, and ``StorageError``."""
        if self.get(token).owner != owner:
            raise PuzzleGoneError("puzzle.gone", "There is no such puzzle of yours.")
        await self._database.run_deletion(lambda connection: _delete(connection, token))
        self._made.pop(token, None)

    def drop(self, log_id: str) -> None:
        """Remove the puzzles of a deleted log, whose rows were deleted with it."""
        self._made = {token: puzzle for token, puzzle in self._made.items() if puzzle.log_id != log_id}


def _load(connection: Connection) -> Sequence[MadePuzzle]:
    rows = connection.execute(select(puzzles))
    return [MadePuzzle(row.token, row.owner, row.log_id, row.created_s, row.title, row.spec) for row in rows]


def _delete(connection: Connection, token: str) -> None:
    connection.execute(delete(puzzles).where(puzzles.c.token == token))
