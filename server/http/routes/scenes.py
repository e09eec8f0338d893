"""``/scenes/{session id}/``: the 3D view of a session, its page and its socket."""

from __future__ import annotations

from fastapi import APIRouter, Request, WebSocket
from fastapi.responses import RedirectResponse, Response

from server.http.services import OpenScenes, Sessions

router = APIRouter(prefix="/scenes", include_in_schema=False)


@router.get("/{session_id}")
async def without_slash(sessions: Sessions, session_id: str) -> Response:
    """Redirect to the page's address, from which the address of its WebSocket is derived."""
    sessions.get(session_id)
    return RedirectResponse(f"/scenes/{session_id}/", status_code=308)


@router.api_route("/{session_id}/", methods=["GET", "HEAD"])
async def page(request: Request, sessions: Sessions, session_id: str) -> Response:
    """Return viser's client. The scene is created when the page opens its WebSocket."""
    from server.scenes.proxy import client_page, page_headers  # noqa: PLC0415 - imported with the first 3D view

    sessions.get(session_id)
    client = client_page()
    headers = page_headers(request.headers.get("host", "")) | {"ETag": client.etag}
    if client.etag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    if "gzip" in request.headers.get("accept-encoding", ""):
        return Response(client.compressed, media_type="text/html", headers=headers | {"Content-Encoding": "gzip"})
    return Response(client.plain, media_type="text/html", headers=headers)


@router.websocket("/{session_id}")
@router.websocket("/{session_id}/")
async def socket(websocket: WebSocket, sessions: Sessions, scenes: OpenScenes, session_id: str) -> None:
    """Forward the page's WebSocket to the session's scene."""
    from server.scenes.proxy import pass_on  # noqa: PLC0415 - imported with the first 3D view

    session = sessions.get(session_id)
    scene = await scenes.get(session)
    scene.enter()
    try:
        await pass_on(websocket, scene.path)
    finally:
        scene.leave()
