"""``/api/logs/{id}/trajectories/{name}``: add a trajectory to a log, read it, delete it, and score poses.

``/api/sessions/{id}/trajectories/{name}`` belong to the visitor who began the session.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Annotated

from fastapi import APIRouter, Path, Query, Request
from fastapi.responses import Response
from starlette.requests import ClientDisconnect

from server.downloads.names import disposition, file_name, file_stem
from server.http.clients import client_address, while_connected
from server.http.file_answer import FILE_BODY, file_answer
from server.http.following import update_sessions
from server.http.services import Logs, Sessions, Visitor
from server.http.session_access import writable_session
from server.library.logs.records import TrajectoryAnswer
from server.library.processing.relation_scores import PoseScore, relations_text

router = APIRouter(prefix="/api", tags=["logs"])

Name = Annotated[str, Path(max_length=400, description="Name of the trajectory.")]


@dataclass(frozen=True, slots=True)
class AddedTrajectory(TrajectoryAnswer):
    """An added trajectory, with notes on how it was joined to the scans."""

    notes: tuple[str, ...] = ()


@router.put(
    "/logs/{log_id}/trajectories/{name}", status_code=201, response_model=AddedTrajectory, openapi_extra=FILE_BODY
)
async def put(
    request: Request, library: Logs, sessions: Sessions, visitor: Visitor, log_id: str, name: Name
) -> AddedTrajectory | Response:
    """Add a trajectory to a log: the body is the text of a TUM file, joined to the scans by their stamps.

    It replaces the visitor's trajectory of that name. Only the visitor sees it, and guests of the visitor's links.
    Scans before the first or after the last pose continue it by the log's own poses.
    """
    try:
        added, notes = await library.add_trajectory(
            visitor, log_id, name, request.stream(), address=client_address(request)
        )
    except ClientDisconnect:
        return Response(status_code=400)  # the client has disconnected
    await update_sessions(library, sessions, visitor, log_id)
    return AddedTrajectory(**asdict(added.public()), notes=tuple(notes))


@router.get("/logs/{log_id}/trajectories/{name}", **file_answer("text/plain"))
async def get(library: Logs, visitor: Visitor, log_id: str, name: Name) -> Response:
    """Return a trajectory added by the visitor, as a TUM file."""
    library.get(visitor, log_id)
    text = await library.trajectories.text(visitor, log_id, name)
    headers = {"Content-Disposition": disposition(file_name(file_stem(name), "tum"))}
    return Response(text, media_type="text/plain; charset=utf-8", headers=headers)


@router.delete("/logs/{log_id}/trajectories/{name}", status_code=204)
async def delete(library: Logs, sessions: Sessions, visitor: Visitor, log_id: str, name: Name) -> None:
    """Delete a trajectory added by the visitor. Sessions that use it continue."""
    library.get(visitor, log_id)
    await library.trajectories.delete(visitor, log_id, name)
    await update_sessions(library, sessions, visitor, log_id)


@router.put(
    "/sessions/{session_id}/trajectories/{name}",
    status_code=201,
    response_model=AddedTrajectory,
    openapi_extra=FILE_BODY,
)
async def put_of_session(
    request: Request, library: Logs, sessions: Sessions, session_id: str, name: Name
) -> AddedTrajectory | Response:
    """Add a trajectory to the session's log: the body is the text of a TUM file, joined to the scans by their stamps.

    It replaces the trajectory of that name that belongs to the visitor who began the session.
    """
    of_log = writable_session(sessions, session_id)
    return await put(request, library, sessions, of_log.owner, of_log.log_id, name)


@router.get("/sessions/{session_id}/trajectories/{name}", **file_answer("text/plain"))
async def get_of_session(library: Logs, sessions: Sessions, session_id: str, name: Name) -> Response:
    """Return an added trajectory of the session's log, as a TUM file."""
    of_log = writable_session(sessions, session_id)
    return await get(library, of_log.owner, of_log.log_id, name)


@router.delete("/sessions/{session_id}/trajectories/{name}", status_code=204)
async def delete_of_session(library: Logs, sessions: Sessions, session_id: str, name: Name) -> None:
    """Delete an added trajectory of the session's log. Sessions that use it continue."""
    of_log = writable_session(sessions, session_id)
    await delete(library, sessions, of_log.owner, of_log.log_id, name)


@router.put("/sessions/{session_id}/relations", openapi_extra=FILE_BODY)
async def score(
    request: Request,
    library: Logs,
    sessions: Sessions,
    visitor: Visitor,
    session_id: str,
    name: Annotated[str, Query(max_length=200, description="Name of the file, as intel.relations.")] = "relations",
) -> PoseScore:
    """Return the mean errors of the current trajectory over known relations. The body is their file.

    The definitions are those of ``gridbloom evaluate --relations``. The file is not stored.
    """
    of_log = writable_session(sessions, session_id)
    recording = of_log.recording
    log, trajectory, topic = recording.log, recording.trajectory, recording.view().topic
    text = await relations_text(request.stream())
    record = library.get(of_log.owner, of_log.log_id)
    score = library.scores.score(record, visitor, log, trajectory, text, name, topic, address=client_address(request))
    return await while_connected(request, score)
