"""Notes on logs. Each refers to a time of the log, to a place on its map, or to both. Used from the event loop."""

from __future__ import annotations

import json
import secrets
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from sqlalchemy import Connection, Row, delete, func, insert, select, update

from mapper.core.errors import LimitError, MapperError
from server.library.annotations.areas import Corner, centroid, crosses_itself, is_thin
from server.library.logs.records import Record
from server.library.logs.rows import upsert_log
from server.library.store.database import Database
from server.library.store.tables import logs, notes

MAX_CORNERS = 200
MAX_NOTES_OF_LOG = 500
MAX_NOTES_OF_AUTHOR = 100  #: on one log, so that one visitor leaves room for others


class NoteNotFoundError(MapperError):
    """There is no such note on the log."""


class NoteReadOnlyError(MapperError):
    """The note belongs to another visitor."""


@dataclass(frozen=True, slots=True)
class Pin:
    """Place and time of a note: ``at_s`` seconds after the log's first scan, a place ``x``, ``y`` on the map, or both.

    With a time, the number of scans in the map at that time is given too. ``outline`` are the corners of an area on the
    map, not closed; without a place, its centroid is used. Coordinates are metres. Raises :class:`MapperError` if
    neither time nor place is given.
    """

    at_s: float | None = None
    scan: int | None = None
    x: float | None = None
    y: float | None = None
    outline: tuple[Corner, ...] | None = None

    def __post_init__(self) -> None:
        if self.outline is not None and self.x is None:
            if not 3 <= len(self.outline) <= MAX_CORNERS:
                raise MapperError("note.pin", f"An area has 3 to {MAX_CORNERS} corners.")
            if crosses_itself(self.outline):
                raise MapperError("note.pin", "The sides of the area cross: give its corners in order, once around it.")
            if is_thin(self.outline):
                raise MapperError("note.pin", "An area needs corners that are not in one line.")
            for name, value in zip(("x", "y"), centroid(self.outline), strict=True):
                object.__setattr__(self, name, value)
        if (self.x is None) != (self.y is None) or (self.at_s is None) != (self.scan is None):
            raise MapperError(
                "note.pin", "A note’s position needs x and y, and its time needs the seconds and the scan."
            )
        if self.at_s is None and self.x is None:
            raise MapperError("note.pin", "A note is pinned to a time, to a place, or to both.")


@dataclass(frozen=True, slots=True)
class NoteAnswer:
    """A note in the HTTP interface, with the fields of its :class:`Pin`; ``mine`` says whether the visitor wrote it."""

    id: str
    text: str
    at_s: float | None
    scan: int | None
    x: float | None
    y: float | None
    outline: list[Corner] | None
    created_s: float
    changed_s: float
    mine: bool


@dataclass(frozen=True, slots=True)
class Note:
    """A note of ``author`` on a log."""

    id: str
    author: str
    log_id: str
    created_s: float
    changed_s: float
    text: str
    pin: Pin

    def public(self, visitor: str) -> NoteAnswer:
        """Return the answer of the HTTP interface for a visitor."""
        pin = self.pin
        return NoteAnswer(
            id=self.id,
            text=self.text,
            at_s=pin.at_s,
            scan=pin.scan,
            x=pin.x,
            y=pin.y,
            outline=None if pin.outline is None else list(pin.outline),
            created_s=self.created_s,
            changed_s=self.changed_s,
            mine=self.author == visitor,
        )


class Notes:
    """The notes on all logs, in the database. Anyone who may open a log sees all notes on it and can change their own.

    All methods raise ``StorageError``.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    async def of(self, log_id: str) -> Sequence[Note]:
        """Return the notes on a log, oldest first."""
        return await self._database.run(lambda connection: _load(connection, log_id))

    async def add(self, author: str, record: Record, text: str, pin: Pin) -> Note:
        """Return a new note of ``author`` on a log. Raises :class:`LimitError` for too many notes."""
        now = time.time()
        note = Note(secrets.token_hex(10), author, record.id, now, now, _plain(text), pin)

        def work(connection: Connection) -> None:
            if connection.execute(select(logs.c.id).where(logs.c.id == record.id)).first() is None:
                upsert_log(connection, record)  # otherwise the sample has no row
            of_log = notes.c.log_id == record.id
            count = select(func.count()).select_from(notes)
            if connection.execute(count.where(of_log)).scalar_one() >= MAX_NOTES_OF_LOG:
                raise _too_many(f"The log has {MAX_NOTES_OF_LOG} notes")
            if connection.execute(count.where(of_log, notes.c.author == author)).scalar_one() >= MAX_NOTES_OF_AUTHOR:
                raise _too_many(f"You have {MAX_NOTES_OF_AUTHOR} notes on this log")
            connection.execute(insert(notes).values(_row(note)))

        await self._database.run(work)
        return note

    async def change(self, author: str, log_id: str, note_id: str, text: str, pin: Pin) -> Note:
        """Return a note of ``author`` with another text and pin. Raises like :meth:`remove`."""

        def work(connection: Connection) -> Note:
            note = _own(connection, author, log_id, note_id)
            changed = replace(note, text=_plain(text), pin=pin, changed_s=time.time())
            connection.execute(update(notes).where(notes.c.id == note_id).values(_row(changed)))
            return changed

        return await self._database.run(work)

    async def remove(self, author: str, log_id: str, note_id: str) -> None:
        """Delete a note of ``author``.

        Raises :class:`NoteNotFoundError`, and :class:`NoteReadOnlyError` for another visitor's.
        """

        def work(connection: Connection) -> None:
            _own(connection, author, log_id, note_id)
            connection.execute(delete(notes).where(notes.c.id == note_id))

        await self._database.run_deletion(work)


def _too_many(count: str) -> LimitError:
    return LimitError("note.too_many", f"{count}, the maximum: delete one.")


def _load(connection: Connection, log_id: str) -> Sequence[Note]:
    rows = connection.execute(select(notes).where(notes.c.log_id == log_id).order_by(notes.c.created_s, notes.c.id))
    return [_note(row) for row in rows]


def _own(connection: Connection, author: str, log_id: str, note_id: str) -> Note:
    row = connection.execute(select(notes).where(notes.c.id == note_id, notes.c.log_id == log_id)).first()
    if row is None:
        raise NoteNotFoundError("note.not_found", "There is no such note on this log; it may have been deleted.")
    note = _note(row)
    if note.author != author:
        raise NoteReadOnlyError("note.read_only", "This note is another visitor’s.")
    return note


def _note(row: Row[Any]) -> Note:
    outline = None if row.outline is None else tuple((x, y) for x, y in json.loads(row.outline))
    pin = Pin(row.at_s, row.scan, row.x, row.y, outline)
    return Note(row.id, row.author, row.log_id, row.created_s, row.changed_s, row.text, pin)


def _row(note: Note) -> dict[str, object]:
    pin = note.pin
    return {
        "id": note.id,
        "author": note.author,
        "log_id": note.log_id,
        "created_s": note.created_s,
        "changed_s": note.changed_s,
        "text": note.text,
        "at_s": pin.at_s,
        "scan": pin.scan,
        "x": pin.x,
        "y": pin.y,
        "outline": None if pin.outline is None else json.dumps(pin.outline),
    }


def _plain(text: str) -> str:
    """Return a text in a form that every database accepts."""
    return text.encode("utf-8", "replace").decode().replace("\0", "")
