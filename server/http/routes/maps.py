"""``/api/sessions/{id}/map.*``: the map of a session as files."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from mapper.core.errors import MapperError
from mapper.grid import OccupancyGrid
from mapper.io.maps import yaml_text
from mapper.io.maps.images import Bands, pgm_header, pgm_pieces, png_pieces
from mapper.io.maps.pixels import PROBABILITY_PALETTE, probability_pixels, trinary_pixels
from server.downloads import (
    SNAPSHOT_NAME,
    CompressedImage,
    Content,
    Download,
    Downloads,
    MapSnapshot,
    MapSnapshotGoneError,
    file_name,
    file_stem,
)
from server.downloads.download_slots import Requester, requester
from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.services import FileDownloads, Sessions

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

At = Annotated[
    str | None,
    Query(
        pattern=SNAPSHOT_NAME,
        description="Name of a snapshot: map.yaml and map.pgm requested with the same name are of one map, that of the "
        "first request, and their file names end in the name. A session keeps four snapshots.",
    ),
]


def stem_of(session: SessionHost) -> str:
    """Return the stem of a session's file names: the name of its log or of its world."""
    return file_stem(session.model.file_stem)


def grid_of(session: SessionHost) -> OccupancyGrid:
    """Return the map of a session. Raises :class:`MapperError` if it has none for download."""
    if session.model.grid is None:
        raise MapperError("session.no_map", "This session shows no occupancy grid map to download.")
    return session.model.grid


def requester_of(request: Request, session: SessionHost) -> Requester:
    """Return the requester of a session's file."""
    return requester(request.state.visitor, request.client and request.client.host, session.link)


async def compressed_image(
    downloads: Downloads, pixels: Callable[[], tuple[tuple[int, int], Bands]]
) -> CompressedImage:
    """Return the image that ``pixels`` returns: its shape (rows, cols) and its bands. The session must be locked."""

    def work(check: Callable[[], None]) -> CompressedImage:
        shape, bands = pixels()
        return CompressedImage(shape, bands, downloads.folder, check)

    return await downloads.run(work)


async def _map_snapshot(downloads: Downloads, session: SessionHost, at: str | None) -> MapSnapshot:
    """Return the current map of a session, or its snapshot ``at``, with its trinary image."""

    async def make() -> MapSnapshot:
        async with session.settled():
            grid, stem, frame = grid_of(session), stem_of(session), session.model.frame_id
            offset = session.model.offset
            image = await compressed_image(downloads, lambda: (grid.geometry.shape, trinary_pixels(grid)))
        return MapSnapshot(stem, grid.geometry, image, frame, offset)

    return await make() if at is None else await downloads.map_snapshots.get(session, at, make)


@router.get("/{session_id}/map.yaml", **file_answer("application/yaml"))
@guests_may(GuestRight.LINKED_SESSION)
async def map_yaml(
    request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str, at: At = None
) -> Response:
    """Return the YAML file for map_server, which names map.pgm as its image."""
    session = sessions.get(session_id)

    async def make() -> Content:
        if at is None:
            stem, geometry, frame = stem_of(session), grid_of(session).geometry, session.model.frame_id
            offset = session.model.offset
        else:
            snapshot = await _map_snapshot(downloads, session, at)
            stem, geometry, frame, offset = snapshot.stem, snapshot.geometry, snapshot.frame, snapshot.offset
        text = yaml_text(geometry, file_name(stem, "pgm", at), frame=frame, offset=offset).encode()
        return Content(file_name(stem, "yaml", at), iter([text]), len(text))

    return Download(downloads, requester_of(request, session), make, "application/yaml")


@router.get("/{session_id}/map.pgm", **file_answer("image/x-portable-graymap"))
@guests_may(GuestRight.LINKED_SESSION)
async def map_pgm(
    request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str, at: At = None
) -> Response:
    """Return the map as a PGM image for map_server."""
    session = sessions.get(session_id)

    async def make() -> Content:
        snapshot = await _map_snapshot(downloads, session, at)
        if snapshot.image is None:
            raise MapSnapshotGoneError(
                "map.snapshot_gone",
                f"The snapshot {at!r} of the map is no longer kept: request map.pgm and map.yaml with another name.",
            )
        shape = snapshot.image.shape
        nbytes = len(pgm_header(shape)) + shape[0] * shape[1]
        return Content(file_name(snapshot.stem, "pgm", at), pgm_pieces(shape, snapshot.image.bands()), nbytes)

    return Download(downloads, requester_of(request, session), make, "image/x-portable-graymap")


@router.get("/{session_id}/map.png", **file_answer("image/png"))
@guests_may(GuestRight.LINKED_SESSION)
async def map_png(request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str) -> Response:
    """Return the map as a PNG image of probabilities."""
    session = sessions.get(session_id)

    async def make() -> Content:
        async with session.settled():
            grid = grid_of(session)
            image = await compressed_image(downloads, lambda: (grid.geometry.shape, probability_pixels(grid)))
        return Content(file_name(stem_of(session), "png"), png_pieces(image.shape, image.bands(), PROBABILITY_PALETTE))

    return Download(downloads, requester_of(request, session), make, "image/png")
