"""``/api/links``: create, list and revoke links to a view; ``/api/shared/TOKEN`` and ``/shared/TOKEN``: open one."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field, FiniteFloat

from mapper.core.errors import MapperError
from server.downloads import Downloads
from server.http.clients import chosen_place, client_address, while_connected
from server.http.guests import GuestRight, guests_may
from server.http.page_files import page_of_secret
from server.http.routes.fields import Made
from server.http.routes.sessions import SessionAnswer, created
from server.http.services import FileDownloads, Logs, ServiceSettings, Sessions, Visitor
from server.http.session_access import shareable_session
from server.library.annotations.links import Link, LinkGoneError
from server.library.library import Library
from server.library.logs.records import LogNotFoundError
from server.parts.costmap.messages import CostmapCommand
from server.parts.doctor.routes import DoctorAnswer, doctor_answer
from server.parts.terrain.routes import uploaded_terrain
from server.parts.wire import command_of
from server.sessions import LogView, SessionRegistry
from server.sessions.commands import ShowReferenceMap, UseCosts, UseTerrain
from server.sessions.kind import Resources
from server.sessions.parts import Recording
from server.sources import costmaps_plan, log_plan, volume_plan
from server.stream.message_parts import CameraName, RobotCameraName
from server.stream.protocol import fields_of

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(tags=["links"])

Place = tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class Look(BaseModel, extra="forbid"):
    """Part of the map shown in a picture."""

    x: FiniteFloat = Field(description="The place in the middle, metres.")
    y: FiniteFloat = Field(description="The place in the middle, metres.")
    scale: FiniteFloat = Field(gt=0.0, description="Metres that one pixel of the page shows.")
    width: FiniteFloat = Field(gt=0.0, description="Pixels of the picture.")
    height: FiniteFloat = Field(gt=0.0, description="Pixels of the picture.")


class ShownField(BaseModel, extra="forbid"):
    """A plotted number."""

    topic: str = Field(max_length=400)
    field: str = Field(max_length=400, description="Its path in the message.")
    made: Made = Field(description="The value, its change per second, or its moving average.")
    window: FiniteFloat = Field(gt=0.0, le=86_400.0, description="Window of the moving average, seconds.")


class ShownPlots(BaseModel, extra="forbid"):
    """The plots of a log."""

    fields: list[ShownField] = Field(max_length=20)
    across: str | None = Field(None, max_length=801, description="The number on the horizontal axis; null for time.")
    zoom: tuple[FiniteFloat, FiniteFloat] | None = Field(None, description="The interval, seconds; null for all.")
    below: bool = Field(description="Whether there are plots below the time slider.")


class ShownLines(BaseModel, extra="forbid"):
    """Filter of the lines logged by nodes."""

    least: int = Field(ge=0, le=255, description="The least level.")
    node: str = Field(max_length=200, description="The node; empty for all.")
    text: str = Field(max_length=200, description="What they contain.")


class ShownMeasure(BaseModel, extra="forbid"):
    """A measurement on the map or in 3D."""

    tool: Literal["distance", "area"]
    points: list[tuple[FiniteFloat, FiniteFloat] | Place] = Field(
        max_length=1000, description="Metres; with a height where they were measured in 3D."
    )
    size: FiniteFloat | None = Field(
        None, ge=0.0, description="Side of the largest voxel that one is on, metres; 0: all are measured points."
    )


class ShownCamera(BaseModel, extra="forbid"):
    """Camera of a 3D view."""

    position: Place = Field(description="Where it is, metres.")
    look_at: Place = Field(description="What it looks at, metres.")


class ShownScene(BaseModel, extra="forbid"):
    """The 3D view of the stage."""

    clouds: bool = Field(description="Whether it shows the log's point clouds, not its map.")
    camera: ShownCamera | None = Field(None, description="Null: as at first.")
    layers: dict[str, bool] = Field(default_factory=dict, max_length=100, description="Whether each layer is visible.")
    height: FiniteFloat = Field(1.0, ge=0.1, le=10.0, description="Height of the map's columns by that at first.")
    chosen: CameraName | RobotCameraName | None = Field(
        None, description="The camera that was chosen, unless it was moved elsewhere then; null: as at first."
    )
    look: dict[str, bool | FiniteFloat | Annotated[str, Field(max_length=40)]] = Field(
        default_factory=dict, max_length=40, description="Values of the table of the clouds' look, such as point_size."
    )


class Shown(BaseModel, extra="forbid"):
    """Other parts of the page that its sender saw."""

    group: str | None = Field(None, max_length=40, description="The open group of controls.")
    note: str | None = Field(None, max_length=100, description="Id of the chosen note.")
    layout: str | None = Field(None, max_length=2000, description="The views beside the map, as the page writes them.")
    message: str | None = Field(None, max_length=400, description="The topic whose messages are shown.")
    picture: str | None = Field(None, max_length=400, description="The topic whose pictures are shown.")
    plots: ShownPlots | None = Field(None)
    lines: ShownLines | None = Field(None)
    place: tuple[FiniteFloat, FiniteFloat] | None = Field(None, description="The explained cell's place, metres.")
    measured: ShownMeasure | None = Field(None)
    scene: ShownScene | None = Field(None)
    utc: bool | None = Field(None, description="Whether times are in UTC.")
    comparison: str | None = Field(None, max_length=16_000, description="The comparison, as the page writes it.")


class NewLink(BaseModel, extra="forbid"):
    """A link to the current view of a session."""

    look: Look | None = Field(None, description="What part of the map is seen; all of it where this is left out.")
    shown: Shown | None = Field(None, description="What else of the page is seen.")


class KeptView(BaseModel):
    """The stored view of a link.

    ``count`` is the number of scans of the log, ``changed`` names the parameters that differ from the initial ones.
    ``navigation`` are the commands that begin the costmap, each as an object with its ``type``.
    """

    view: LogView
    look: Look | None
    shown: Shown | None = None
    examination: DoctorAnswer | None = None
    count: int
    changed: list[str]
    navigation: list[object] = []


@dataclass(frozen=True, slots=True)
class LinkAnswer:
    """A link as seen by its owner: the view that it opens, and the number of visitors ``watching``.

    ``count`` is the number of scans of the log, ``index`` the number of scans in the map. ``changed`` names the
    parameters that differ from the initial ones.
    """

    token: str
    address: str
    created_s: float
    log: str
    topic: str | None
    trajectory: str | None
    index: int
    count: int
    changed: list[str]
    watching: int


@dataclass(frozen=True, slots=True)
class LinkList:
    """Links to a log, newest first."""

    links: list[LinkAnswer]


def _public(sessions: SessionRegistry, link: Link) -> LinkAnswer:
    """Return a link as seen by its owner."""
    view = KeptView.model_validate_json(link.view)
    return LinkAnswer(
        token=link.token,
        address=f"/shared/{link.token}",
        created_s=link.created_s,
        log=link.log_id,
        topic=view.view.topic,
        trajectory=view.view.trajectory,
        index=view.view.index,
        count=view.count,
        changed=view.changed,
        watching=sum(session.link == link.token for session in sessions.all()),
    )


@router.post("/api/sessions/{session_id}/links", status_code=201)
async def make(sessions: Sessions, library: Logs, session_id: str, body: NewLink) -> LinkAnswer:
    """Create a read-only link to the current view of a session of a log, or of recorded costmaps.

    It is valid until it is revoked, and belongs to the visitor who began the session.
    """
    session, viewed = shareable_session(sessions, session_id)
    model = session.model
    record = library.get(session.owner, viewed.log_id)
    seen = viewed.view()
    recording = model.find(Recording)
    diagnosis = None if recording is None else recording.diagnosis
    examination = doctor_answer(recording, recording.trajectory, diagnosis) if recording and diagnosis else None
    first = {} if recording is None else asdict(recording.first_config())
    changed = sorted(name for name, value in (seen.values or {}).items() if first[name] != value)
    async with session.locked():
        navigation: list[object] = [fields_of(command) for command in model.history()]
    view = KeptView(
        view=seen,
        look=body.look,
        shown=body.shown,
        examination=examination,
        count=model.progress[1],
        changed=changed,
        navigation=navigation,
    )
    return _public(sessions, await library.links.make(session.owner, record, view.model_dump_json()))


@router.get("/api/links")
async def mine(
    sessions: Sessions, library: Logs, visitor: Visitor, log: Annotated[str, Query(max_length=200)]
) -> LinkList:
    """List the links of this visitor to a log, newest first."""
    return LinkList([_public(sessions, link) for link in library.links.of(visitor, log)])


@router.get("/api/sessions/{session_id}/links")
async def of_session(sessions: Sessions, library: Logs, session_id: str) -> LinkList:
    """List the links to a session's log that belong to the visitor who began the session, newest first."""
    session, viewed = shareable_session(sessions, session_id)
    return LinkList([_public(sessions, link) for link in library.links.of(session.owner, viewed.log_id)])


@router.delete("/api/sessions/{session_id}/links/{token}", status_code=204)
async def revoke_of_session(sessions: Sessions, library: Logs, session_id: str, token: str) -> None:
    """Revoke a link to a session's log that belongs to the visitor who began the session. Its sessions end."""
    session, viewed = shareable_session(sessions, session_id)
    if library.links.get(token).log_id != viewed.log_id:
        raise LinkGoneError("link.gone", "There is no such link to this log.")
    await library.links.revoke(session.owner, token)
    await sessions.end_linked(token)


@router.delete("/api/links/{token}", status_code=204)
async def revoke(sessions: Sessions, library: Logs, visitor: Visitor, token: str) -> None:
    """Revoke a link. The sessions begun with it end."""
    await library.links.revoke(visitor, token)
    await sessions.end_linked(token)


@dataclass(frozen=True, slots=True)
class SharedAnswer:
    """A link as seen by its receivers; ``look`` is the visible part of the map, null for all of it.

    ``shown`` are other parts of the page that its sender saw, null if the link does not contain them; ``examination``
    is the diagnosis of the log, null if it had not been examined.
    """

    title: str
    look: Look | None
    shown: Shown | None
    examination: DoctorAnswer | None


@router.get("/api/shared/{token}")
@guests_may(GuestRight.ALWAYS)
async def shared(library: Logs, token: str) -> SharedAnswer:
    """Return the title and the view of a link."""
    link = library.links.get(token)
    view = KeptView.model_validate_json(link.view)
    return SharedAnswer(_record_name(library, link), view.look, view.shown, view.examination)


@router.post("/api/shared/{token}/sessions", status_code=201)
@guests_may(GuestRight.ALWAYS)
async def begin(
    request: Request,
    response: Response,
    sessions: Sessions,
    library: Logs,
    downloads: FileDownloads,
    visitor: Visitor,
    settings: ServiceSettings,
    token: str,
    name: Annotated[
        str | None, Query(max_length=100, description="Name under which /api/sessions/making/{name} has the progress.")
    ] = None,
    *,
    whole: Annotated[
        bool, Query(description="Whether a log that the link would play from its start is paused at its end.")
    ] = False,
    clouds: Annotated[bool, Query(description="Whether the session shows the log's point clouds in 3D.")] = False,
) -> SessionAnswer:
    """Begin a session with the view of a link, or with the point clouds of its log."""
    link = library.links.get(token)
    kept_view = KeptView.model_validate_json(link.view)

    async def begun() -> SessionHost:
        view = kept_view.view
        title = _record_name(library, link)
        with sessions.under_way.making(visitor, name) as making:
            making.watched = lambda: library.opening(link.log_id)
            costmaps = None if clouds else await library.costmaps(link.owner, link.log_id)
            if clouds:
                resources = Resources(link.owner, library, settings.max_story_s, making)
                plan = await volume_plan(resources, link.log_id, None, name=name, playing=False)
            elif costmaps is None:
                log = await library.load(link.owner, link.log_id, view.topic, view.planar_cut)
                if whole and view.index == 0:
                    view = replace(view, index=log.n_scans)
                plan = log_plan(log, log_id=link.log_id, title=title, view=view, name=name)
            else:
                plan = costmaps_plan(costmaps, log_id=link.log_id, title=title, view=view, playing=False, name=name)
        commands = [] if clouds else await _navigation(library, downloads, link, kept_view.navigation)
        session = await sessions.begin(
            plan, visitor, link=token, address=client_address(request), place=chosen_place(request)
        )
        for command in commands:
            session.enqueue(command)
        return session

    session = await while_connected(request, begun())
    try:
        library.links.get(token)
    except LinkGoneError:  # revoked in the meantime
        await sessions.close(session.id)
        raise
    return created(response, session)


@router.api_route("/shared/{token}", methods=["GET", "HEAD"], include_in_schema=False)
@guests_may(GuestRight.ALWAYS)
async def page(request: Request, library: Logs, token: str) -> Response:
    """Return the page of a link, with status 404 if the link is gone."""
    return page_of_secret(request, "logs.html", lambda: library.links.get(token), LinkGoneError)


async def _navigation(
    library: Library, downloads: Downloads, link: Link, stored: Sequence[object]
) -> list[msgspec.Struct]:
    """Return the commands that begin the costmap of a link, with its original map and terrain.

    If these have been deleted since, they are left out: the costmap is then over the log's own map, or without terrain.
    """
    commands: list[msgspec.Struct] = []
    for fields in stored:
        if isinstance(fields, dict) and fields["type"] == "use_terrain":
            with suppress(MapperError):
                of_terrain = msgspec.convert(fields, UseTerrain)
                terrain = await uploaded_terrain(library, downloads, link.owner, of_terrain.log)
                commands.append(UseCosts(terrain))
            continue
        command = command_of(fields)
        if isinstance(command, CostmapCommand) and command.values.get("map") == "given":
            try:
                commands.append(ShowReferenceMap(await library.maps.get(link.owner, link.log_id)))
            except MapperError:
                command.values = command.values | {"map": "belief"}
        commands.append(command)
    return commands


def _record_name(library: Library, link: Link) -> str:
    try:
        return library.get(link.owner, link.log_id).name
    except LogNotFoundError:
        raise LinkGoneError("link.log_gone", "The log of this link no longer exists.") from None
