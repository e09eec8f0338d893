"""``/api/sessions``, ``/api/worlds``, ``/api/parameters``: create, inspect and end sessions, and their streams."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Body, Query, Request, WebSocket
from fastapi.responses import Response

from mapper import simulation
from mapper.core.errors import MapperError
from mapper.core.parameter import Parameter
from mapper.mapping.parameters import PARAMETERS
from mapper.sensors.planar.options import PARAMETERS as CUT_PARAMETERS
from server.http.clients import chosen_place, client_address, while_connected
from server.http.following import join_jobs
from server.http.guests import GuestRight, guests_may
from server.http.services import Logs, ServiceSettings, Sessions, Visitor
from server.imports import imported
from server.sessions import Kind
from server.sessions.kind import SessionRequest
from server.sources.history import Replayable, SimulationHistory
from server.stream.protocol import PAGE_NAME

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api", tags=["sessions"])


@dataclass(frozen=True, slots=True)
class SessionAnswer:
    """A session: the map has ``index`` of ``count`` scans, and ``watching`` clients receive its ``stream``."""

    id: str
    kind: str
    title: str
    stream: str
    playing: bool
    index: int
    count: int
    watching: int


@dataclass(frozen=True, slots=True)
class SessionList:
    """Sessions that a visitor began."""

    sessions: list[SessionAnswer]


@dataclass(frozen=True, slots=True)
class MakingAnswer:
    """The progress of a session being created; ``what`` is null for the request itself.

    ``fraction`` is the completed share, 0 to 1, null if unknown.
    """

    what: str | None
    fraction: float | None
    elapsed_s: float


@dataclass(frozen=True, slots=True)
class WorldAnswer:
    """A simulated world; ``bounds`` are the least and greatest x and y, metres."""

    name: str
    title: str
    bounds: tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class WorldList:
    """The simulated worlds."""

    worlds: list[WorldAnswer]


@dataclass(frozen=True, slots=True)
class ParameterTables:
    """The tables of mapping parameters, of the simulated sensor's, and of the options for cutting scans from clouds."""

    parameters: tuple[Parameter, ...]
    sensor: tuple[Parameter, ...]
    cut: tuple[Parameter, ...]


def public(session: SessionHost) -> SessionAnswer:
    """Return the answer of the HTTP interface about a session."""
    model = session.model
    index, count = model.progress
    return SessionAnswer(
        id=session.id,
        kind=model.kind,
        title=model.title,
        stream=f"/api/sessions/{session.id}/stream",
        playing=model.playback.playing,
        index=index,
        count=count,
        watching=len(session.hub.clients),
    )


def created(response: Response, session: SessionHost) -> SessionAnswer:
    """Return the answer to the creation of a session, and set its address in the ``response``."""
    response.headers["Location"] = f"/api/sessions/{session.id}"
    return public(session)


def creating(kinds: Mapping[str, Kind]) -> APIRouter:
    """Return the route that begins sessions of these kinds. Its body is the request of one of them, by ``kind``."""
    router = APIRouter(prefix="/api", tags=["sessions"])

    async def create(
        request: Request,
        response: Response,
        body: SessionRequest,
        sessions: Sessions,
        library: Logs,
        visitor: Visitor,
    ) -> SessionAnswer:
        """Begin a session. If the client disconnects, the work is cancelled."""
        where = {"address": client_address(request), "place": chosen_place(request)}
        work = sessions.create(kinds[body.kind], body, visitor, library, **where)
        session = await while_connected(request, work)
        join_jobs(library, sessions, session)
        return created(response, session)

    requests = reduce(or_, (kind.request for kind in kinds.values()))
    create.__annotations__["body"] = Annotated[requests, Body(discriminator="kind")]
    router.post("/sessions", status_code=201)(create)
    return router


@router.get("/sessions")
async def mine(sessions: Sessions, visitor: Visitor) -> SessionList:
    """List the sessions that this visitor began."""
    return SessionList([public(session) for session in sessions.all() if session.owner == visitor])


@router.get(
    "/sessions/making/{name}",
    response_model=MakingAnswer,
    responses={204: {"description": "No session of that name is being created."}},
)
@guests_may(GuestRight.ALWAYS)
async def making(sessions: Sessions, visitor: Visitor, name: str) -> MakingAnswer | Response:
    """Return the progress of a session being created for this visitor.

    It consists of the current part of the work (null: the request itself), its completed share (0 to 1; null if
    unknown), and the seconds since the start; nothing (204) if no session of that name is being created.
    """
    under_way = sessions.under_way.get(visitor, name)
    if under_way is None:
        return Response(status_code=204)
    what, fraction = under_way.progress()
    elapsed_s = round(time.monotonic() - under_way.began, 2)
    return MakingAnswer(what, None if fraction is None else round(fraction, 3), elapsed_s)


@router.get("/sessions/{session_id}")
@guests_may(GuestRight.LINKED_SESSION)
async def one(sessions: Sessions, session_id: str) -> SessionAnswer:
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
async def history(sessions: Sessions, session_id: str) -> SimulationHistory:
    """Return the history of a simulation, with which another session can begin."""
    replayable = sessions.get(session_id).model.find(Replayable)
    if replayable is None:
        raise MapperError("session.not_a_world", "Only a simulation has a story.")
    return await replayable.present_history()


@router.get("/worlds")
def worlds() -> WorldList:
    """List the simulated worlds."""
    return WorldList([WorldAnswer(world.name, world.title, world.bounds) for world in simulation.WORLDS.values()])


@router.get("/parameters")
def parameters() -> ParameterTables:
    """Return the tables of mapping parameters, of the sensor's, and of the options for cutting scans from clouds."""
    return ParameterTables(PARAMETERS, simulation.SENSOR_PARAMETERS, CUT_PARAMETERS)


@router.websocket("/sessions/{session_id}/stream")
@guests_may(GuestRight.LINKED_SESSION)
async def stream(
    websocket: WebSocket,
    sessions: Sessions,
    settings: ServiceSettings,
    session_id: str,
    page: Annotated[str, Query(pattern=PAGE_NAME)] = "",
) -> None:
    """Exchange messages with a session; ``page`` is a name that the page chooses, for its 3D views."""
    await imported("server.http.stream_connection")
    from server.http.stream_connection import exchange  # noqa: PLC0415 - what it imports came with the first session

    session = sessions.get(session_id)
    await exchange(websocket, session, settings.max_clients_per_session, page=page)
