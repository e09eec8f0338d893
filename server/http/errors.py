"""The JSON form of every error, ``{code, message, detail}``: a stable code, a sentence, and an optional detail.

A browser that opens the address of a missing page gets a page instead.
"""

from __future__ import annotations

import asyncio
from http import HTTPStatus

import structlog
from fastapi import FastAPI, Request, WebSocket
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketState

from mapper.core.errors import ConfigError, LimitError, MapperError, ReadError
from server.classes import ClassBudgetError, ClassNotFoundError, ClassRightError
from server.downloads import MapSnapshotGoneError
from server.http.page_files import missing_page
from server.library.annotations.added import TrajectoryNotFoundError
from server.library.annotations.links import LinkGoneError
from server.library.annotations.notes import NoteNotFoundError, NoteReadOnlyError
from server.library.annotations.puzzles import PuzzleGoneError
from server.library.logs.records import LogNotFoundError, LogReadOnlyError
from server.sessions import SessionBudgetError, SessionNotFoundError
from server.storage import StorageError
from server.stream.close_codes import REFUSED
from server.work.memory import MemoryReserve, is_out_of_memory

_log = structlog.get_logger(__name__)

#: The first matching class determines the status. Individual codes may have their own.
_STATUS: tuple[tuple[type[MapperError], int], ...] = (
    (SessionNotFoundError, 404),
    (LinkGoneError, 404),
    (PuzzleGoneError, 404),
    (ClassNotFoundError, 404),
    (ClassRightError, 403),
    (ClassBudgetError, 429),
    (MapSnapshotGoneError, 410),
    (LogNotFoundError, 404),
    (TrajectoryNotFoundError, 404),
    (LogReadOnlyError, 403),
    (NoteNotFoundError, 404),
    (NoteReadOnlyError, 403),
    (SessionBudgetError, 429),
    (StorageError, 503),
    (LimitError, 413),
    (ConfigError, 422),
    (ReadError, 422),
    (MapperError, 409),
)
_STATUS_OF_CODE = {
    "download.busy": 503,
    "download.too_many": 429,
    "session.full": 503,
    "session.memory": 503,
    "session.not_yours": 403,
    "report.no_pdf": 501,
    "report.pdf_failed": 503,
    "library.busy": 503,
    "library.full": 507,
    "library.too_many": 409,
    "link.read_only": 403,
    "link.too_many": 409,
    "note.pin": 422,
    "note.too_many": 409,
    "localization.busy": 503,
    "localization.too_many": 429,
    "log.gone": 410,
    "graph.none": 404,
    "log.stalled": 408,
    "log.storage": 507,
    "slam.busy": 503,
    "slam.too_many": 429,
    "trajectory.too_many": 409,
}

_BEGINNING = frozenset({"POST", "PUT", "PATCH"})  #: methods of requests that start something


def error_response(
    status: int, code: str, message: str, detail: object = None, headers: dict[str, str] | None = None
) -> JSONResponse:
    """Return an error."""
    return JSONResponse({"code": code, "message": message, "detail": detail}, status_code=status, headers=headers)


def status_of(error: MapperError) -> int:
    """Return the HTTP status of an error."""
    if error.code in _STATUS_OF_CODE:
        return _STATUS_OF_CODE[error.code]
    return next(status for kind, status in _STATUS if isinstance(error, kind))


def install_error_handlers(app: FastAPI) -> None:
    """Register the handlers that convert all errors of the application to this form."""
    app.add_exception_handler(MapperError, _mapper_error)  # type: ignore[arg-type] # for requests and sockets alike
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(RequestValidationError, _invalid_request)


async def _mapper_error(connection: Request | WebSocket, error: Exception) -> JSONResponse | None:
    assert isinstance(error, MapperError)  # noqa: S101 - for the type checker: it is registered for this class
    if isinstance(connection, WebSocket):
        # A browser reports nothing about a refused handshake, so the socket is opened and closed to tell the page why.
        if connection.application_state == WebSocketState.CONNECTING:
            await connection.accept(subprotocol=next(iter(connection.scope["subprotocols"]), None))
        await connection.close(REFUSED.code, error.code)
        return None
    status = status_of(error)
    headers = {"Retry-After": "30"} if status in (429, 503) else None
    return error_response(status, error.code, error.message, headers=headers)


async def _http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)  # noqa: S101 - for the type checker: it is registered for this class
    if error.status_code == 404 and (page := missing_page(request)) is not None:
        return page
    status = HTTPStatus(error.status_code)
    messages = {404: "There is nothing at this address.", 405: "This address does not accept this method."}
    code = f"http.{status.phrase.lower().replace(' ', '_')}"
    headers = dict(error.headers) if error.headers else None
    return error_response(status, code, messages.get(status, f"{str(error.detail).rstrip('.')}."), headers=headers)


async def _invalid_request(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)  # noqa: S101 - for the type checker: it is registered for this class
    detail = [{"where": ".".join(str(part) for part in item["loc"]), "message": item["msg"]} for item in error.errors()]
    first = detail[0] if detail else {"where": "request", "message": "cannot be read"}
    return error_response(422, "request.invalid", f"{first['where']}: {first['message']}.", detail)


class CatchAll:
    """Innermost middleware: answer an unexpected exception with status 500, without its details, and log it."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle a request, and answer if that fails."""
        started = False

        async def watched(message: Message) -> None:
            nonlocal started
            started = started or message["type"] in ("http.response.start", "websocket.accept")
            await send(message)

        try:
            await self._app(scope, receive, watched)
        except Exception as error:
            if scope["type"] != "http":
                raise
            is_short = is_out_of_memory(error)
            if is_short:
                _log.warning("a request needed more memory than there is", method=scope["method"], error=str(error))
            else:
                _log.exception("a request failed", method=scope["method"])
            if started:
                raise  # part of the answer is sent, so only closing the connection shows the failure
            response = (
                out_of_memory()
                if is_short
                else error_response(500, "internal", "The request failed because of a defect in the service.")
            )
            await response(scope, receive, send)


def out_of_memory() -> JSONResponse:
    """Return the answer to a request for which memory is insufficient."""
    message = "The service has no memory left for this now."
    return error_response(503, "service.memory", message, headers={"Retry-After": "30"})


class EnoughMemory:
    """Middleware: refuse requests that start something while memory is short; reading and deleting still work."""

    def __init__(self, app: ASGIApp, reserve: MemoryReserve) -> None:
        self._app, self._reserve = app, reserve

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle a request, or refuse it."""
        if scope["type"] == "http" and scope["method"] in _BEGINNING and self._reserve.is_short():
            await out_of_memory()(scope, receive, send)
            return
        await self._app(scope, receive, send)


class Ending:
    """Outermost middleware: answer a request that uvicorn cancels at shutdown with status 503.

    Without it, each stalled request would log a traceback at shutdown.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle a request, and answer if it is cancelled."""
        started = False

        async def watched(message: Message) -> None:
            nonlocal started
            started = True
            await send(message)

        try:
            await self._app(scope, receive, watched)
        except asyncio.CancelledError:
            if scope["type"] != "http":
                raise
            if not started:
                response = error_response(503, "service.ending", "The service is ending.", headers={"Retry-After": "5"})
                await response(scope, receive, send)
