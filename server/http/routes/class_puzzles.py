"""``/api/classes/{code}/puzzle``: a puzzle that a whole class solves, each member in a separate session."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mapper.core.errors import MapperError
from server.http.clients import client_address
from server.http.guests import GuestRight, guests_may
from server.http.routes.classes import joined_class, owned_class, places_of, puzzle_link_of
from server.http.routes.puzzles import Name, begin_puzzle
from server.http.routes.sessions import SessionAnswer, created
from server.http.services import AllPuzzles, CodeBrake, Logs, OpenClasses, ServiceSettings, Sessions, Visitor
from server.stream.class_messages import ClassSolver

if TYPE_CHECKING:
    from server.puzzles.game import Game

router = APIRouter(prefix="/api/classes", tags=["classes"])


class PuzzleOfClass(BaseModel, extra="forbid"):
    """A puzzle for a class."""

    puzzle: str = Field(max_length=100, description="Name of a puzzle of the program, or token of one that was made.")


@router.put("/{code}/puzzle", status_code=204)
async def give(
    request: Request,
    classes: OpenClasses,
    brake: CodeBrake,
    library: Logs,
    puzzles: AllPuzzles,
    visitor: Visitor,
    code: str,
    body: PuzzleOfClass,
) -> None:
    """Assign a puzzle to the class."""
    room = owned_class(brake, classes, code, request, visitor)
    known = {puzzle.name: puzzle.title for puzzle in puzzles.offered()}
    room.give_puzzle(body.puzzle, known.get(body.puzzle) or library.puzzles.get(body.puzzle).title)


@router.delete("/{code}/puzzle", status_code=204)
async def close(request: Request, classes: OpenClasses, brake: CodeBrake, visitor: Visitor, code: str) -> None:
    """End the puzzle of a class; its results are kept until the class ends."""
    owned_class(brake, classes, code, request, visitor).close_puzzle()


@router.post("/{code}/puzzle/sessions", status_code=201)
@guests_may(GuestRight.ALWAYS)
async def begin(
    request: Request,
    response: Response,
    classes: OpenClasses,
    brake: CodeBrake,
    sessions: Sessions,
    library: Logs,
    puzzles: AllPuzzles,
    settings: ServiceSettings,
    visitor: Visitor,
    code: str,
    name: Name = None,
) -> SessionAnswer:
    """Begin an attempt at the puzzle of the class. A running attempt continues."""
    room = joined_class(brake, classes, code, request, visitor)
    puzzle = room.puzzle
    if puzzle is None:
        raise MapperError("class.no_puzzle", "The class has no puzzle now.")
    number = room.number_of(visitor, client_address(request))
    link = puzzle_link_of(room, len(room.puzzles))
    for live in sessions.all():
        if live.link == link and live.owner == visitor:
            return created(response, live)
    session = await begin_puzzle(
        request,
        sessions,
        library,
        puzzles,
        visitor,
        puzzle.key,
        link=link,
        places=places_of(settings),
        place=room.place,
        name=name,
    )
    game: Game = puzzles.game(session.id)

    def changed() -> None:
        progress = game.progress
        room.solver_moved(puzzle, ClassSolver(number, progress.is_named, progress.best, game.is_solved, game.points))

    if number:  # the lecturer may try it too
        # Progress is stored by number, so that a follower who begins again continues with it.
        game.progress = puzzle.progress.setdefault(number, game.progress)
        game.changed = changed
        changed()
    return created(response, session)
