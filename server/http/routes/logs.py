"""``/api/logs``: upload a log, see what is known of one's logs, delete one."""

from __future__ import annotations

import re
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import JSONResponse, Response
from pydantic import StringConstraints
from starlette.requests import ClientDisconnect

from mapper.core.errors import ReadError
from server.library import Library, Part, Record

router = APIRouter(prefix="/api/logs", tags=["logs"])


Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_-]{16,64}$")]
Digest = Annotated[str, StringConstraints(pattern=r"^[0-9A-Fa-f]{64}$")]
_CONTENT_RANGE = re.compile(r"bytes ([0-9]{1,15})-([0-9]{1,15})/([0-9]{1,15})")


@router.put("", status_code=202)
async def upload(
    request: Request,
    name: Annotated[str, Query(max_length=1000)] = "log",
    upload: Annotated[
        Key | None, Query(description="Key of an upload that is sent in parts, chosen by the sender.")
    ] = None,
    sha256: Annotated[Digest | None, Query(description="Digest of the whole log, to be checked.")] = None,
) -> Response:
    """Store the raw body of the request as a log of this visitor and queue it for reading.

    With ``upload``, a key of the sender's choice, and the header ``Content-Range: bytes FIRST-LAST/TOTAL`` it may come
    in parts, one after the other: after a cut, ``GET /api/logs/uploads/KEY`` tells where to go on. The answer to a
    part that is not the last is 200 with that place.
    """
    library: Library = request.app.state.library
    address = request.client.host if request.client is not None else ""
    part = None if upload is None else _part(upload, request.headers.get("content-range", ""))
    try:
        if part is None:
            declared = request.headers.get("content-length", "")
            size = int(declared) if declared.isascii() and declared.isdigit() else None
            record: Record | None = await library.put(
                request.state.visitor, name, request.stream(), size, sha256=sha256, address=address
            )
        else:
            record = await library.put_part(
                request.state.visitor, name, request.stream(), part, sha256=sha256, address=address
            )
    except ClientDisconnect:
        return Response(status_code=400)  # nobody is there to read it
    if record is None:
        assert part is not None  # noqa: S101 - for the type checker: without parts an upload is whole
        return JSONResponse({"offset": library.uploaded(request.state.visitor, part.key), "total": part.total})
    return JSONResponse(record.public(), status_code=202, headers={"Location": f"/api/logs/{record.id}"})


def _part(key: str, content_range: str) -> Part:
    found = _CONTENT_RANGE.fullmatch(content_range)
    if found is None:
        raise ReadError("upload.range", "A part of an upload needs the header Content-Range: bytes FIRST-LAST/TOTAL.")
    first, last, total = map(int, found.groups())
    if not first <= last < total:
        raise ReadError("upload.range", f"There is no part from byte {first} to byte {last} of {total}.")
    return Part(key, first, total)


@router.get("/uploads/{key}")
async def uploaded(request: Request, key: Key) -> dict[str, int]:
    """Return how many bytes of an upload have arrived: the next part starts there."""
    library: Library = request.app.state.library
    return {"offset": library.uploaded(request.state.visitor, key)}


@router.get("")
async def list_logs(request: Request) -> dict[str, Any]:
    """List the logs that this visitor may open: their uploads, the folder of the server, the sample."""
    library: Library = request.app.state.library
    return {"logs": [record.public() for record in await library.list(request.state.visitor)]}


@router.get("/{log_id}")
async def one(request: Request, log_id: str) -> dict[str, Any]:
    """Return the state of one log and, once it was read, its contents in figures."""
    library: Library = request.app.state.library
    return library.get(request.state.visitor, log_id).public()


@router.post("/{log_id}/cancel")
async def cancel(request: Request, log_id: str) -> dict[str, Any]:
    """Stop reading an uploaded log, which is kept and can be read again."""
    library: Library = request.app.state.library
    return (await library.cancel(request.state.visitor, log_id)).public()


@router.post("/{log_id}/read", status_code=202)
async def read_again(request: Request, log_id: str) -> dict[str, Any]:
    """Read an uploaded log again after reading it failed."""
    library: Library = request.app.state.library
    return library.read_again(request.state.visitor, log_id).public()


@router.delete("/{log_id}", status_code=204)
async def delete(request: Request, log_id: str) -> None:
    """Delete an uploaded log and its links. Sessions of guests on it end; other sessions go on."""
    library: Library = request.app.state.library
    await library.delete(request.state.visitor, log_id)
    for token in library.links.drop(log_id):
        await request.app.state.sessions.end_linked(token)
