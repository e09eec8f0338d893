"""``/api/sessions/{id}/report``: the report on a session's log as one page, and ``report.pdf`` as PDF."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

import server.report
from mapper.core.errors import MapperError
from mapper.io.contents.model import CAMERAS
from mapper.mapping.parameters import MappingConfig
from server.http.clients import client_address, in_turn, while_connected
from server.http.routes.contents import HeldContents
from server.http.services import Logs, RequestWork, Sessions, Visitor
from server.http.session_access import SessionOfLog, session_of_log
from server.library.library import Library

if TYPE_CHECKING:
    from server.report import Picture

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

#: The page has no scripts and sends no requests.
HEADERS = {"Cache-Control": "private, no-store"}
CSP = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; frame-ancestors 'self'"


@router.get("/{session_id}/report", response_class=HTMLResponse)
async def report(
    request: Request, sessions: Sessions, library: Logs, visitor: Visitor, work: RequestWork, session_id: str
) -> HTMLResponse:
    """Return the report: facts, events, findings, maps before and after a correction, a picture, notes, parameters.

    The log is examined first if necessary, which can take a while.
    """
    page = await _page(request, sessions, library, visitor, work, session_id)
    return HTMLResponse(page, headers=HEADERS | {"Content-Security-Policy": CSP})


@router.get("/{session_id}/report.pdf", response_class=Response, responses={200: {"content": {"application/pdf": {}}}})
async def report_as_pdf(
    request: Request, sessions: Sessions, library: Logs, visitor: Visitor, work: RequestWork, session_id: str
) -> Response:
    """Return the report as PDF; 501 if the service lacks the software for that."""
    page = await _page(request, sessions, library, visitor, work, session_id)
    pdf = await in_turn(request, work, visitor, lambda: server.report.report_pdf(page))
    named = {"Content-Disposition": 'inline; filename="report.pdf"'}
    return Response(pdf, media_type="application/pdf", headers=HEADERS | named)


async def _page(
    request: Request, sessions: Sessions, library: Logs, visitor: Visitor, work: RequestWork, session_id: str
) -> str:
    of_log = session_of_log(sessions, session_id)
    recording = of_log.recording
    record = library.get(of_log.owner, of_log.log_id)
    diagnosis = await while_connected(request, recording.examined())
    view, trajectory, log = recording.view(), recording.trajectory, recording.log
    config = recording.first_config() if view.values is None else MappingConfig().with_values(view.values)
    scan = diagnosis.events[0].scan if diagnosis.events else log.n_scans // 2
    seconds = float(recording.recorded[scan]) if log.n_scans else 0.0
    picture = await while_connected(request, _picture(request, library, of_log, visitor, seconds))
    notes = [server.report.PlacedNote.of(note.text, note.pin) for note in await library.notes.of(record.id)]
    return await in_turn(
        request,
        work,
        visitor,
        lambda: server.report.report_page(
            server.report.make_report(
                log, trajectory, diagnosis, config, title=record.name, picture=picture, notes=notes
            )
        ),
    )


async def _picture(
    request: Request, library: Library, of_log: SessionOfLog, visitor: str, seconds: float
) -> Picture | None:
    """Return a picture from the first camera at a moment; None if there is none, or the contents are unknown."""
    address = client_address(request)
    try:
        contents = await library.contents(of_log.owner, of_log.log_id, visitor, address=address)
        if isinstance(contents, float):
            return None
        held = HeldContents(of_log.recording, contents)
        topic = next((topic.name for topic in contents.topics if topic.type in CAMERAS), None)
        if topic is None:
            return None
        at_ns = held.recorded_ns(seconds)
        picture = await library.picture(of_log.owner, of_log.log_id, visitor, topic, at_ns, address=address)
    except MapperError:
        return None  # the report does not need a readable picture
    return server.report.Picture(
        picture.data, picture.media_type, topic, held.seconds(picture.stamp_ns - held.recorded_ahead_ns)
    )
