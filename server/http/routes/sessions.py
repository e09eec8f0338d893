"""``/api/sessions``, ``/api/worlds``, ``/api/parameters``: create, inspect and end sessions."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Body, Request
from fastapi.responses import JSONResponse, Response

from mapper.core.errors import MapperError
from mapper.mapping.parameters import PARAMETERS
from mapper.sensors.planar.options import PARAMETERS as CUT_PARAMETERS
from server.http.following import join_jobs
from server.http.guests import GuestRight, guests_may
from server.http.routes.clients import chosen_place, client_address, while_connected
from server.http.services import Logs, Sessions, Visitor
from server.sessions import Kind
from server.sessions.kind import SessionRequest
from server.sessions.parts import Story

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api", tags=["sessions"])


def public(session: SessionHost) -> dict[str, Any]:
    """Return what the HTTP interface shows of a session."""
    model = session.model
    index, count = model.progress
    return {
        "id": session.id,
        "kind": model.kind,
        "title": model.title,
        "stream": f"/api/sessions/{session.id}/stream",
        "playing": model.playback.playing,
        "index": index,
        "count": count,
        "watching": len(session.hub.clients),
    }


def creating(kinds: Mapping[str, Kind]) -> APIRouter:
    """Return the route that begins sessions of these kinds; its body is the request of one of them, by ``kind``."""
    router = APIRouter(prefix="/api", tags=["sessions"])

    async def create(
        request: Request, wanted: SessionRequest, sessions: Sessions, library: Logs, visitor: Visitor
    ) -> Response:
        """Begin a session. If the client disconnects, the work is cancelled."""
        where = {"address": client_address(request), "place": chosen_place(request)}
        work = sessions.create(kinds[wanted.kind], wanted, visitor, library, **where)
        session = await while_connected(request, work)
        join_jobs(library, sessions, session)
        return JSONResponse(public(session), status_code=201, headers={"Location": f"/api/sessions/{session.id}"})

    body = reduce(or_, (kind.request for kind in kinds.values()))
    create.__annotations__["wanted"] = Annotated[body, Body(discriminator="kind")]
    router.post("/sessions", status_code=201)(create)
    return router


@router.get("/sessions")
async def mine(sessions: Sessions, visitor: Visitor) -> dict[str, Any]:
    """List the sessions that this visitor began."""
    return {"sessions": [public(s) for s in sessions.all() if s.owner == visitor]}


@router.get("/sessions/making/{name}", responses={204: {"description": "No session of that name is being created."}})
@guests_may(GuestRight.ALWAYS)
async def making(sessions: Sessions, visitor: Visitor, name: str) -> Any:  # noqa: ANN401 - the progress, or no content
    """Return the progress of a session that is being created for this visitor.

    It is what is being done (null: what was asked for), the fraction of it that is done (0 to 1; null if not known),
    and the seconds since the beginning; nothing (204) if no session of that name is being created, or not any more.
    """
    under_way = sessions.under_way.get(visitor, name)
    if under_way is None:
        return Response(status_code=204)
    what, fraction = under_way.progress()
    return {
        "what": what,
        "fraction": None if fraction is None else round(fraction, 3),
        "elapsed_s": round(time.monotonic() - under_way.began, 2),
    }


@router.get("/sessions/{session_id}")
@guests_may(GuestRight.LINKED_SESSION)
async def one(sessions: Sessions, session_id: str) -> dict[str, Any]:
    """Return the state of a session."""
    return public(sessions.get(session_id))


@router.delete("/sessions/{session_id}", status_code=204)
async def end(sessions: Sessions, visitor: Visitor, session_id: str) -> None:
    """End a session that this visitor began."""
    session = sessions.get(session_id)
    if session.owner != visitor:
        raise MapperError("session.not_yours", "A session can only be ended by the visitor who began it.")
    await sessions.close(session_id)


@router.get("/sessions/{session_id}/story")
async def current_story(sessions: Sessions, session_id: str) -> dict[str, Any]:
    """Return the history of a simulation, from which another session can begin."""
    story = sessions.get(session_id).model.find(Story)
    if story is None:
        raise MapperError("session.not_a_world", "Only a simulation has a story.")
    return await story.current()


@router.get("/worlds")
def worlds() -> dict[str, Any]:
    """List the simulated worlds."""
    from mapper.simulation import WORLDS  # noqa: PLC0415 - imported with the first use, on a worker thread

    return {
        "worlds": [{"name": w.name, "title": w.title, "bounds": [float(v) for v in w.bounds]} for w in WORLDS.values()]
    }


@router.get("/parameters")
def parameters() -> dict[str, Any]:
    """Return the tables of mapping parameters, of the simulated sensor's, and of how a scan is cut out of a cloud."""
    from mapper.simulation import SENSOR_PARAMETERS  # noqa: PLC0415 - imported with the first use, on a worker thread

    tables = {"parameters": PARAMETERS, "sensor": SENSOR_PARAMETERS, "cut": CUT_PARAMETERS}
    return {name: [asdict(row) for row in rows] for name, rows in tables.items()}
