"""``/api/puzzles``: begin, solve, create and remove puzzles; ``/puzzle/TOKEN``: the page of a visitor's puzzle.

An attempt belongs to a session of the puzzle. The answers to the page never contain the cause before it is named.
"""

from __future__ import annotations

import asyncio
import secrets
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mapper.core.errors import MapperError
from mapper.core.parameter import changed_values
from mapper.sensors.planar.options import PlanarCut
from server.http.clients import chosen_place, client_address, while_connected
from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.page_files import page_of_secret
from server.http.routes.sessions import SessionAnswer, created
from server.http.services import AllPuzzles, Logs, RequestWork, Sessions, Visitor
from server.http.session_access import part_of_log, writable_session
from server.imports import imported
from server.library.annotations.puzzles import MadePuzzle, PuzzleGoneError
from server.library.library import Library
from server.puzzles.answers import Attempt, NamedCause, OfferedPuzzle
from server.sessions.parts import Recording
from server.sources.history import Replayable

if TYPE_CHECKING:
    from server.sessions import SessionHost, SessionRegistry

router = APIRouter(tags=["puzzles"])

Name = Annotated[
    str | None, Query(max_length=100, description="Name under which /api/sessions/making/{name} has the progress.")
]


class NewPuzzle(BaseModel, extra="forbid"):
    """A puzzle from the current state of a session."""

    fault: str = Field("as-it-is", max_length=40, description="Fault to add, as in GET; as-it-is: that of the session.")
    title: str = Field("", max_length=80, description="Title; by default that of the world or log.")


class AttemptAnswer(BaseModel, extra="forbid"):
    """An answer to a puzzle."""

    cause: str = Field(max_length=40, description="Name of the cause.")


@dataclass(frozen=True, slots=True)
class MadePuzzleAnswer:
    """A visitor's puzzle as seen by that visitor."""

    token: str
    address: str
    title: str
    created_s: float
    fault: str


@dataclass(frozen=True, slots=True)
class PuzzleList:
    """Puzzles included in the program, faults that can be added to a map, and this visitor's own puzzles."""

    puzzles: list[OfferedPuzzle]
    faults: list[NamedCause]
    mine: list[MadePuzzleAnswer]


@dataclass(frozen=True, slots=True)
class SharedPuzzle:
    """The title of a visitor's puzzle."""

    title: str


def _public(puzzle: MadePuzzle) -> MadePuzzleAnswer:
    from server.puzzles.spec import spec_from_text  # noqa: PLC0415 - imported with the first puzzle

    cause = spec_from_text(puzzle.spec).cause
    return MadePuzzleAnswer(puzzle.token, f"/puzzle/{puzzle.token}", puzzle.title, puzzle.created_s, cause)


# -- list and create -----------------------------------------------------------------------------------------------


@router.get("/api/puzzles")
async def all_puzzles(puzzles: AllPuzzles, library: Logs, visitor: Visitor) -> PuzzleList:
    """Return the puzzles included in the program, the faults that can be added, and this visitor's own puzzles."""
    await imported("server.puzzles.spec")
    return PuzzleList(puzzles.offered(), puzzles.faults(), [_public(puzzle) for puzzle in library.puzzles.of(visitor)])


@router.get("/api/puzzles/{puzzle}/map.png", **file_answer("image/png"))
async def picture(puzzle: str, *, dark: bool = False) -> Response:
    """Return a small picture of the initial map of an included puzzle."""
    await imported("server.puzzles.pictures")
    from server.puzzles.pictures import picture_of  # noqa: PLC0415 - imported with the first puzzle

    return Response(
        await asyncio.to_thread(picture_of, puzzle, dark=dark),
        media_type="image/png",
        headers={"Cache-Control": "private, max-age=300"},
    )


@router.post("/api/sessions/{session_id}/puzzles", status_code=201)
async def make(
    sessions: Sessions, library: Logs, visitor: Visitor, session_id: str, body: NewPuzzle
) -> MadePuzzleAnswer:
    """Create a puzzle from the current state of a session, with a fault. Anyone with its address may solve it."""
    await imported("server.puzzles.spec")
    from server.puzzles.spec import (  # noqa: PLC0415 - imported with the first puzzle
        spec_of_log,
        spec_of_world,
        spec_text,
    )

    session, seed = sessions.get(session_id), secrets.randbelow(2**31)
    replayable = session.model.find(Replayable)
    if replayable is not None:
        if session.owner != visitor:
            raise MapperError("session.not_yours", "A puzzle is made by the visitor who began the session.")
        history = await replayable.present_history()
        cone = history.sensor.get("kind") == "sonar_ring"
        text, record = spec_text(spec_of_world(history, body.fault, seed, cone=cone)), None
    else:
        of_log = writable_session(sessions, session_id)
        record = library.get(of_log.owner, of_log.log_id)
        recording, seen = of_log.recording, of_log.recording.view()
        first = recording.first_config()
        values = changed_values(first.with_values(seen.values or {}), first)
        text = spec_text(spec_of_log(seen, values, body.fault, seed, cone=recording.log.beam_width > 0.0))
    title = body.title.strip() or session.model.title
    return _public(await library.puzzles.make(session.owner, record, title, text))


@router.delete("/api/puzzles/{token}", status_code=204)
async def remove(sessions: Sessions, library: Logs, puzzles: AllPuzzles, visitor: Visitor, token: str) -> None:
    """Remove a puzzle of this visitor. The attempts at it end."""
    await library.puzzles.remove(visitor, token)
    puzzles.forget(token)
    await sessions.end_linked(link_of(token))


# -- start ---------------------------------------------------------------------------------------------------------


def link_of(token: str) -> str:
    """Return the link that marks the sessions of a visitor's puzzle."""
    return f"puzzle {token}"


async def begin_puzzle(
    request: Request,
    sessions: SessionRegistry,
    library: Library,
    puzzles: Any,  # noqa: ANN401 - see AllPuzzles
    visitor: str,
    key: str,
    *,
    link: str | None,
    places: int | None = None,
    place: str | None = None,
    name: str | None = None,
) -> SessionHost:
    """Begin a session of a puzzle: an included one, or the token of a visitor's puzzle.

    ``place`` is the key by which a reverse proxy finds this service; None: that of the request.
    """
    await imported("server.puzzles.making")
    from mapper.puzzles import RECIPES  # noqa: PLC0415 - imported with the first puzzle
    from server.puzzles.making import LogSource, WorldSource  # noqa: PLC0415
    from server.puzzles.spec import WorldSpec, spec_from_text  # noqa: PLC0415

    if key in RECIPES:
        recipe = RECIPES[key]
        source, title, story, level = puzzles.recipe(key), recipe.title, recipe.story, recipe.level
    else:
        puzzle = library.puzzles.get(key)
        title, story, level, spec = puzzle.title, "", 0, spec_from_text(puzzle.spec)
        if isinstance(spec, WorldSpec):
            source = WorldSource(spec)
        else:
            if puzzle.log_id is None:
                raise PuzzleGoneError("puzzle.gone", "The log of this puzzle no longer exists.")
            view = spec.view
            cut = PlanarCut.of(view.cut or {})
            source = LogSource(spec, await library.load(puzzle.owner, puzzle.log_id, view.topic, cut))
    plan = puzzles.plan(key, source, title, name)

    async def begun() -> SessionHost:
        chosen = chosen_place(request) if place is None else place
        return await sessions.begin(
            plan, visitor, link=link, address=client_address(request), places=places, place=chosen
        )

    session = await while_connected(request, begun())
    puzzles.begin(session, key, title, story, level)
    return session


@router.post("/api/puzzles/{puzzle}/sessions", status_code=201)
async def begin(
    request: Request,
    response: Response,
    sessions: Sessions,
    library: Logs,
    puzzles: AllPuzzles,
    visitor: Visitor,
    puzzle: str,
    name: Name = None,
) -> SessionAnswer:
    """Begin an attempt at an included puzzle."""
    puzzles.recipe(puzzle)  # raises for any other
    session = await begin_puzzle(request, sessions, library, puzzles, visitor, puzzle, link=None, name=name)
    return created(response, session)


@router.get("/api/shared-puzzles/{token}")
@guests_may(GuestRight.ALWAYS)
async def shared(library: Logs, token: str) -> SharedPuzzle:
    """Return the title of a visitor's puzzle."""
    return SharedPuzzle(library.puzzles.get(token).title)


@router.post("/api/shared-puzzles/{token}/sessions", status_code=201)
@guests_may(GuestRight.ALWAYS)
async def begin_shared(
    request: Request,
    response: Response,
    sessions: Sessions,
    library: Logs,
    puzzles: AllPuzzles,
    visitor: Visitor,
    token: str,
    name: Name = None,
) -> SessionAnswer:
    """Begin an attempt at a visitor's puzzle."""
    library.puzzles.get(token)
    session = await begin_puzzle(request, sessions, library, puzzles, visitor, token, link=link_of(token), name=name)
    return created(response, session)


@router.api_route("/puzzle/{token}", methods=["GET", "HEAD"], include_in_schema=False)
@guests_may(GuestRight.ALWAYS)
async def page(request: Request, library: Logs, token: str) -> Response:
    """Return the page of a visitor's puzzle, with status 404 if there is none."""
    return page_of_secret(request, "puzzles.html", lambda: library.puzzles.get(token), PuzzleGoneError)


# -- an attempt ----------------------------------------------------------------------------------------------------


@router.get("/api/sessions/{session_id}/puzzle")
@guests_may(GuestRight.LINKED_SESSION)
async def attempt(puzzles: AllPuzzles, session_id: str) -> Attempt:
    """Return the state of a session's attempt: the causes, hints, measures, points, and at the end the answer."""
    return puzzles.game(session_id).public()


@router.post("/api/sessions/{session_id}/puzzle/answer")
@guests_may(GuestRight.LINKED_SESSION)
async def answer(puzzles: AllPuzzles, session_id: str, body: AttemptAnswer) -> Attempt:
    """Name the cause; answer as GET does."""
    game = puzzles.game(session_id)
    game.answer(body.cause)
    return game.public()


@router.post("/api/sessions/{session_id}/puzzle/hint")
@guests_may(GuestRight.LINKED_SESSION)
async def hint(puzzles: AllPuzzles, session_id: str) -> Attempt:
    """Show one more hint, which costs points; answer as GET does."""
    game = puzzles.game(session_id)
    game.hint()
    return game.public()


@router.post("/api/sessions/{session_id}/puzzle/solution")
@guests_may(GuestRight.LINKED_SESSION)
async def solution(puzzles: AllPuzzles, session_id: str) -> Attempt:
    """Show the answer, which ends the attempt without points; answer as GET does."""
    game = puzzles.game(session_id)
    game.give_up()
    return game.public()


@router.post("/api/sessions/{session_id}/puzzle/check")
@guests_may(GuestRight.LINKED_SESSION)
async def check(
    request: Request, sessions: Sessions, puzzles: AllPuzzles, work: RequestWork, visitor: Visitor, session_id: str
) -> Attempt:
    """Measure the map of all scans with the session's current parameters and poses; answer as GET does."""
    game, session = puzzles.game(session_id), sessions.get(session_id)
    recording = part_of_log(session, Recording, "This session has no log.")
    goes_on = True

    async def measured() -> None:
        nonlocal goes_on
        try:
            async with work.of(visitor, client_address(request)):
                seen = recording.view()
                values, trajectory = seen.values or {}, seen.trajectory or recording.trajectory
                now = await asyncio.to_thread(
                    game.puzzle.measured, values, trajectory, session.limits(), lambda: goes_on
                )
        finally:
            goes_on = False
        game.check(now)

    await while_connected(request, measured())
    return game.public()
