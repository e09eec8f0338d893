"""``/api/logs``: upload, list, read again and delete logs."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import JSONResponse, Response
from pydantic import BaseModel, Field, StringConstraints
from starlette.requests import ClientDisconnect

from mapper.core.errors import ReadError
from server.http.clients import client_address, in_turn
from server.http.file_answer import FILE_BODY, file_answer
from server.http.services import Logs, RequestWork, Sessions, Visitor
from server.library.annotations.tags import MAX_TAGS
from server.library.logs.examples import FILES, ExampleName, example_bytes
from server.library.logs.listing import LogQuery, Order, listed
from server.library.logs.records import LogAnswer, Record
from server.library.uploads.receiver import Part

router = APIRouter(prefix="/api/logs", tags=["logs"])


Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_-]{16,64}$")]
Digest = Annotated[str, StringConstraints(pattern=r"^[0-9A-Fa-f]{64}$")]
_CONTENT_RANGE = re.compile(r"bytes ([0-9]{1,15})-([0-9]{1,15})/([0-9]{1,15})")


@dataclass(frozen=True, slots=True)
class UploadOffset:
    """The number of received bytes of an upload, where the next part starts; ``total`` is known with the first part."""

    offset: int
    total: int | None = None


@dataclass(frozen=True, slots=True)
class LogList:
    """The logs on one page of a list, the number of matching logs, and the visitor's tags with numbers of logs."""

    logs: list[LogAnswer]
    total: int
    tags: dict[str, int]


@router.put("", status_code=202, response_model=LogAnswer, openapi_extra=FILE_BODY)
async def upload(
    request: Request,
    response: Response,
    library: Logs,
    visitor: Visitor,
    name: Annotated[str, Query(max_length=1000)] = "log",
    upload: Annotated[
        Key | None, Query(description="Key of an upload that is sent in parts, chosen by the sender.")
    ] = None,
    sha256: Annotated[Digest | None, Query(description="Digest of the whole log, which is checked.")] = None,
) -> LogAnswer | Response:
    """Store the raw body of the request as a log of this visitor and queue it for reading.

    With ``upload``, a key that the sender chooses, and the header ``Content-Range: bytes FIRST-LAST/TOTAL`` the body is
    one part of the log. Parts are sent in order; after a broken connection ``GET /api/logs/uploads/KEY`` returns the
    offset to resume from. The answer to a part other than the last is 200 with that offset.
    """
    address = client_address(request)
    part = None if upload is None else _part(upload, request.headers.get("content-range", ""))
    try:
        if part is None:
            declared = request.headers.get("content-length", "")
            size = int(declared) if declared.isascii() and declared.isdigit() else None
            record: Record | None = await library.put(
                visitor, name, request.stream(), size, sha256=sha256, address=address
            )
        else:
            record = await library.put_part(visitor, name, request.stream(), part, sha256=sha256, address=address)
    except ClientDisconnect:
        return Response(status_code=400)  # the client has disconnected
    if record is None:
        assert part is not None  # noqa: S101 - for the type checker: without parts an upload is whole
        return JSONResponse({"offset": library.uploaded(visitor, part.key), "total": part.total})
    response.headers["Location"] = f"/api/logs/{record.id}"
    return record.public()


def _part(key: str, content_range: str) -> Part:
    match = _CONTENT_RANGE.fullmatch(content_range)
    if match is None:
        raise ReadError("upload.range", "A part of an upload needs the header Content-Range: bytes FIRST-LAST/TOTAL.")
    first, last, total = map(int, match.groups())
    if not first <= last < total:
        raise ReadError("upload.range", f"There is no part from byte {first} to byte {last} of {total}.")
    return Part(key, first, total)


@router.post("/examples/{name}", status_code=202)
async def example(request: Request, library: Logs, visitor: Visitor, work: RequestWork, name: ExampleName) -> LogAnswer:
    """Generate an example log in the simulator and queue it for reading, as an upload of this visitor.

    "drift" has drifting poses that SLAM can correct, "mount" a lidar with a rotated mount, "camera" images and the
    clouds of a 3D lidar.
    """
    data = await in_turn(request, work, visitor, lambda: example_bytes(name))

    async def pieces() -> AsyncIterator[bytes]:
        yield data

    return (await library.put(visitor, FILES[name], pieces(), len(data), address=client_address(request))).public()


@router.get("/uploads/{key}", response_model_exclude_none=True)
async def uploaded(library: Logs, visitor: Visitor, key: Key) -> UploadOffset:
    """Return the number of received bytes of an upload, where the next part starts."""
    return UploadOffset(library.uploaded(visitor, key))


@router.delete("/uploads/{key}", status_code=204)
async def forget_upload(library: Logs, visitor: Visitor, key: Key) -> None:
    """Cancel an upload of this visitor, and delete what has arrived."""
    library.forget_upload(visitor, key)


@router.get("")
async def list_logs(
    library: Logs,
    visitor: Visitor,
    q: Annotated[str, Query(max_length=200, description="Words of the name, the format, a topic or a tag.")] = "",
    tag: Annotated[list[str] | None, Query(max_length=MAX_TAGS, description="Tags that the logs have.")] = None,
    order: Order = "newest",
    offset: Annotated[int, Query(ge=0, le=1_000_000)] = 0,
    limit: Annotated[int | None, Query(ge=1, le=500, description="Most logs of the answer.")] = None,
) -> LogList:
    """List the logs that this visitor may open: their uploads, newest first, the folder of the server, the sample.

    ``total`` is the number of matching logs; ``tags`` are this visitor's, with the number of logs of each.
    """
    selection = LogQuery(q, tuple(tag or ()), order, offset, limit)
    listing = listed(await library.list(visitor), selection)
    return LogList([record.public() for record in listing.records], listing.total, dict(listing.tags))


@router.get("/{log_id}")
async def one(library: Logs, visitor: Visitor, log_id: str) -> LogAnswer:
    """Return the state of one log and, once it has been read, a summary of its contents."""
    return library.get(visitor, log_id).public()


@router.get("/{log_id}/map.png", **file_answer("image/png"))
async def picture(library: Logs, visitor: Visitor, log_id: str, *, dark: bool = False) -> Response:
    """Return a small picture of a log's map with the path of the robot, drawn when the log was read."""
    return Response(
        await library.map_picture(visitor, log_id, dark=dark),
        media_type="image/png",
        headers={"Cache-Control": "private, max-age=300"},
    )


class TagsOfLog(BaseModel, extra="forbid"):
    """The tags of a log."""

    tags: Annotated[list[str], Field(max_length=MAX_TAGS)]


@router.put("/{log_id}/tags")
async def put_tags(library: Logs, visitor: Visitor, log_id: str, body: TagsOfLog) -> LogAnswer:
    """Replace the tags that this visitor has given a log."""
    await library.tags.put(visitor, library.get(visitor, log_id), body.tags)
    return library.get(visitor, log_id).public()


@router.post("/{log_id}/cancel")
async def cancel(library: Logs, visitor: Visitor, log_id: str) -> LogAnswer:
    """Stop reading an uploaded log. It is kept and can be read again."""
    return (await library.cancel(visitor, log_id)).public()


@router.post("/{log_id}/read", status_code=202)
async def read_again(library: Logs, visitor: Visitor, log_id: str) -> LogAnswer:
    """Read an uploaded log again after a failure."""
    return library.read_again(visitor, log_id).public()


@router.delete("/{log_id}", status_code=204)
async def delete(library: Logs, sessions: Sessions, visitor: Visitor, log_id: str) -> None:
    """Delete an uploaded log and its links. Sessions of guests on it end; other sessions continue."""
    await library.delete(visitor, log_id)
    for token in library.links.drop(log_id):
        await sessions.end_linked(token)
