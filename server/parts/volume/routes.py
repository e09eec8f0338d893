"""``/api/sessions/{id}/volume.*``, ``surface.*``, ``depth.png``: files of a session's 3D map, and its camera."""

from __future__ import annotations

import asyncio
import io
from collections.abc import Callable
from typing import Literal

import numpy as np
from fastapi import APIRouter, Request
from fastapi.responses import Response

from mapper.core.array_types import Float32Array
from mapper.core.errors import MapperError
from mapper.io.maps import yaml_text
from mapper.io.maps.images import pgm_pieces
from mapper.io.maps.pixels import trinary_pixels
from server.downloads import Content, Download, file_name
from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.routes.maps import compressed_image, requester_of, stem_of
from server.http.services import FileDownloads, Sessions
from server.sessions.parts import DepthSensing, Volumetric

DARKEST = 40  #: grey value at the camera's longest range; 0 means no return


def depth_png(depths: Float32Array, reach: float) -> bytes:
    """Return ``depths`` (rows, cols), metres, 0 for none, as PNG: the nearer the lighter, up to ``reach`` metres."""
    from PIL import Image  # noqa: PLC0415 - start-up

    near = 1.0 - np.clip(depths / reach, 0.0, 1.0)
    grey = np.where(depths > 0.0, DARKEST + (255 - DARKEST) * near, 0.0)
    file = io.BytesIO()
    Image.fromarray(np.round(grey).astype(np.uint8)).save(file, "PNG")
    return file.getvalue()


MEDIA = {"pgm": "image/x-portable-graymap", "yaml": "application/yaml"}
router = APIRouter(prefix="/api/sessions", tags=["sessions"])


@router.get("/{session_id}/volume.{kind}", **file_answer("application/octet-stream"))
@guests_may(GuestRight.LINKED_SESSION)
async def volume_file(
    request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str, kind: Literal["bt", "ot"]
) -> Response:
    """Return the 3D map as an octree of OctoMap: .bt has free and occupied voxels, .ot their log-odds."""
    return _download(request, sessions, downloads, session_id, kind, lambda volume: volume.octree_bytes(f".{kind}"))


@router.get("/{session_id}/surface.{kind}", **file_answer("application/octet-stream"))
@guests_may(GuestRight.LINKED_SESSION)
async def surface_file(
    request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str, kind: Literal["ply", "glb"]
) -> Response:
    """Return the surface from truncated signed distances as triangles with normals: PLY, or glTF in one file.

    If a simulation shows its occupied voxels, it is their outside.
    """
    return _download(request, sessions, downloads, session_id, kind, lambda volume: volume.mesh_bytes(f".{kind}"))


@router.get("/{session_id}/selection.ply", **file_answer("application/octet-stream"))
@guests_may(GuestRight.LINKED_SESSION)
async def selection_file(request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str) -> Response:
    """Return the points within the clip box, with their values, as PLY; for an octree, its occupied voxels."""
    return _download(request, sessions, downloads, session_id, "ply", lambda volume: volume.selection_bytes())


@router.get("/{session_id}/above.{kind}", **file_answer("application/yaml", "image/x-portable-graymap"))
@guests_may(GuestRight.LINKED_SESSION)
async def above_file(
    request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str, kind: Literal["pgm", "yaml"]
) -> Response:
    """Return the 3D map's band of heights, seen from above, for map_server: the image, or its YAML file."""
    session = sessions.get(session_id)

    async def make() -> Content:
        async with session.settled():
            volume = session.model.find(Volumetric)
            grid = None if volume is None else volume.above
            if grid is None:
                raise MapperError("session.no_volume", "This session has no map in 3D that is known at these heights.")
            stem = f"{stem_of(session)}-above"
            if kind == "yaml":
                text = yaml_text(grid.geometry, file_name(stem, "pgm"), frame=session.model.frame_id).encode()
                return Content(file_name(stem, kind), iter([text]), len(text))
            image = await compressed_image(downloads, lambda: (grid.geometry.shape, trinary_pixels(grid)))
        return Content(file_name(stem, kind), pgm_pieces(image.shape, image.bands()))

    return Download(downloads, requester_of(request, session), make, MEDIA[kind])


@router.get("/{session_id}/depth.png", **file_answer("image/png"))
@guests_may(GuestRight.LINKED_SESSION)
async def depth_picture(sessions: Sessions, session_id: str) -> Response:
    """Return the newest image of the simulated depth camera: the nearer the lighter, black for no return."""
    session = sessions.get(session_id)
    seen = session.model.find(DepthSensing)
    depths = None if seen is None else seen.newest_depths()
    if depths is None:
        raise MapperError("session.no_depth", "The robot of this session has no depth camera, or no image of it yet.")
    data = await asyncio.to_thread(depth_png, *depths)
    return Response(data, media_type="image/png", headers={"Cache-Control": "private, no-store"})


def _download(
    request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str, kind: str,
    read: Callable[[Volumetric], bytes],
) -> Response:  # fmt: skip
    session = sessions.get(session_id)

    async def make() -> Content:
        async with session.settled():
            volume = session.model.find(Volumetric)
            if volume is None:
                raise MapperError("session.no_volume", "This session shows no map in 3D to download.")
            data = await downloads.run(lambda _: read(volume))
        return Content(file_name(stem_of(session), kind), iter([data]), len(data))

    return Download(downloads, requester_of(request, session), make, "application/octet-stream")
