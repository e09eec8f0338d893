"""``/scenes/{session id}/``: the 3D view of a session, its page and its socket."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Path, Request, WebSocket
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from pydantic import BaseModel, Field, FiniteFloat

from server.http.guests import GuestRight, guests_may
from server.http.page_files import NOT_BUILT, find_pages
from server.http.services import OpenScenes, Sessions, Visitor
from server.imports import imported
from server.scenes.visitors import Viewer
from server.stream.message_parts import CameraName, RobotCameraName
from server.stream.protocol import PAGE_NAME

if TYPE_CHECKING:
    from server.scenes import Scenes
    from server.scenes.scene import Scene
    from server.sessions import SessionHost

router = APIRouter(prefix="/scenes", tags=["scenes"])


@router.get("/{session_id}", include_in_schema=False)
async def without_slash(sessions: Sessions, session_id: str) -> Response:
    """Redirect to the page's address, from which the address of its WebSocket is derived."""
    sessions.get(session_id)
    return RedirectResponse(f"/scenes/{session_id}/", status_code=308)


@router.api_route("/{session_id}/", methods=["GET", "HEAD"], include_in_schema=False)
async def page(request: Request, sessions: Sessions, session_id: str) -> Response:
    """Return viser's client. The scene is created when the page opens its WebSocket."""
    sessions.get(session_id)
    return await _client(request, plain_view=False)


@router.api_route("/{session_id}/plain/", methods=["GET", "HEAD"], include_in_schema=False)
@router.api_route("/{session_id}/plain/{_page}/", methods=["GET", "HEAD"], include_in_schema=False)
@guests_may(GuestRight.LINKED_SESSION)
async def plain_page(request: Request, sessions: Sessions, session_id: str) -> Response:
    """Return viser's client without its panel, for a page that has its own controls and may have a name."""
    sessions.get(session_id)
    return await _client(request, plain_view=True)


async def _client(request: Request, *, plain_view: bool) -> Response:
    await imported("server.scenes.proxy")
    from server.scenes.proxy import client_page, page_headers  # noqa: PLC0415 - imported with the first 3D view

    root = find_pages()
    if root is None:
        return HTMLResponse(NOT_BUILT, status_code=503)
    script = (root / "scene.js").read_bytes()
    client = await asyncio.to_thread(client_page, script, plain_view=plain_view)  # compressed on first use
    headers = page_headers(request.headers.get("host", "")) | {"ETag": client.etag}
    if client.etag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    if "gzip" in request.headers.get("accept-encoding", ""):
        return Response(client.compressed, media_type="text/html", headers=headers | {"Content-Encoding": "gzip"})
    return Response(client.plain, media_type="text/html", headers=headers)


class SceneSettings(BaseModel, extra="forbid"):
    """Changes of a 3D view: camera, height of the columns, visible layers."""

    camera: CameraName | RobotCameraName | None = None
    height: FiniteFloat | None = Field(None, ge=0.1, le=10.0)
    layers: dict[str, bool] = Field(default_factory=dict, max_length=100)


@dataclass(frozen=True, slots=True)
class SceneAnswer:
    """A 3D view: cameras, visibility of layers, height of the columns, metres between the lines of the grid.

    ``camera`` is the visitor's last choice; None if there is none yet.
    """

    cameras: list[CameraName | RobotCameraName]
    camera: CameraName | RobotCameraName | None
    layers: dict[str, bool]
    height: float
    grid: float


@router.get("/{session_id}/settings")
@guests_may(GuestRight.LINKED_SESSION)
async def settings(sessions: Sessions, scenes: OpenScenes, visitor: Visitor, session_id: str) -> SceneAnswer:
    """Return the cameras, the layers with their visibility, and the height of the columns."""
    return _settings(await scenes.get(sessions.get(session_id)), visitor)


@router.post("/{session_id}/settings")
@guests_may(GuestRight.LINKED_SESSION)
async def change(
    sessions: Sessions, scenes: OpenScenes, visitor: Visitor, session_id: str, body: SceneSettings
) -> SceneAnswer:
    """Move the cameras of this visitor's views; set height and layers for all views of the session."""
    scene = await scenes.get(sessions.get(session_id))
    if body.camera is not None:
        scene.aim(visitor, body.camera)
    if body.height is not None:
        await scene.set_height(body.height)
    for label, visible in body.layers.items():
        scene.set_layer(label, visible=visible)
    return _settings(scene, visitor)


def _settings(scene: Scene, visitor: str) -> SceneAnswer:
    return SceneAnswer(scene.cameras, scene.chosen(visitor), scene.layers, scene.height, scene.grid_spacing)


@router.websocket("/{session_id}")
@router.websocket("/{session_id}/")
@router.websocket("/{session_id}/plain")
@router.websocket("/{session_id}/plain/")
async def socket(
    websocket: WebSocket, sessions: Sessions, scenes: OpenScenes, visitor: Visitor, session_id: str
) -> None:
    """Forward the WebSocket of a view to the session's scene."""
    await _forward(websocket, sessions.get(session_id), scenes, Viewer(visitor))


@router.websocket("/{session_id}/plain/{page}")
@router.websocket("/{session_id}/plain/{page}/")
@guests_may(GuestRight.LINKED_SESSION)
async def socket_in_page(
    websocket: WebSocket,
    sessions: Sessions,
    scenes: OpenScenes,
    visitor: Visitor,
    session_id: str,
    page: Annotated[str, Path(pattern=PAGE_NAME)],
) -> None:
    """Forward the WebSocket of a view that belongs to a page, which receives the answers to its clicks."""
    await _forward(websocket, sessions.get(session_id), scenes, Viewer(visitor, page))


async def _forward(websocket: WebSocket, session: SessionHost, scenes: Scenes, viewer: Viewer) -> None:
    await imported("server.scenes.proxy")
    from server.scenes.proxy import pass_on, take  # noqa: PLC0415 - imported with the first 3D view

    if not await take(websocket):
        return
    scene = await scenes.get(session)
    scene.enter()
    try:
        await pass_on(websocket, scene.path, viewer)
    finally:
        scene.leave()
