"""``/api/sessions/{id}/edited-map``: an edited map, saved as a new map or downloaded as files."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mapper.core.errors import LimitError, MapperError
from server.downloads import Content, Download, file_stem
from server.http.clients import client_address
from server.http.file_answer import file_answer
from server.http.routes.maps import grid_of, requester_of, stem_of
from server.http.services import FileDownloads, Logs, Sessions, Visitor
from server.library.logs.records import LogAnswer
from server.library.packs.map_files import archived
from server.library.processing.reference_maps import MOST_CELLS
from server.sessions.parts import EditedFiles

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

#: Path component of each file of an edited map, and the ending of the file's name.
_ENDINGS = {
    "map.pgm": ".pgm", "map.yaml": ".yaml", "keepout.pgm": "_keepout.pgm", "keepout.yaml": "_keepout.yaml",
    "speed.pgm": "_speed.pgm", "speed.yaml": "_speed.yaml", "edits.json": ".edits.json",
}  # fmt: skip
_UNPAINTED = {"keepout": "The map has no keepout zones.", "speed": "The map has no speed limits."}


class NewMap(BaseModel, extra="forbid"):
    """A map to save."""

    name: str = Field(min_length=1, max_length=100, description="Name of the new map.")


def _edited(session: SessionHost) -> EditedFiles:
    edited = session.model.find(EditedFiles)
    if edited is None:
        raise MapperError("session.not_a_map", "This session shows no map that is edited.")
    return edited


async def _pieces(data: bytes) -> AsyncIterator[bytes]:
    yield data


@router.post("/{session_id}/edited-map", status_code=201)
async def keep(
    request: Request, library: Logs, sessions: Sessions, visitor: Visitor, session_id: str, body: NewMap
) -> LogAnswer:
    """Save the session's edited map with its edits as a new map of this visitor; return its record."""
    files = await _edited(sessions.get(session_id)).files(file_stem(body.name))
    data = archived(files)
    record = await library.put(visitor, body.name, _pieces(data), len(data), address=client_address(request))
    return record.public()


@router.get("/{session_id}/edited-map/{name}", **file_answer("application/json", "application/octet-stream"))
async def file(request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str, name: str) -> Response:
    """Return a file of the session's edited map.

    The files are ``map.pgm`` and ``map.yaml``; ``keepout.pgm``, ``keepout.yaml``, ``speed.pgm`` and ``speed.yaml``, the
    masks of Nav2's filters; and ``edits.json``, which ``gridbloom edit`` can apply.
    """
    session = sessions.get(session_id)
    edited, stem = _edited(session), f"{stem_of(session)}_edited"

    async def make() -> Content:
        for own, data in await edited.files(stem):
            if own == stem + _ENDINGS.get(name, "/"):
                return Content(own, iter([data]), len(data))
        missing = _UNPAINTED.get(name.partition(".")[0]) if name in _ENDINGS else None
        raise MapperError("map.no_file", missing or f"There is no file {name!r:.80}.")

    media = "application/json" if name.endswith(".json") else "application/octet-stream"
    return Download(downloads, requester_of(request, session), make, media)


@router.post("/{session_id}/kept-map", status_code=201)
async def keep_present(
    request: Request, library: Logs, sessions: Sessions, visitor: Visitor, session_id: str, body: NewMap
) -> LogAnswer:
    """Save the current map of a session, of a world or a log, as a new map of this visitor; return its record."""
    from mapper.editing import EditedMap  # noqa: PLC0415 - few visitors edit maps
    from mapper.editing.files import map_files  # noqa: PLC0415

    session = sessions.get(session_id)
    stem, frame = file_stem(body.name), session.model.frame_id

    def work() -> bytes:
        grid = grid_of(session)
        if grid.geometry.rows * grid.geometry.cols > MOST_CELLS:
            raise LimitError("map.cells", f"The map has more than the {MOST_CELLS:,} cells that are kept here.")
        return archived(map_files(EditedMap(grid.geometry, grid.classify()), stem, frame=frame))

    async with session.settled():
        data = await session.on_thread(work)
    record = await library.put(visitor, body.name, _pieces(data), len(data), address=client_address(request))
    return record.public()
