"""``/api/sessions/{id}/run.mcap`` and ``trajectory.tum``: a log taken away, with its map and for other viewers."""

from __future__ import annotations

import asyncio
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from typing import IO

from fastapi import APIRouter, Request
from fastapi.responses import Response, StreamingResponse
from starlette.types import Receive, Scope, Send

from mapper.errors import LimitError, MapperError
from mapper.export import GrowingMap, tum_text, write_mcap
from mapper.scan import ScanLog
from mapper.threads import alone
from server.sessions import LogSession

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

MAX_AT_ONCE = 8  #: files of all visitors that are being made or fetched: each may be as large as its log
MAX_OF_VISITOR = 4  #: of them: who fetches slowly keeps nobody else from fetching
PIECE = 1 << 18


def _log_session(request: Request, session_id: str) -> LogSession:
    session = request.app.state.sessions.get(session_id)
    if not isinstance(session, LogSession):
        raise MapperError("session.no_log", "This session is no log's: it has no recorded scans to take away.")
    if session.link is not None:
        raise MapperError("link.read_only", "This link shares a view of the log, not the log itself.")
    return session


@router.get("/{session_id}/run.mcap")
async def run_mcap(request: Request, session_id: str) -> Response:
    """Return the log, and its map as it grew to what is shown now, as an MCAP file of ROS 2 messages."""
    session = _log_session(request, session_id)
    state, visitor = request.app.state, request.state.visitor
    if state.taken.total() >= MAX_AT_ONCE or state.taken[visitor] >= MAX_OF_VISITOR:
        raise LimitError("library.busy", "Too many files are being taken away; try again in a moment.")
    state.taken[visitor] += 1

    def give_back() -> None:
        state.taken -= Counter([visitor])

    try:
        growing_map, trajectory = await session.growing_map()
        file: IO[bytes] = tempfile.TemporaryFile(dir=state.settings.data_dir)  # noqa: SIM115 - ends with the answer
        try:
            await asyncio.to_thread(_write, file, session.log, growing_map, trajectory)
        except OSError as error:
            file.close()
            raise LimitError("log.storage", "The server could not make the file; its disk may be full.") from error
        except BaseException:
            file.close()
            raise
    except BaseException:
        give_back()
        raise
    headers = {
        "Content-Disposition": 'attachment; filename="run.mcap"',
        "Cache-Control": "no-store",
        "Content-Length": str(file.tell()),
        "Content-Encoding": "identity",  # it is compressed already
    }
    return _FileResponse(file, give_back, headers)


def _write(file: IO[bytes], log: ScanLog, growing_map: GrowingMap, trajectory: str) -> None:
    with alone():  # the map is made again: on one core, the other ones are the sessions'
        write_mcap(file, log, growing_map, trajectory)


class _FileResponse(StreamingResponse):
    """Sends a file that has no name, and lets go of it however the answer ends."""

    def __init__(self, file: IO[bytes], give_back: Callable[[], None], headers: dict[str, str]) -> None:
        super().__init__(_pieces(file), media_type="application/octet-stream", headers=headers)
        self._file = file
        self._give_back = give_back

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._file.close()
            self._give_back()


def _pieces(file: IO[bytes]) -> Iterator[bytes]:
    file.seek(0)
    while piece := file.read(PIECE):
        yield piece


@router.get("/{session_id}/trajectory.tum")
async def trajectory_tum(request: Request, session_id: str) -> Response:
    """Return where the robot was at each scan, by the trajectory in use, in TUM format."""
    session = _log_session(request, session_id)
    text = await asyncio.to_thread(tum_text, session.log, session.trajectory)
    headers = {"Content-Disposition": 'attachment; filename="trajectory.tum"', "Cache-Control": "no-store"}
    return Response(text, media_type="text/plain; charset=utf-8", headers=headers)
