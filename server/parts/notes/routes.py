"""``/api/sessions/{id}/notes``: the notes on a session's log. Guests of a link can only read them."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Response
from pydantic import BaseModel, Field, FiniteFloat, StringConstraints

from server.downloads.names import disposition, file_name
from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.routes.maps import stem_of
from server.http.services import Logs, Sessions, Visitor
from server.http.session_access import SessionOfLog, session_of_log, writable_session
from server.library.annotations.note_files import MapFrame, notes_as_csv, notes_as_geojson
from server.library.annotations.notes import MAX_CORNERS, NoteAnswer, Pin
from server.library.library import Library
from server.library.logs.records import Record
from server.parts.notes.messages import NotesMessage
from server.sessions import SessionRegistry
from server.sessions.parts import Recording

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

Place = Annotated[FiniteFloat, Field(ge=-1e7, le=1e7)]


class NewNote(BaseModel, extra="forbid"):
    """A note as written by its author."""

    text: Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=2000)]
    at_s: FiniteFloat | None = Field(None, ge=-1e10, le=1e10, description="Seconds after the log's first scan.")
    scan: int | None = Field(None, ge=0, le=10_000_000, description="Number of scans in the map at that time.")
    x: Place | None = Field(None, description="Place on the map, metres.")
    y: Place | None = Field(None, description="Place on the map, metres.")

    outline: list[tuple[Place, Place]] | None = Field(
        None,
        min_length=3,
        max_length=MAX_CORNERS,
        description="Corners of an area on the map, metres; its centroid is the place.",
    )

    def pin(self) -> Pin:
        """Return the place and time of the note."""
        if self.outline is not None:
            return Pin(self.at_s, self.scan, outline=tuple(self.outline))
        return Pin(self.at_s, self.scan, self.x, self.y)


def _writable(sessions: SessionRegistry, library: Library, session_id: str) -> Record:
    of_log = writable_session(sessions, session_id)
    return library.get(of_log.owner, of_log.log_id)


def _announce(sessions: SessionRegistry, log_id: str) -> None:
    """Make the pages of all sessions on a log, including guests', request its notes again."""
    for session in sessions.all():
        recording = session.model.find(Recording)
        if recording is not None and recording.log_id == log_id:
            session.announce(NotesMessage(time.time()))


@dataclass(frozen=True, slots=True)
class NoteList:
    """The notes on a log, oldest first."""

    notes: list[NoteAnswer]


@router.get("/{session_id}/notes")
@guests_may(GuestRight.LINKED_SESSION)
async def notes(sessions: Sessions, library: Logs, visitor: Visitor, session_id: str) -> NoteList:
    """Return the notes on the session's log, oldest first. ``mine`` marks those that this visitor may change."""
    of_log = session_of_log(sessions, session_id)
    pinned = await library.notes.of(of_log.log_id)
    is_guest = of_log.session.link is not None
    return NoteList([note.public("" if is_guest else visitor) for note in pinned])


@router.get("/{session_id}/notes.geojson", **file_answer("application/geo+json"))
@guests_may(GuestRight.LINKED_SESSION)
async def notes_geojson(sessions: Sessions, library: Logs, session_id: str) -> Response:
    """Return the notes on the session's log as GeoJSON. Coordinates are metres in the frame of the poses."""
    of_log = session_of_log(sessions, session_id)
    pinned = await library.notes.of(of_log.log_id)
    text = await asyncio.to_thread(notes_as_geojson, pinned, _frame_of(of_log), of_log.session.model.title)
    return _as_file(of_log, text, "geojson", "application/geo+json")


@router.get("/{session_id}/notes.csv", **file_answer("text/csv"))
@guests_may(GuestRight.LINKED_SESSION)
async def notes_csv(sessions: Sessions, library: Logs, session_id: str) -> Response:
    """Return the notes on the session's log as a table. Coordinates are metres in the frame of the poses."""
    of_log = session_of_log(sessions, session_id)
    pinned = await library.notes.of(of_log.log_id)
    text = await asyncio.to_thread(notes_as_csv, pinned, _frame_of(of_log))
    return _as_file(of_log, text, "csv", "text/csv")


def _frame_of(of_log: SessionOfLog) -> MapFrame:
    trajectory = of_log.recording.log.trajectories[of_log.recording.trajectory]
    return MapFrame(trajectory.frame_id or "map", trajectory.offset)


def _as_file(of_log: SessionOfLog, text: str, ending: str, media_type: str) -> Response:
    name = file_name(f"{stem_of(of_log.session)}_notes", ending)
    return Response(text, media_type=media_type, headers={"Content-Disposition": disposition(name)})


@router.post("/{session_id}/notes", status_code=201)
async def add(sessions: Sessions, library: Logs, visitor: Visitor, session_id: str, written: NewNote) -> NoteAnswer:
    """Attach a note to a time of the session's log, to a place on its map, or to both."""
    record = _writable(sessions, library, session_id)
    note = await library.notes.add(visitor, record, written.text, written.pin())
    _announce(sessions, record.id)
    return note.public(visitor)


@router.put("/{session_id}/notes/{note_id}")
async def change(
    sessions: Sessions, library: Logs, visitor: Visitor, session_id: str, note_id: str, written: NewNote
) -> NoteAnswer:
    """Change the text and the place or time of one's own note."""
    record = _writable(sessions, library, session_id)
    note = await library.notes.change(visitor, record.id, note_id, written.text, written.pin())
    _announce(sessions, record.id)
    return note.public(visitor)


@router.delete("/{session_id}/notes/{note_id}", status_code=204)
async def remove(sessions: Sessions, library: Logs, visitor: Visitor, session_id: str, note_id: str) -> None:
    """Delete one's own note."""
    record = _writable(sessions, library, session_id)
    await library.notes.remove(visitor, record.id, note_id)
    _announce(sessions, record.id)
