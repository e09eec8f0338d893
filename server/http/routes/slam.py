"""``/api/logs/{id}/slam``, ``/api/sessions/{id}/heal`` and ``/graph``: correct the poses of a log with SLAM."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Body, Query
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from mapper.core.errors import ConfigError, MapperError
from server.http.following import follow_slam, tell_at_end
from server.http.guests import GuestRight, guests_may
from server.http.routes.trajectories import update_sessions
from server.http.services import Logs, Sessions, Visitor
from server.library.library import Library
from server.library.logs.records import TrajectoryAnswer
from server.library.processing.slam import SlamRequest, SlamStatus, parameter_table
from server.sessions import SessionRegistry
from server.sessions.parts import Graphed, GraphSource, Recording
from server.sessions.view import GraphChange

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api", tags=["logs"])


class NewSlam(BaseModel):
    """SLAM of a log."""

    model_config = ConfigDict(extra="forbid")

    topic: str | None = Field(None, max_length=400, description="Sensor of the log, if it has several.")
    trajectory: str | None = Field(
        None, max_length=200, description="Trajectory to begin with; where it is left out, the log's odometry."
    )
    parameters: dict[str, Any] = Field(
        default_factory=dict, max_length=50, description="Parameters of SLAM, as GET /api/slam/parameters names them."
    )
    cut: dict[str, FiniteFloat] | None = Field(
        None,
        max_length=20,
        description="How scans are cut out of clouds and depth images, see /api/parameters; else as by default.",
    )
    mapping: dict[str, Any] | None = Field(
        None,
        max_length=50,
        description="Parameters of the map that the poses are for, see /api/parameters: SLAM uses its mount and its "
        "time offset.",
    )


class Healing(BaseModel):
    """SLAM of a session's log."""

    model_config = ConfigDict(extra="forbid")

    parameters: dict[str, Any] = Field(
        default_factory=dict, max_length=50, description="Parameters of SLAM, as GET /api/slam/parameters names them."
    )


class Change(BaseModel):
    """A change of a pose graph by hand; what is left out stays."""

    model_config = ConfigDict(extra="forbid")

    remove: int | None = Field(None, ge=0, description="Number of a loop to remove.")
    lock: int | None = Field(None, ge=0, description="Number of a loop that the robust kernel may not weaken.")
    unlock: int | None = Field(None, ge=0, description="Number of a loop that it may.")
    add: tuple[int, int] | None = Field(None, description="Two scans that are to be joined by a loop.")
    robust: str | None = Field(None, max_length=40, description="Robust kernel of the loops.")
    robust_scale: FiniteFloat | None = Field(None, description="Scale of the kernel, standard deviations.")
    reset: bool = Field(False, description="Whether the graph is to be as SLAM left it.")


@router.get("/slam/parameters")
async def parameters(_visitor: Visitor) -> dict[str, Any]:
    """Return the table of SLAM's parameters."""
    return {"table": await asyncio.to_thread(parameter_table)}


@router.post("/logs/{log_id}/slam", status_code=202)
async def begin(library: Logs, sessions: Sessions, visitor: Visitor, log_id: str, wanted: NewSlam) -> SlamStatus:
    """Correct the poses of a log with SLAM, as a job; its trajectory is added to the log. One that runs goes on."""
    state = await library.slam.begin(visitor, log_id, SlamRequest(**wanted.model_dump()))
    tell_at_end(library, sessions, library.slam, visitor, log_id)
    return state


@router.get("/logs/{log_id}/slam")
async def state(library: Logs, visitor: Visitor, log_id: str) -> SlamStatus:
    """Return the progress and the result of the visitor's newest SLAM of a log."""
    return library.slam.state(visitor, log_id)


@router.delete("/logs/{log_id}/slam")
async def cancel(library: Logs, visitor: Visitor, log_id: str) -> SlamStatus:
    """Cancel SLAM of a log, if it is queued or running."""
    return await library.slam.cancel(visitor, log_id)


@router.post("/sessions/{session_id}/heal", status_code=202)
async def heal(
    library: Logs, sessions: Sessions, session_id: str, wanted: Annotated[Healing | None, Body()] = None
) -> SlamStatus:
    """Correct the poses of the session's log with SLAM, and show the map along the poses so far.

    SLAM uses the mount and the time offset of the session's map.

    A job that is under way goes on, and the session follows it. The job is that of the visitor who began the session.
    """
    session, recording = _healed(sessions, session_id)
    owner, log_id = session.owner, recording.log_id
    values = {} if wanted is None else wanted.parameters
    view = recording.view()
    request = SlamRequest(topic=view.topic, parameters=values, cut=view.cut, mapping=view.values)
    state = await library.slam.begin(owner, log_id, request)
    follow_slam(session, library, log_id)
    tell_at_end(library, sessions, library.slam, owner, log_id)
    return state


@router.get("/sessions/{session_id}/heal")
async def healing(library: Logs, sessions: Sessions, session_id: str) -> SlamStatus:
    """Return the progress and the result of SLAM of the session's log."""
    session, recording = _healed(sessions, session_id)
    return library.slam.state(session.owner, recording.log_id)


@router.delete("/sessions/{session_id}/heal")
async def stop_healing(library: Logs, sessions: Sessions, session_id: str) -> SlamStatus:
    """Cancel SLAM of the session's log, if it is queued or running."""
    session, recording = _healed(sessions, session_id)
    return await library.slam.cancel(session.owner, recording.log_id)


def _healed(sessions: SessionRegistry, session_id: str) -> tuple[SessionHost, Recording]:
    session = sessions.get(session_id)
    recording = session.model.find(Recording)
    if recording is None:
        raise MapperError("session.not_a_log", "Only the poses of a log can be healed.")
    return session, recording


# -- the pose graph ----------------------------------------------------------------------------------------------------


def _graph(library: Library, sessions: SessionRegistry, session_id: str) -> tuple[SessionHost, Graphed, GraphSource]:
    """Return a session, its graph, and the function that reads the graph's file."""
    session = sessions.get(session_id)
    graph, recording = session.model.find(Graphed), session.model.find(Recording)
    if graph is None or recording is None:
        raise MapperError("session.not_a_log", "Only the poses of a log have a pose graph.")
    owner = session.owner if session.link is None else library.links.get(session.link).owner
    log_id = recording.log_id
    added = library.trajectories

    async def source(trajectory: str) -> bytes | None:
        known = any(one.name == trajectory for one in added.of(owner, log_id))
        return await added.graph(owner, log_id, trajectory) if known else None

    return session, graph, source


@router.get("/sessions/{session_id}/graph")
@guests_may(GuestRight.LINKED_SESSION)
async def graph(library: Logs, sessions: Sessions, session_id: str) -> dict[str, Any]:
    """Return the pose graph of the trajectory in use: its loops, worst first; it becomes a layer of the session.

    ``graph`` is null where the trajectory has none.
    """
    _, found, source = _graph(library, sessions, session_id)
    try:
        return {"graph": await found.public(source)}
    except ConfigError as error:
        if error.code != "graph.none":
            raise
        return {"graph": None}


@router.post("/sessions/{session_id}/graph")
@guests_may(GuestRight.LINKED_SESSION)
async def change(library: Logs, sessions: Sessions, session_id: str, wanted: Change) -> dict[str, Any]:
    """Change the pose graph, solve it, and map the log along its poses; answer as GET does."""
    _, found, source = _graph(library, sessions, session_id)
    return {"graph": await found.change(GraphChange(**wanted.model_dump()), source)}


@router.get("/sessions/{session_id}/graph/edges/{edge}")
@guests_may(GuestRight.LINKED_SESSION)
async def edge(library: Logs, sessions: Sessions, session_id: str, edge: int) -> dict[str, Any]:
    """Return an edge of the pose graph with both of its scans, in map metres, and how far it is from them."""
    _, found, source = _graph(library, sessions, session_id)
    return await found.edge(edge, source)


@router.get("/sessions/{session_id}/graph/edges/{edge}/hill")
@guests_may(GuestRight.LINKED_SESSION)
async def hill(library: Logs, sessions: Sessions, session_id: str, edge: int) -> dict[str, Any]:
    """Return how well the later scan of an edge fits the earlier one at the poses around the edge's measurement."""
    _, found, source = _graph(library, sessions, session_id)
    return await found.hill(edge, source)


@router.get("/sessions/{session_id}/graph/candidates")
@guests_may(GuestRight.LINKED_SESSION)
async def near(
    library: Logs,
    sessions: Sessions,
    session_id: str,
    x: Annotated[FiniteFloat, Query(description="Place in the map, metres.")],
    y: Annotated[FiniteFloat, Query(description="Place in the map, metres.")],
) -> dict[str, Any]:
    """Return which loops SLAM tried near a place, and what refused them."""
    _, found, source = _graph(library, sessions, session_id)
    return await found.near(x, y, source)


@router.get("/sessions/{session_id}/graph/candidates/{candidate}")
@guests_may(GuestRight.LINKED_SESSION)
async def candidate(library: Logs, sessions: Sessions, session_id: str, candidate: int) -> dict[str, Any]:
    """Return a loop that SLAM tried, with both of its scans, in map metres."""
    _, found, source = _graph(library, sessions, session_id)
    return await found.candidate(candidate, source)


@router.post("/sessions/{session_id}/graph/keep")
async def keep(library: Logs, sessions: Sessions, visitor: Visitor, session_id: str) -> TrajectoryAnswer:
    """Keep the changed graph and its poses in the place of those that SLAM made."""
    session, found, source = _graph(library, sessions, session_id)
    recording = session.model.find(Recording)
    if recording is None or session.owner != visitor or session.link is not None:
        raise MapperError("session.not_yours", "A graph can only be kept by the visitor whose session it is.")
    name, text, file = await found.files(source)
    record = library.get(visitor, recording.log_id)
    log = await library.load(visitor, record.id, recording.view().topic)
    added = await library.trajectories.put_changed(visitor, record, log, name, text, file)
    await update_sessions(library, sessions, visitor, recording.log_id)
    return added.public()
