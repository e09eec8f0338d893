"""``/api/logs``: upload a log, see what is known of one's logs, delete one."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import JSONResponse, Response
from starlette.requests import ClientDisconnect

from server.library import Library

router = APIRouter(prefix="/api/logs", tags=["logs"])


@router.put("", status_code=202)
async def upload(request: Request, name: Annotated[str, Query(max_length=1000)] = "log") -> Response:
    """Store the raw body of the request as a log of this visitor's and queue it for reading."""
    library: Library = request.app.state.library
    declared = request.headers.get("content-length", "")
    size = int(declared) if declared.isascii() and declared.isdigit() else None
    try:
        record = await library.put(request.state.visitor, name, request.stream(), size)
    except ClientDisconnect:
        return Response(status_code=400)  # nobody is there to read it
    return JSONResponse(record.public(), status_code=202, headers={"Location": f"/api/logs/{record.id}"})


@router.get("")
async def list_logs(request: Request) -> dict[str, Any]:
    """List the logs that this visitor may open: own uploads, the server's folder, the sample."""
    library: Library = request.app.state.library
    return {"logs": [record.public() for record in await library.list(request.state.visitor)]}


@router.get("/{log_id}")
async def one(request: Request, log_id: str) -> dict[str, Any]:
    """Tell what is known of one log: its state, and once it was read, what it holds."""
    library: Library = request.app.state.library
    return library.get(request.state.visitor, log_id).public()


@router.post("/{log_id}/cancel")
async def cancel(request: Request, log_id: str) -> dict[str, Any]:
    """Stop reading an upload of this visitor's; it stays, and can be read again."""
    library: Library = request.app.state.library
    return (await library.cancel(request.state.visitor, log_id)).public()


@router.post("/{log_id}/read", status_code=202)
async def read_again(request: Request, log_id: str) -> dict[str, Any]:
    """Read an upload of this visitor's again, if that failed."""
    library: Library = request.app.state.library
    return library.read_again(request.state.visitor, log_id).public()


@router.delete("/{log_id}", status_code=204)
async def delete(request: Request, log_id: str) -> None:
    """Delete an upload of this visitor's. Sessions that have it open go on."""
    library: Library = request.app.state.library
    await library.delete(request.state.visitor, log_id)
