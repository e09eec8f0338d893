"""``/api/logs/{id}/trajectories/{name}``: add a trajectory to a log, read it, and delete it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Annotated

from fastapi import APIRouter, Path, Request
from fastapi.responses import Response
from starlette.requests import ClientDisconnect

from server.downloads.names import disposition, file_name, file_stem
from server.http.routes.clients import client_address
from server.http.services import Logs, Sessions, Visitor
from server.library.library import Library
from server.library.logs.records import TrajectoryAnswer
from server.sessions import SessionRegistry
from server.sessions.commands import UpdateLog
from server.sessions.parts import Recording
from server.stream.protocol import ProtocolError

router = APIRouter(prefix="/api/logs", tags=["logs"])

Name = Annotated[str, Path(max_length=400, description="Name of the trajectory.")]


@dataclass(frozen=True, slots=True)
class AddedTrajectory(TrajectoryAnswer):
    """A trajectory that was added, with notes on how it was joined to the scans."""

    notes: tuple[str, ...] = ()


@router.put("/{log_id}/trajectories/{name}", status_code=201, response_model=AddedTrajectory)
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
        return Response(status_code=400)  # the client has gone
    await update_sessions(library, sessions, visitor, log_id)
    return AddedTrajectory(**asdict(added.public()), notes=tuple(notes))


@router.get("/{log_id}/trajectories/{name}")
async def get(library: Logs, visitor: Visitor, log_id: str, name: Name) -> Response:
    """Return a trajectory that the visitor has added, as a TUM file."""
    library.get(visitor, log_id)
    text = await library.trajectories.text(visitor, log_id, name)
    headers = {"Content-Disposition": disposition(file_name(file_stem(name), "tum"))}
    return Response(text, media_type="text/plain; charset=utf-8", headers=headers)


@router.delete("/{log_id}/trajectories/{name}", status_code=204)
async def delete(library: Logs, sessions: Sessions, visitor: Visitor, log_id: str, name: Name) -> None:
    """Delete a trajectory that the visitor has added. Sessions that map with it go on."""
    library.get(visitor, log_id)
    await library.trajectories.delete(visitor, log_id, name)
    await update_sessions(library, sessions, visitor, log_id)


async def update_sessions(library: Library, sessions: SessionRegistry, owner: str, log_id: str) -> None:
    """Let the open sessions of ``owner`` on a log have its present trajectories."""
    for session in sessions.all():
        recording = session.model.find(Recording)
        if recording is None or recording.log_id != log_id or session.owner != owner or session.link is not None:
            continue
        view = recording.view()
        log = await library.load(owner, log_id, view.topic, view.planar_cut)
        with suppress(ProtocolError):  # of too many commands; the next session on the log has them
            session.enqueue(UpdateLog(log))
