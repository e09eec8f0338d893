"""``/api/sessions``, ``/api/worlds``, ``/api/parameters``: create, inspect and end sessions."""

from __future__ import annotations

import time
from dataclasses import asdict
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Body, Request
from fastapi.responses import JSONResponse, Response
from pydantic import BaseModel, ConfigDict, Field

from mapper.core.errors import MapperError
from mapper.mapping.parameters import PARAMETERS
from mapper.simulation import SENSOR_PARAMETERS, WORLDS
from server.http.guests import GuestRight, guests_may
from server.http.routes.clients import client_address, while_connected
from server.http.services import Logs, Sessions, Visitor
from server.library import Library
from server.sessions import LogView, Session, SessionRegistry, SimulationSession

router = APIRouter(prefix="/api", tags=["sessions"])


class Story(BaseModel):
    """The history of a simulation: enough to reproduce the world, its recording and its map."""

    model_config = ConfigDict(extra="ignore")

    sensor: dict[str, Any] = Field({}, description="Values of the simulated sensor at the beginning.")
    edits: dict[str, list[Any]] = Field({}, description="What was drawn and erased at the beginning: added, erased.")
    steps: int = Field(0, ge=0, description="Physics steps of 0.02 s since the beginning.")
    journal: list[tuple[int, dict[str, Any]]] | None = Field(
        None, description="Each action and the step before which it came; null where only the pose is known."
    )
    pose: tuple[float, float, float] | None = Field(None, description="Where the robot is now, where journal is null.")
    auto: bool = Field(True, description="Whether it walks by itself then.")
    parameters: dict[str, Any] = Field({}, description="Mapping parameters that differ from a new world's.")
    faults: dict[str, Any] = Field({}, description="The robot's faults.")
    playing: bool = Field(True, description="Whether time goes on.")
    speed: float | None = Field(None, description="Seconds of the world's time in a second.")


class NewSimulation(BaseModel):
    """A session of a live world."""

    model_config = ConfigDict(extra="forbid")

    kind: Literal["simulation"]
    playing: bool = Field(True, description="Whether time goes on from the start; false stands still, story or not.")
    world: str | None = Field(
        None, max_length=100, description="Name of the world; the first one where it is left out."
    )
    seed: int | None = Field(None, ge=0, lt=2**31, description="The same seed and commands give the same scans.")
    story: Story | None = Field(None, description="What happened in a world before, as /api/sessions/{id}/story tells.")
    name: str | None = Field(
        None, max_length=100, description="A name under which /api/sessions/making/{name} tells how far the replay is."
    )


class NewLog(BaseModel):
    """A session of a log."""

    model_config = ConfigDict(extra="forbid")

    kind: Literal["log"]
    playing: bool = Field(True, description="Whether scans come in from the start.")
    log: str = Field(max_length=200, description="Id of the log, as /api/logs gives it.")
    topic: str | None = Field(None, max_length=400, description="Which of the log's sensors, where it has several.")
    trajectory: str | None = Field(None, max_length=200, description="Which of the log's trajectories to map with.")


def public(session: Session) -> dict[str, Any]:
    """Return what the HTTP interface shows of a session."""
    index, count = session.progress
    return {
        "id": session.id,
        "kind": session.kind,
        "title": session.title,
        "stream": f"/api/sessions/{session.id}/stream",
        "playing": session.playing,
        "index": index,
        "count": count,
        "watching": len(session.hub.clients),
    }


@router.post("/sessions", status_code=201)
async def create(
    request: Request,
    wanted: Annotated[NewSimulation | NewLog, Body(discriminator="kind")],
    sessions: Sessions,
    library: Logs,
    visitor: Visitor,
) -> Response:
    """Begin a session on a live world or on a log. If the client disconnects, the work is cancelled."""
    return await while_connected(request, _create(wanted, sessions, library, visitor, client_address(request)))


async def _create(
    wanted: NewSimulation | NewLog, sessions: SessionRegistry, library: Library, visitor: str, address: str
) -> Response:
    session: Session
    if isinstance(wanted, NewSimulation):
        story = None if wanted.story is None else wanted.story.model_dump()
        session = await sessions.create_world(
            visitor, wanted.world, wanted.seed, story, playing=wanted.playing, address=address, name=wanted.name
        )
    else:
        log = await library.load(visitor, wanted.log, wanted.topic)
        title = library.get(visitor, wanted.log).name
        view = LogView(wanted.topic, wanted.trajectory)
        session = await sessions.create_log(
            visitor, log, log_id=wanted.log, title=title, view=view, playing=wanted.playing, address=address
        )
    return JSONResponse(public(session), status_code=201, headers={"Location": f"/api/sessions/{session.id}"})


@router.get("/sessions")
async def mine(sessions: Sessions, visitor: Visitor) -> dict[str, Any]:
    """List the sessions that this visitor began."""
    return {"sessions": [public(s) for s in sessions.all() if s.owner == visitor]}


@router.get("/sessions/making/{name}")
async def making(sessions: Sessions, visitor: Visitor, name: str) -> dict[str, Any]:
    """Return the progress of a session that is being created for this visitor: fraction (0 to 1) and seconds."""
    under_way = sessions.under_way.get(visitor, name)
    return {"fraction": round(under_way.fraction, 3), "elapsed_s": round(time.monotonic() - under_way.began, 2)}


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
async def story(sessions: Sessions, session_id: str) -> dict[str, Any]:
    """Return the history of a live world, from which another session can begin."""
    session = sessions.get(session_id)
    if not isinstance(session, SimulationSession):
        raise MapperError("session.not_a_world", "Only a live world has a story; a log is its own.")
    return await session.story()


@router.get("/worlds")
async def worlds() -> dict[str, Any]:
    """List the simulated worlds."""
    return {
        "worlds": [{"name": w.name, "title": w.title, "bounds": [float(v) for v in w.bounds]} for w in WORLDS.values()]
    }


@router.get("/parameters")
async def parameters() -> dict[str, Any]:
    """Return the tables of mapping parameters and of the simulated sensor's parameters."""
    return {"parameters": [asdict(row) for row in PARAMETERS], "sensor": [asdict(row) for row in SENSOR_PARAMETERS]}
