"""``/api/classes``: open a class, join and follow it; ``/join``, ``/class/CODE``: its pages.

With the code of a class, a visitor may follow it without the service's token: see what the lecturer shows, answer
questions, and begin a session that is a copy of the lecturer's. Nothing else is allowed.
"""

from __future__ import annotations

import io
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import segno
from fastapi import APIRouter, Request, WebSocket
from fastapi.responses import RedirectResponse, Response

from mapper.core.errors import MapperError
from server.classes import Classes, ClassRightError, Classroom, results_csv, unknown_class
from server.classes.classes import normalised
from server.http.brake import CodeGuesses
from server.http.clients import chosen_place, client_address, while_connected
from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.page_files import page_file
from server.http.routes.sessions import SessionAnswer, created
from server.http.services import (
    CodeBrake,
    CopyBrake,
    IsSignedIn,
    OpenClasses,
    ServiceSettings,
    Sessions,
    Visitor,
    services_of,
)
from server.imports import imported
from server.network_address import reachable
from server.sessions import Plan, SessionBudgetError, SessionNotFoundError, SessionRegistry
from server.sessions.parts import Recording
from server.sources import log_plan
from server.sources.history import Replayable
from server.sources.simulation_kind import simulation_plan

if TYPE_CHECKING:
    from server.sessions import SessionHost
    from server.settings import Settings

MAX_COPIES = 2  #: of the lecturer's world for one follower, one of which is about to end
router = APIRouter(tags=["classes"])

#: Tells a reverse proxy in front of several services which class this service has (``deploy/haproxy.cfg``).
CLASS_HEADER = "X-Gridbloom-Class"


def _braked(brake: CodeGuesses, classroom: Classroom | None, request: Request | WebSocket, visitor: str) -> Classroom:
    """Return the class of a code. Raises :class:`ClassNotFoundError`, and 429 after many guesses."""
    address = client_address(request)
    if brake.wait_s(visitor, address) > 0.0:
        raise SessionBudgetError(
            "class.guesses", "Too many wrong codes came from this browser or its network: wait a minute."
        )
    if classroom is None:
        brake.count(visitor, address)
        raise unknown_class()
    return classroom


def _guessed(brake: CodeGuesses, classes: Classes, code: str, request: Request | WebSocket, visitor: str) -> Classroom:
    """Return a class to a visitor who has sent its code. Raises like ``_braked``.

    Members of the class do not count as guessing, so in a hall with one address, others' wrong codes do not lock them
    out.
    """
    return classes.joined(code, visitor) or _braked(brake, classes.find(code), request, visitor)


def owned_class(brake: CodeGuesses, classes: Classes, code: str, request: Request, visitor: str) -> Classroom:
    """Return a class to its lecturer. Raises like ``_braked`` for anyone else, whether or not the class exists."""
    return classes.owned(code, visitor) or _braked(brake, None, request, visitor)


def joined_class(
    brake: CodeGuesses, classes: Classes, code: str, request: Request | WebSocket, visitor: str
) -> Classroom:
    """Return a class to a visitor who has joined it or may join. Raises like ``_guessed`` and :meth:`Classes.check`."""
    room = _guessed(brake, classes, code, request, visitor)
    classes.check(room, visitor, client_address(request))
    return room


@dataclass(frozen=True, slots=True)
class ClassAnswer:
    """A class that a visitor may join, the number of its members, and the page that it shows."""

    code: str
    present: int
    page: str


@dataclass(frozen=True, slots=True)
class OpenClassAnswer(ClassAnswer):
    """A class as seen by its lecturer: the addresses of its page, of the counted answers, and of its QR code."""

    address: str
    results: str
    qr: str


def _public(request: Request, room: Classroom) -> OpenClassAnswer:
    settings, host = services_of(request.app).settings, request.headers["host"]
    host = host if settings.is_loopback else reachable(host)
    return OpenClassAnswer(
        code=room.code,
        present=room.present,
        page=room.view.page,
        address=f"{request.url.scheme}://{host}/class/{room.code}",
        results=f"/api/classes/{room.code}/results.csv",
        qr=f"/api/classes/{room.code}/qr.svg",
    )


@router.post("/api/classes", status_code=201)
async def open_class(request: Request, response: Response, classes: OpenClasses, visitor: Visitor) -> OpenClassAnswer:
    """Open a class, or return this visitor's open class."""
    room = classes.open(visitor)
    room.place = chosen_place(request)
    response.headers[CLASS_HEADER] = room.code
    return _public(request, room)


@router.get(
    "/api/classes", response_model=OpenClassAnswer, responses={204: {"description": "This visitor has no class open."}}
)
async def mine(request: Request, classes: OpenClasses, visitor: Visitor) -> OpenClassAnswer | Response:
    """Return this visitor's open class."""
    room = classes.of(visitor)
    return Response(status_code=204) if room is None else _public(request, room)


@router.delete("/api/classes/{code}", status_code=204)
async def end(
    request: Request, classes: OpenClasses, brake: CodeBrake, sessions: Sessions, visitor: Visitor, code: str
) -> None:
    """End a class. Its results are deleted, and the sessions of its followers end."""
    room = owned_class(brake, classes, code, request, visitor)
    classes.close(room)
    await sessions.end_linked(link_of(room))
    for number in range(1, len(room.puzzles) + 1):
        await sessions.end_linked(puzzle_link_of(room, number))


@router.get("/api/classes/{code}/results.csv", **file_answer("text/csv"))
async def results(request: Request, classes: OpenClasses, brake: CodeBrake, visitor: Visitor, code: str) -> Response:
    """Return the counted answers of all questions of a class."""
    room = owned_class(brake, classes, code, request, visitor)
    name = f"gridbloom-class-{room.code}.csv"
    headers = {"Content-Disposition": f'attachment; filename="{name}"', "Cache-Control": "no-store"}
    return Response(results_csv(room.questions, room.puzzles), media_type="text/csv; charset=utf-8", headers=headers)


@router.get("/api/classes/{code}/qr.svg", **file_answer("image/svg+xml"))
async def qr(request: Request, classes: OpenClasses, brake: CodeBrake, visitor: Visitor, code: str) -> Response:
    """Return the address of a class as a QR code."""
    room = owned_class(brake, classes, code, request, visitor)
    out = io.BytesIO()
    segno.make(_public(request, room).address, error="m", micro=False).save(
        out, kind="svg", border=4, dark="#000", light="#fff", xmldecl=False, omitsize=True
    )
    return Response(out.getvalue(), media_type="image/svg+xml", headers={"Cache-Control": "no-store"})


@router.get("/api/classes/{code}")
@guests_may(GuestRight.ALWAYS)
async def one(request: Request, classes: OpenClasses, brake: CodeBrake, visitor: Visitor, code: str) -> ClassAnswer:
    """Return whether there is a class with this code that can be joined, and which page it shows."""
    room = joined_class(brake, classes, code, request, visitor)
    return ClassAnswer(room.code, room.present, room.view.page)


@router.websocket("/api/classes/{code}/stream")
@guests_may(GuestRight.ALWAYS)
async def stream(
    websocket: WebSocket,
    classes: OpenClasses,
    brake: CodeBrake,
    visitor: Visitor,
    is_signed_in: IsSignedIn,
    code: str,
    follows: bool = False,
) -> None:
    """Exchange messages with a class. ``follows`` is for a page that follows it, also in its lecturer's browser."""
    await imported("server.http.class_connection")
    from server.http.class_connection import attend  # noqa: PLC0415 - what it imports comes with the first session

    classroom = _guessed(brake, classes, code, websocket, visitor)
    if classroom.owner == visitor and not follows and not is_signed_in:
        raise ClassRightError("class.signed_out", "The lecturer of this class has signed out.")
    room, member = classes.join(code, visitor, client_address(websocket), follows=follows)
    await attend(websocket, room, member)


def places_of(settings: Settings) -> int:
    """Return the maximum number of sessions of a class's followers."""
    return max(1, settings.max_sessions // 2)


def link_of(room: Classroom) -> str:
    """Return the link that marks the sessions of a class's followers."""
    return f"class {room.code}"


def puzzle_link_of(room: Classroom, number: int) -> str:
    """Return the link that marks the attempts of a class's followers at its puzzle of this number, from 1."""
    return f"{link_of(room)} puzzle {number}"


def _shown(
    classes: Classes, room: Classroom, sessions: SessionRegistry, connection: Request | WebSocket, visitor: str
) -> SessionHost:
    """Return the session shown by a class, to a visitor who has joined or may join."""
    classes.check(room, visitor, client_address(connection))
    if room.session is None:
        raise MapperError("class.no_session", "The lecturer is not showing a map.")
    return sessions.get(room.session)


@router.websocket("/api/classes/{code}/session")
@guests_may(GuestRight.ALWAYS)
async def shown(
    websocket: WebSocket,
    classes: OpenClasses,
    brake: CodeBrake,
    sessions: Sessions,
    settings: ServiceSettings,
    visitor: Visitor,
    code: str,
) -> None:
    """Watch the session that the lecturer shows. Commands are refused, except from the follower who has the robot."""
    await imported("server.http.stream_connection")
    from server.http.stream_connection import Following, exchange  # noqa: PLC0415 - comes with the first session

    room = _guessed(brake, classes, code, websocket, visitor)
    session = _shown(classes, room, sessions, websocket, visitor)
    following = Following(lambda command: room.may_drive(visitor, command), room.stage_over)
    with classes.watching(room, client_address(websocket)):
        await exchange(websocket, session, settings.max_class_followers, following)


@router.post("/api/classes/{code}/sessions", status_code=201)
@guests_may(GuestRight.ALWAYS)
async def fork(
    request: Request,
    response: Response,
    classes: OpenClasses,
    brake: CodeBrake,
    copies: CopyBrake,
    sessions: Sessions,
    settings: ServiceSettings,
    visitor: Visitor,
    code: str,
) -> SessionAnswer:
    """Begin a session with the current state of the one that the lecturer shows."""
    room = _guessed(brake, classes, code, request, visitor)
    session = _shown(classes, room, sessions, request, visitor)

    if copies.wait_s(visitor) > 0.0:
        raise SessionBudgetError("class.copies", "You have made many copies in a short time: wait a few seconds.")
    copies.count(visitor)
    link = link_of(room)

    async def begun() -> SessionHost:
        earlier = [s for s in sessions.all() if s.link == link and s.owner == visitor]
        if len(earlier) >= MAX_COPIES:  # created by pages that sent requests at the same time
            raise SessionBudgetError("class.copies", "You have too many copies of this world: wait a moment.")
        plan = await _copy(session, settings.max_story_s)
        address, places = client_address(request), places_of(settings)
        session_of_class = await sessions.begin(
            plan, visitor, link=link, address=address, places=places, place=session.place
        )
        for class_ in earlier:  # only once there is another one
            with suppress(SessionNotFoundError):
                await sessions.close(class_.id)
        return session_of_class

    session_of_class = await while_connected(request, begun())
    return created(response, session_of_class)


async def _copy(session: SessionHost, max_story_s: float) -> Plan:
    """Return the plan of a session with the current state of another one: a world, or a view of a log."""
    recording, replayable = session.model.find(Recording), session.model.find(Replayable)
    if recording is not None:
        return log_plan(recording.log, title=session.model.title, view=recording.view(), playing=False)
    if replayable is None:
        raise MapperError("class.fork", "Only a simulated world or the map of a log can be copied.")
    history = await replayable.present_history()
    return simulation_plan(history.world, history.seed, history, max_story_s=max_story_s)


# -- pages --------------------------------------------------------------------------------------------------------


@router.api_route("/join", methods=["GET", "HEAD"], include_in_schema=False)
@guests_may(GuestRight.ALWAYS)
async def join_page(request: Request) -> Response:
    """Return the page for entering the code of a class."""
    return page_file(request, "join.html")


@router.get("/class/{code}", include_in_schema=False)
@guests_may(GuestRight.ALWAYS)
async def enter(request: Request, classes: OpenClasses, brake: CodeBrake, visitor: Visitor, code: str) -> Response:
    """Redirect to the page that a class shows, or to the one for entering a code."""
    try:
        room = joined_class(brake, classes, code, request, visitor)
    except MapperError as error:
        return RedirectResponse(f"/join?refused={error.code}", status_code=303)
    return RedirectResponse(f"/class/{room.code}/{room.view.page}.html", status_code=303)


@router.api_route("/class/{code}/{name}", methods=["GET", "HEAD"], include_in_schema=False)
@guests_may(GuestRight.ALWAYS)
async def page(
    request: Request,
    classes: OpenClasses,
    brake: CodeBrake,
    visitor: Visitor,
    code: str,
    name: Literal["lecture.html", "lab.html", "logs.html", "puzzles.html", "other.html"],
) -> Response:
    """Return a page that follows a class."""
    try:
        room = joined_class(brake, classes, code, request, visitor)
    except MapperError as error:
        return RedirectResponse(f"/join?refused={error.code}", status_code=303)
    if code != normalised(code):
        return RedirectResponse(f"/class/{room.code}/{name}", status_code=303)
    response = page_file(request, "join.html" if name == "other.html" else name)
    response.headers["X-Robots-Tag"] = "noindex"
    return response
