"""``/api/logs/{id}/slam``, ``/api/sessions/{id}/heal``, ``/graph``, ``/merge``: correct the poses of logs with SLAM."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Body, Query
from pydantic import BaseModel, Field, FiniteFloat

from mapper.core.errors import ConfigError, MapperError
from server.http.computed_series import graph_source
from server.http.following import follow_slam, tell_at_end, update_sessions
from server.http.guests import GuestRight, guests_may
from server.http.services import Logs, Sessions, Visitor
from server.http.session_access import log_owner, part_of_log, writable_session
from server.library.library import Library
from server.library.logs.records import TrajectoryAnswer
from server.library.processing.log_jobs import ParameterTable
from server.library.processing.merging import MergeReport, MergeRequest, MergeStatus
from server.library.processing.slam import SlamRequest, SlamStatus, parameter_table
from server.sessions import SessionRegistry
from server.sessions.graph_answers import (
    EdgeAnswer,
    PoseGraphAnswer,
    ScanConstraints,
    ScoreLandscape,
    TriedLoopScans,
    TriedNear,
)
from server.sessions.kind import GivenValues
from server.sessions.parts import Graphed, GraphSource, Recording
from server.sessions.view import GraphChange

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api", tags=["logs"])

_tasks: set[asyncio.Task[None]] = set()  # of finished merges, because asyncio itself keeps no reference


class NewSlam(BaseModel, extra="forbid"):
    """SLAM of a log."""

    topic: str | None = Field(None, max_length=400, description="Sensor of the log, if it has several.")
    trajectory: str | None = Field(
        None, max_length=200, description="Trajectory to begin with; where it is left out, the log's odometry."
    )
    parameters: GivenValues = Field(
        default_factory=dict, max_length=50, description="Parameters of SLAM, as GET /api/slam/parameters names them."
    )
    cut: dict[str, FiniteFloat] | None = Field(
        None,
        max_length=20,
        description="How scans are cut out of clouds and depth images, see /api/parameters; else as by default.",
    )
    mapping: GivenValues | None = Field(
        None,
        max_length=50,
        description="Parameters of the map that the poses are for, see /api/parameters: SLAM uses its mount and its "
        "time offset.",
    )


class PoseCorrection(BaseModel, extra="forbid"):
    """SLAM of a session's log."""

    parameters: GivenValues = Field(
        default_factory=dict, max_length=50, description="Parameters of SLAM, as GET /api/slam/parameters names them."
    )


class ChangeOfGraph(BaseModel, extra="forbid"):
    """A manual change of a pose graph. Omitted fields change nothing."""

    remove: int | None = Field(None, ge=0, description="Number of a loop to remove.")
    lock: int | None = Field(None, ge=0, description="Number of a loop that the robust kernel may not weaken.")
    unlock: int | None = Field(None, ge=0, description="Number of a loop that it may.")
    add: tuple[int, int] | None = Field(None, description="Two scans that are to be joined by a loop.")
    robust: str | None = Field(None, max_length=40, description="Robust kernel of the loops.")
    robust_scale: FiniteFloat | None = Field(None, description="Scale of the kernel, standard deviations.")
    reset: bool = Field(False, description="Whether the graph is to be as SLAM left it.")


@dataclass(frozen=True, slots=True)
class PresentGraph:
    """The pose graph of the current trajectory; ``graph`` is null if it has none."""

    graph: PoseGraphAnswer | None


class OtherLog(BaseModel, extra="forbid"):
    """The log to merge with."""

    log: str = Field(max_length=64, description="Id of the other log.")
    topic: str | None = Field(None, max_length=400, description="Sensor of it, if it has several.")
    cut: dict[str, FiniteFloat] | None = Field(
        None,
        max_length=20,
        description="How its scans are cut out of clouds and depth images, see /api/parameters; else as here.",
    )
    mapping: GivenValues | None = Field(
        None,
        max_length=50,
        description="Parameters of its map, see /api/parameters: its mount and its time offset are used; else as here.",
    )


@router.get("/slam/parameters")
async def parameters(_visitor: Visitor) -> ParameterTable:
    """Return the table of SLAM's parameters."""
    return await asyncio.to_thread(parameter_table)


@router.post("/logs/{log_id}/slam", status_code=202)
async def begin(library: Logs, sessions: Sessions, visitor: Visitor, log_id: str, body: NewSlam) -> SlamStatus:
    """Correct the poses of a log with SLAM as a job, which adds a trajectory to the log. A running job continues."""
    state = await library.slam.begin(visitor, log_id, SlamRequest(**dict(body)))
    tell_at_end(library, sessions, library.slam, visitor, log_id)
    return state


@router.get("/logs/{log_id}/slam")
async def state(library: Logs, visitor: Visitor, log_id: str) -> SlamStatus:
    """Return the progress and the result of the visitor's latest SLAM job for a log."""
    return library.slam.state(visitor, log_id)


@router.delete("/logs/{log_id}/slam")
async def cancel(library: Logs, visitor: Visitor, log_id: str) -> SlamStatus:
    """Cancel SLAM of a log, if it is queued or running."""
    return await library.slam.cancel(visitor, log_id)


@router.post("/sessions/{session_id}/heal", status_code=202)
async def correct_poses(
    library: Logs, sessions: Sessions, session_id: str, body: Annotated[PoseCorrection | None, Body()] = None
) -> SlamStatus:
    """Correct the poses of the session's log with SLAM, and show the map along the poses so far.

    SLAM uses the mount and the time offset of the session's map. If such a job is under way, the session follows it.
    The job belongs to the visitor who began the session.
    """
    session, recording = _recorded(sessions, session_id)
    owner, log_id = session.owner, recording.log_id
    values = {} if body is None else body.parameters
    view = recording.view()
    request = SlamRequest(topic=view.topic, parameters=values, cut=view.cut, mapping=view.values)
    state = await library.slam.begin(owner, log_id, request)
    follow_slam(session, library, log_id)
    tell_at_end(library, sessions, library.slam, owner, log_id)
    return state


@router.get("/sessions/{session_id}/heal")
async def correction(library: Logs, sessions: Sessions, session_id: str) -> SlamStatus:
    """Return the progress and the result of SLAM for the session's log."""
    session, recording = _recorded(sessions, session_id)
    return library.slam.state(session.owner, recording.log_id)


@router.delete("/sessions/{session_id}/heal")
async def stop_correction(library: Logs, sessions: Sessions, session_id: str) -> SlamStatus:
    """Cancel SLAM of the session's log, if it is queued or running."""
    session, recording = _recorded(sessions, session_id)
    return await library.slam.cancel(session.owner, recording.log_id)


def _recorded(sessions: SessionRegistry, session_id: str) -> tuple[SessionHost, Recording]:
    session = sessions.get(session_id)
    return session, part_of_log(session, Recording, "Only the poses of a log can be healed.")


# -- the pose graph ----------------------------------------------------------------------------------------------------


def _graph(library: Library, sessions: SessionRegistry, session_id: str) -> tuple[SessionHost, Graphed, GraphSource]:
    """Return a session, its graph, and the function that reads the graph's file."""
    session = sessions.get(session_id)
    problem = "Only the poses of a log have a pose graph."
    graph, recording = part_of_log(session, Graphed, problem), part_of_log(session, Recording, problem)
    owner = log_owner(session, library)
    return session, graph, graph_source(library, owner, recording.log_id)


@router.get("/sessions/{session_id}/graph")
@guests_may(GuestRight.LINKED_SESSION)
async def graph(library: Logs, sessions: Sessions, session_id: str) -> PresentGraph:
    """Return the pose graph of the current trajectory, with its loops, worst first. It becomes a layer of the session.

    ``graph`` is null if the trajectory has none.
    """
    _, graphed, source = _graph(library, sessions, session_id)
    try:
        return PresentGraph(await graphed.public(source))
    except ConfigError as error:
        if error.code != "graph.none":
            raise
        return PresentGraph(None)


@router.post("/sessions/{session_id}/graph")
@guests_may(GuestRight.LINKED_SESSION)
async def change(library: Logs, sessions: Sessions, session_id: str, body: ChangeOfGraph) -> PresentGraph:
    """Change the pose graph, solve it, and map the log along its poses; answer as GET does."""
    _, graphed, source = _graph(library, sessions, session_id)
    return PresentGraph(await graphed.change(GraphChange(**body.model_dump()), source))


@router.get("/sessions/{session_id}/graph/edges/{edge}")
@guests_may(GuestRight.LINKED_SESSION)
async def edge(library: Logs, sessions: Sessions, session_id: str, edge: int) -> EdgeAnswer:
    """Return an edge of the pose graph with both of its scans, in map metres, and the poses' deviation from it."""
    _, graphed, source = _graph(library, sessions, session_id)
    return await graphed.edge(edge, source)


@router.get("/sessions/{session_id}/graph/scans/{scan}")
@guests_may(GuestRight.LINKED_SESSION)
async def constraints(library: Logs, sessions: Sessions, session_id: str, scan: int) -> ScanConstraints:
    """Return the edges of the pose graph that determine the pose of a scan, the greatest residual first."""
    _, graphed, source = _graph(library, sessions, session_id)
    return await graphed.constraints(scan, source)


@router.get("/sessions/{session_id}/graph/edges/{edge}/landscape")
@guests_may(GuestRight.LINKED_SESSION)
async def landscape(library: Logs, sessions: Sessions, session_id: str, edge: int) -> ScoreLandscape:
    """Return the match score of an edge's later scan against the earlier one, at poses around the measurement."""
    _, graphed, source = _graph(library, sessions, session_id)
    return await graphed.landscape(edge, source)


@router.get("/sessions/{session_id}/graph/candidates")
@guests_may(GuestRight.LINKED_SESSION)
async def near(
    library: Logs,
    sessions: Sessions,
    session_id: str,
    x: Annotated[FiniteFloat, Query(description="Place in the map, metres.")],
    y: Annotated[FiniteFloat, Query(description="Place in the map, metres.")],
) -> TriedNear:
    """Return the loops that SLAM tried near a place, and why they were rejected."""
    _, graphed, source = _graph(library, sessions, session_id)
    return await graphed.near(x, y, source)


@router.get("/sessions/{session_id}/graph/candidates/{candidate}")
@guests_may(GuestRight.LINKED_SESSION)
async def candidate(library: Logs, sessions: Sessions, session_id: str, candidate: int) -> TriedLoopScans:
    """Return a loop that SLAM tried, with both of its scans, in map metres."""
    _, graphed, source = _graph(library, sessions, session_id)
    return await graphed.candidate(candidate, source)


@router.post("/sessions/{session_id}/graph/keep")
async def keep(library: Logs, sessions: Sessions, visitor: Visitor, session_id: str) -> TrajectoryAnswer:
    """Save the changed graph and its poses in place of the results of SLAM."""
    session, graphed, source = _graph(library, sessions, session_id)
    recording = session.model.find(Recording)
    if recording is None or session.owner != visitor or session.link is not None:
        raise MapperError("session.not_yours", "A graph can only be kept by the visitor whose session it is.")
    name, text, file = await graphed.files(source)
    record = library.get(visitor, recording.log_id)
    log = await library.load(visitor, record.id, recording.view().topic)
    added = await library.trajectories.put_changed(visitor, record, log, name, text, file)
    await update_sessions(library, sessions, visitor, recording.log_id)
    return added.public()


@router.post("/sessions/{session_id}/merge", status_code=202)
async def begin_merge(library: Logs, sessions: Sessions, session_id: str, body: OtherLog) -> MergeStatus:
    """Align the session's log and another one of the same place, as a job.

    SLAM corrects each log, their maps are aligned, and their scans are joined in one graph. Both logs then have a
    trajectory ``merged`` in one frame, and one more log has the scans of both along it, with a trajectory ``SLAM`` that
    has their pose graph. Scans of clouds and depth images are cut as in the session, with the mount and the time offset
    of its map.
    """
    of_log = writable_session(sessions, session_id)
    view = of_log.recording.view()
    owner, first = of_log.owner, of_log.log_id

    async def tell() -> None:
        with suppress(MapperError):  # a log was deleted in the meantime
            for log_id in (first, body.log):
                await update_sessions(library, sessions, owner, log_id)

    def notify(report: MergeReport | None) -> None:
        if report is not None:
            return
        task = asyncio.create_task(tell())
        _tasks.add(task)
        task.add_done_callback(_tasks.discard)

    cut = view.cut if body.cut is None else body.cut
    mapping = view.values if body.mapping is None else body.mapping
    request = MergeRequest(body.log, view.topic, body.topic, view.cut, cut, view.values, mapping)
    state = await library.merges.begin(owner, first, request)
    library.merges.listen(owner, first, notify)
    return state


@router.get("/sessions/{session_id}/merge")
async def merge_state(library: Logs, sessions: Sessions, session_id: str) -> MergeStatus:
    """Return the progress and the result of the merge of the session's log."""
    of_log = writable_session(sessions, session_id)
    return library.merges.state(of_log.owner, of_log.log_id)


@router.delete("/sessions/{session_id}/merge")
async def cancel_merge(library: Logs, sessions: Sessions, session_id: str) -> MergeStatus:
    """Cancel the merge of the session's log, if it is queued or running."""
    of_log = writable_session(sessions, session_id)
    return await library.merges.cancel(of_log.owner, of_log.log_id)
