"""``/api/sessions/{id}/localization``: localize a log in a reference map by Monte Carlo localization."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from fastapi import APIRouter, Body, Query, Request
from fastapi.responses import PlainTextResponse
from pydantic import BaseModel, Field, FiniteFloat
from starlette.requests import ClientDisconnect

from mapper.core.errors import LimitError, MapperError
from mapper.core.parameter import changed_values
from server.http.clients import client_address, in_turn
from server.http.file_answer import FILE_BODY, file_answer
from server.http.following import follow_localization, tell_at_end
from server.http.guests import GuestRight, guests_may
from server.http.services import Logs, RequestWork, Sessions, Visitor
from server.http.session_access import log_owner, session_of_log, writable_session
from server.library.library import Library
from server.library.packs.reference_map import ChosenMap
from server.library.processing.localization import (
    LocalizationParameters,
    LocalizationRequest,
    LocalizationStatus,
    parameter_table,
)
from server.library.processing.log_jobs import Parameters, ParameterTable
from server.sessions.commands import ShowReferenceMap
from server.sessions.kind import GivenValues
from server.sessions.parts import FilterHistory, Localized

if TYPE_CHECKING:
    from server.library.packs.reference_map import ReferenceMap
    from server.sessions import SessionHost

router = APIRouter(prefix="/api", tags=["logs"])

MOST_YAML_BYTES = 1 << 16


class MapOfLog(BaseModel, extra="forbid"):
    """The map of the session's log or of another one."""

    log: str = Field(max_length=200, description="Id of the log, as in /api/logs.")
    topic: str | None = Field(None, max_length=400, description="Sensor of that log, if it has several.")
    trajectory: str | None = Field(None, max_length=200, description="Trajectory to map it with; else its first.")


class NewLocalization(BaseModel, extra="forbid"):
    """A localization of a session's log in the chosen map."""

    initial_pose: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = Field(
        None, description="Where in the map the robot starts: x, y (m) and yaw (rad); else anywhere."
    )
    odometry: str | None = Field(None, max_length=200, description="Trajectory that is the odometry; else the log's.")
    parameters: GivenValues = Field(
        default_factory=dict, max_length=50,
        description="Parameters, as GET /api/localization/parameters names them.",
    )  # fmt: skip


@router.get("/localization/parameters")
async def parameters() -> ParameterTable:
    """Return the table of localization's parameters, which are those of AMCL."""
    return await asyncio.to_thread(parameter_table)


@dataclass(frozen=True, slots=True)
class AmclParameters:
    """The parameters in an AMCL yaml file: the ``values`` that differ from the defaults.

    ``others`` are parameters that do not affect the poses; ``notes`` concern names that AMCL does not have.
    """

    values: Parameters
    layout: Literal["nav2", "ros1"]
    others: dict[str, Any]
    notes: list[str]


@router.put("/localization/parameters", openapi_extra=FILE_BODY)
async def of_yaml(request: Request, work: RequestWork, visitor: Visitor) -> AmclParameters:
    """Return the parameters in an AMCL yaml file, the body, that differ from the defaults.

    ``others`` are parameters that do not affect the poses, and ``layout`` is nav2 or ros1. A yaml file saved with both
    keeps them.
    """
    text = bytearray()
    async for chunk in request.stream():
        text += chunk
        if len(text) > MOST_YAML_BYTES:
            raise LimitError("amcl.size", f"A yaml of parameters has at most {MOST_YAML_BYTES >> 10} KiB here.")

    def read() -> AmclParameters:
        from mapper.localization import LocalizationConfig, parse_amcl_yaml  # noqa: PLC0415 - few visitors have one

        amcl = parse_amcl_yaml(bytes(text))
        values = changed_values(amcl.config, LocalizationConfig())
        return AmclParameters(values, amcl.layout, {**amcl.others}, [*amcl.notes])

    return await in_turn(request, work, visitor, read)


@router.post("/localization/amcl.yaml", **file_answer("text/plain"))
async def as_yaml(
    values: Annotated[dict[str, Any], Body(max_length=100)],
    layout: Annotated[Literal["nav2", "ros1"], Query(description="Names of Nav2's AMCL, or of ROS 1's.")] = "nav2",
) -> PlainTextResponse:
    """Return parameters, those that differ from the defaults, as an AMCL yaml file.

    AMCL parameters that do not affect the poses are written unchanged.
    """

    def write() -> str:
        from mapper.localization import LocalizationConfig, amcl_yaml  # noqa: PLC0415 - few visitors want one
        from mapper.localization.amcl_parameters import is_other  # noqa: PLC0415

        others = {name: value for name, value in values.items() if is_other(name)}
        own = {name: value for name, value in values.items() if name not in others}
        return amcl_yaml(LocalizationConfig().with_values(own), layout, others)

    text = await asyncio.to_thread(write)
    return PlainTextResponse(text, headers={"Content-Disposition": 'attachment; filename="amcl.yaml"'})


@router.put("/sessions/{session_id}/localization/map")
async def map_of_log(request: Request, library: Logs, sessions: Sessions, session_id: str, body: MapOfLog) -> ChosenMap:
    """Choose the map in which to localize the session's log: the map of a log along one of its trajectories."""
    of_log = writable_session(sessions, session_id)
    _check_idle(library, of_log.owner, of_log.log_id)
    reference = await library.maps.of_log(
        of_log.owner, of_log.log_id, body.log, body.topic, body.trajectory, address=client_address(request)
    )
    return _show(of_log.session, reference)


@router.put("/sessions/{session_id}/localization/map-files", openapi_extra=FILE_BODY)
async def map_of_files(
    request: Request,
    library: Logs,
    sessions: Sessions,
    session_id: str,
    name: Annotated[str, Query(max_length=200, description="Title of the map.")] = "map",
) -> ChosenMap:
    """Choose the map for localizing the session's log: the body is a tar archive of a yaml file and its image.

    It may also be a map of CMU's course.
    """
    of_log = writable_session(sessions, session_id)
    _check_idle(library, of_log.owner, of_log.log_id)
    try:
        reference = await library.choose_map(
            of_log.owner, of_log.log_id, name, request.stream(), address=client_address(request)
        )
    except ClientDisconnect:
        return ChosenMap(None)  # the client has gone
    return _show(of_log.session, reference)


@router.get("/sessions/{session_id}/localization/map")
async def reference_map(library: Logs, sessions: Sessions, session_id: str) -> ChosenMap:
    """Return the chosen map, and show it as a layer of the session. ``map`` is null if none was chosen."""
    of_log = writable_session(sessions, session_id)
    try:
        return _show(of_log.session, await library.maps.get(of_log.owner, of_log.log_id))
    except MapperError as error:
        if error.code != "localization.no_map":
            raise
        return ChosenMap(None)


@router.post("/sessions/{session_id}/localization", status_code=202)
async def begin(library: Logs, sessions: Sessions, session_id: str, body: NewLocalization) -> LocalizationStatus:
    """Localize the session's log in the chosen map as a job, and show the poses so far.

    If such a job is under way, the session follows it. Afterwards the log has a trajectory ``localized``.
    """
    of_log = writable_session(sessions, session_id)
    owner, log_id, session = of_log.owner, of_log.log_id, of_log.session
    await library.maps.get(owner, log_id)
    view, values = of_log.recording.view(), LocalizationParameters(body.parameters, body.initial_pose)
    request = LocalizationRequest(view.topic, body.odometry, view.cut, view.values, values)
    state = await library.localization.begin(owner, log_id, request)
    follow_localization(session, library, log_id)
    tell_at_end(library, sessions, library.localization, owner, log_id)
    return state


@router.get("/sessions/{session_id}/localization")
async def state(library: Logs, sessions: Sessions, session_id: str) -> LocalizationStatus:
    """Return the progress and the result of the localization of the session's log."""
    of_log = writable_session(sessions, session_id)
    return library.localization.state(of_log.owner, of_log.log_id)


@router.delete("/sessions/{session_id}/localization")
async def cancel(library: Logs, sessions: Sessions, session_id: str) -> LocalizationStatus:
    """Cancel the localization of the session's log, if it is queued or running."""
    of_log = writable_session(sessions, session_id)
    return await library.localization.cancel(of_log.owner, of_log.log_id)


@dataclass(frozen=True, slots=True)
class PresentHistory:
    """The history of the filter that estimated the current poses; ``course`` is null without localization."""

    course: FilterHistory | None


@router.get("/sessions/{session_id}/localization/course")
@guests_may(GuestRight.LINKED_SESSION)
async def filter_history(library: Logs, sessions: Sessions, session_id: str) -> PresentHistory:
    """Return the uncertainty of the current poses along the log. Particles and the map become layers of the session.

    ``course`` is null for poses that do not come from localization.
    """
    of_log = session_of_log(sessions, session_id)
    session, log_id = of_log.session, of_log.log_id
    owner = log_owner(session, library)
    localization = session.model.find(Localized)

    async def source(trajectory: str) -> bytes | None:
        known = any(candidate.name == trajectory for candidate in library.trajectories.of(owner, log_id))
        return await library.trajectories.filter_states(owner, log_id, trajectory) if known else None

    return PresentHistory(None if localization is None else await localization.public(source))


def _check_idle(library: Library, owner: str, log_id: str) -> None:
    if library.localization.is_under_way(owner, log_id):
        raise MapperError("localization.under_way", "This log is being localized: wait, or cancel it.")


def _show(session: SessionHost, reference: ReferenceMap) -> ChosenMap:
    session.enqueue(ShowReferenceMap(reference))
    return ChosenMap(reference.public())
