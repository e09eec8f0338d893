"""``/api/sessions/{id}/run.mcap`` and ``trajectory.tum``: a log as files for other programs."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from typing import IO, TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import Response

from mapper.core.errors import MapperError
from mapper.core.parallel import single_threaded
from mapper.io import export
from mapper.io.export import tum_lines
from server.downloads import Content, Download, file_name
from server.http.file_answer import file_answer
from server.http.routes.maps import requester_of, stem_of
from server.http.services import FileDownloads, Sessions
from server.sessions import SessionRegistry
from server.sessions.parts import Recording

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

PIECE = 1 << 18


def _recorded(sessions: SessionRegistry, session_id: str) -> tuple[SessionHost, Recording]:
    session = sessions.get(session_id)
    recording = session.model.find(Recording)
    if recording is None:
        raise MapperError("session.no_log", "This session shows no log: it has no recorded scans to download.")
    if session.link is not None:
        raise MapperError("link.read_only", "This link shares a view of the log, not the log itself.")
    return session, recording


@router.get("/{session_id}/run.mcap", **file_answer("application/octet-stream"))
async def run_mcap(request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str) -> Response:
    """Return the log, and its map as it grew up to the current scan, as an MCAP file of ROS 2 messages.

    The scans of several sensors are on the topics of the recording.
    """
    session, recording = _recorded(sessions, session_id)

    async def make() -> Content:
        file: IO[bytes] = tempfile.TemporaryFile(dir=downloads.folder)  # noqa: SIM115 - Content closes it
        try:
            async with downloads.export_turn:
                growing_map, trajectory = await recording.growing_map()

                def work(check: Callable[[], None]) -> None:
                    with single_threaded():  # the map is recomputed on one core, because sessions use the others
                        export.write_mcap(file, recording.log, growing_map, trajectory, lambda _: check())

                await downloads.run(work, takes_long=True)
        except BaseException:
            file.close()
            raise
        name = file_name(stem_of(session), "mcap", title=session.model.title)
        return Content(name, _pieces(file), file.tell(), file.close)

    response = Download(downloads, requester_of(request, session), make, "application/octet-stream")
    response.headers["Content-Encoding"] = "identity"  # it is already compressed
    return response


def _pieces(file: IO[bytes]) -> Iterator[bytes]:
    file.seek(0)
    while piece := file.read(PIECE):
        yield piece


@router.get("/{session_id}/trajectory.tum", **file_answer("text/plain"))
async def trajectory_tum(request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str) -> Response:
    """Return the robot's pose at each scan, along the current trajectory, in TUM format."""
    session, recording = _recorded(sessions, session_id)

    async def make() -> Content:
        name = file_name(stem_of(session), "tum", title=session.model.title)
        return Content(name, (line.encode() for line in tum_lines(recording.log, recording.trajectory)))

    return Download(downloads, requester_of(request, session), make, "text/plain; charset=utf-8")
