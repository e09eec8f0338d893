"""``/api/sessions/{id}/doctor``: the diagnosis of the log that a session shows."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from msgspec import to_builtins

from mapper.core.errors import MapperError
from mapper.io.logs.summary import recorded_seconds
from server.http.guests import GuestRight, guests_may
from server.http.routes.clients import while_connected
from server.http.services import Sessions, Visitor
from server.sessions.parts import Recording
from server.stream.answers import LogEvent

router = APIRouter(prefix="/api", tags=["sessions"])


@router.get("/sessions/{session_id}/doctor")
@guests_may(GuestRight.LINKED_SESSION)
async def doctor(
    request: Request,
    sessions: Sessions,
    visitor: Visitor,
    session_id: str,
    name: Annotated[
        str | None, Query(max_length=100, description="Name under which /api/sessions/making/{name} has the progress.")
    ] = None,
) -> dict[str, Any]:
    """Return the diagnosis of the session's log with its current trajectory, and the events of its recording.

    ``seconds`` of a finding are those of its ``scans`` in recorded time, from the log's first scan.

    The examination ends when every client that waits for it has disconnected.
    """
    recording = sessions.get(session_id).model.find(Recording)
    if recording is None:
        raise MapperError("session.not_a_log", "Only a log can be examined, not a simulation.")
    trajectory = recording.trajectory  # which may be another one when the examination is over
    with sessions.under_way.making(visitor, name) as making:
        making.watched = lambda: ("Examining the log", recording.examined_share)
        found = await while_connected(request, recording.examined())
    seconds = recorded_seconds(recording.log)
    return {
        "trajectory": trajectory,
        "findings": [
            {**finding.public(), "seconds": [round(float(seconds[scan]), 3) for scan in finding.scans]}
            for finding in found.findings
        ],
        "events": [to_builtins(LogEvent(**event.public())) for event in found.events],
    }
