"""``/api/sessions/{id}/compare``: compare the map of a log with another map, cell by cell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import Response
from msgspec import convert, to_builtins
from pydantic import BaseModel, Field

from mapper.core.errors import MapperError
from mapper.core.parameter import Values
from mapper.io.maps.images import png_pieces
from mapper.io.maps.pixels import DIFFERENCE_PALETTE, difference_pixels
from server.downloads import Content, Download, file_name
from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.routes.maps import compressed_image, requester_of, stem_of
from server.http.services import FileDownloads, Logs, Sessions, Visitor
from server.http.session_access import part_of_log
from server.sessions import SessionRegistry
from server.sessions.kind import GivenValues
from server.sessions.parts import Comparable
from server.sessions.view import MapRequest
from server.stream.message_parts import Compared

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api/sessions", tags=["sessions"])


class ComparedMap(BaseModel, extra="forbid"):
    """The other side, A: a map of the session's log or of another one."""

    values: GivenValues = Field({}, description="Parameters set for A; all others are the session's.")
    trajectory: str | None = Field(None, max_length=200, description="Trajectory of A; by default the log's first.")
    log: str | None = Field(None, max_length=200, description="Id of another log, as in /api/logs.")
    topic: str | None = Field(None, max_length=400, description="Sensor of that log, if it has several.")


@dataclass(frozen=True, slots=True)
class SecondMap:
    """Map A: the parameters in which it differs from the session's, its trajectory, and its log (null: the same)."""

    values: Values
    with_faults: bool
    trajectory: str
    log: str | None
    topic: str | None
    title: str


@dataclass(frozen=True, slots=True)
class RefusedComparison:
    """Two maps that are both shown, and the reason why their cells cannot be compared."""

    a: SecondMap | None
    refused: str


@dataclass(frozen=True, slots=True)
class ComparisonAnswer:
    """The numbers of a comparison, see :class:`mapper.grid.compare.Comparison`. Pairs are (A, B)."""

    a: SecondMap | None
    refused: None
    cells: int
    states: list[list[int]]
    same: int
    only: list[int]
    both: int
    entropy_bits: list[float]
    contrast: list[float]
    mean_difference: float
    max_difference: float
    max_at: list[float] | None


def _compared(sessions: SessionRegistry, session_id: str) -> tuple[SessionHost, Comparable]:
    session = sessions.get(session_id)
    return session, part_of_log(session, Comparable, "Only the map of a log can be compared here.")


@router.put("/{session_id}/compare")
@guests_may(GuestRight.LINKED_SESSION)
async def begin(
    sessions: Sessions, library: Logs, visitor: Visitor, session_id: str, body: ComparedMap
) -> ComparisonAnswer | RefusedComparison:
    """Compare the session's map, B, with another map, A, in every window on the session; answer as GET does."""
    session, comparison = _compared(sessions, session_id)
    log, title = None, ""
    if body.log is not None:
        if session.link is not None:
            raise MapperError(
                "link.read_only", "This link shares a view of one log; it cannot be compared with another."
            )
        log = await library.load(visitor, body.log, body.topic)
        title = library.get(visitor, body.log).name
        await sessions.free_bytes(log, session.owner)
    await comparison.compare(MapRequest(body.values, body.trajectory, log, body.log, body.topic, title))
    try:
        return await _comparison(comparison)
    except MapperError as error:
        # Both maps are still shown, without comparing their cells.
        return RefusedComparison(_second(comparison.description()), error.message)


@router.delete("/{session_id}/compare", status_code=204)
@guests_may(GuestRight.LINKED_SESSION)
async def end(sessions: Sessions, session_id: str) -> None:
    """End the comparison."""
    _, comparison = _compared(sessions, session_id)
    await comparison.compare(None)


@router.get("/{session_id}/compare")
@guests_may(GuestRight.LINKED_SESSION)
async def compared(sessions: Sessions, session_id: str) -> ComparisonAnswer:
    """Return A and the numbers of the comparison of the two maps (:class:`mapper.grid.compare.Comparison`)."""
    return await _comparison(_compared(sessions, session_id)[1])


async def _comparison(comparison: Comparable) -> ComparisonAnswer:
    from server.parts.comparison.part import numbers  # noqa: PLC0415 - imported with the comparison

    other, result = await comparison.compared()
    return convert({"a": to_builtins(other), "refused": None} | to_builtins(numbers(result)), ComparisonAnswer)


def _second(described: Compared | None) -> SecondMap | None:
    return None if described is None else SecondMap(**to_builtins(described))


@router.get("/{session_id}/compare.png", **file_answer("image/png"))
@guests_may(GuestRight.LINKED_SESSION)
async def picture(request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str) -> Response:
    """Return ℓ of B minus ℓ of A as an image: orange is more occupied in B, blue more free."""
    session, comparison = _compared(sessions, session_id)

    async def make() -> Content:
        async with session.settled():
            image = await compressed_image(downloads, lambda: difference_pixels(*comparison.grids()))
        name = file_name(stem_of(session), "png", "difference")
        return Content(name, png_pieces(image.shape, image.bands(), DIFFERENCE_PALETTE))

    return Download(downloads, requester_of(request, session), make, "image/png")
