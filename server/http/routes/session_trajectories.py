"""``/api/sessions/{id}/trajectories/{name}``: add a trajectory to a session's log, read it, and delete it.

They are the trajectories of the visitor who began the session, see :mod:`server.http.routes.trajectories`.
"""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.http.file_answer import file_answer
from server.http.routes import trajectories
from server.http.routes.trajectories import AddedTrajectory, Name
from server.http.services import Logs, Sessions
from server.http.session_access import writable_session

router = APIRouter(prefix="/api/sessions", tags=["sessions"])


@router.put("/{session_id}/trajectories/{name}", status_code=201, response_model=AddedTrajectory)
async def put(
    request: Request, library: Logs, sessions: Sessions, session_id: str, name: Name
) -> AddedTrajectory | Response:
    """Add a trajectory to the session's log: the body is the text of a TUM file, joined to the scans by their stamps.

    It replaces the trajectory of that name of the visitor who began the session.
    """
    of_log = writable_session(sessions, session_id)
    return await trajectories.put(request, library, sessions, of_log.owner, of_log.log_id, name)


@router.get("/{session_id}/trajectories/{name}", **file_answer("text/plain"))
async def get(library: Logs, sessions: Sessions, session_id: str, name: Name) -> Response:
    """Return a trajectory that was added to the session's log, as a TUM file."""
    of_log = writable_session(sessions, session_id)
    return await trajectories.get(library, of_log.owner, of_log.log_id, name)


@router.delete("/{session_id}/trajectories/{name}", status_code=204)
async def delete(library: Logs, sessions: Sessions, session_id: str, name: Name) -> None:
    """Delete a trajectory that was added to the session's log. Sessions that map with it go on."""
    of_log = writable_session(sessions, session_id)
    await trajectories.delete(library, sessions, of_log.owner, of_log.log_id, name)
