"""The pages and their assets, as Vite built them: static/dist in a checkout, server/pages in an installed wheel."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse, HTMLResponse, RedirectResponse, Response
from starlette.exceptions import HTTPException

from server.http.guests import GuestRight, guests_may
from server.http.services import Sessions

router = APIRouter(include_in_schema=False)

_HERE = Path(__file__).resolve().parents[2]
PLACES = (_HERE / "pages", _HERE.parent / "static" / "dist")
TYPES = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".ico": "image/x-icon",
    ".jpg": "image/jpeg",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".map": "application/json",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
    ".webmanifest": "application/manifest+json",
    ".webp": "image/webp",
    ".woff2": "font/woff2",
}
NOT_BUILT = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Gridbloom</title></head>
<body><h1>Gridbloom runs, but its pages are not built.</h1>
<p>Run <code>make setup</code> in the checkout and load this page again. The interface for programs is described at
<a href="/api/docs">/api/docs</a>.</p></body></html>
"""


def find_pages() -> Path | None:
    """Return the folder of the built pages, None if there is none."""
    return next((place for place in PLACES if (place / "index.html").is_file()), None)


def _file(request: Request, relative: str, cache: str) -> Response:
    root = find_pages()
    if root is None or "\0" in relative:
        raise HTTPException(404)
    try:
        path = (root / relative).resolve()
        # resolve() first, so that neither ".." nor a symbolic link leads out of the folder.
        found = path.is_relative_to(root.resolve()) and path.suffix in TYPES and path.is_file()
    except (OSError, RuntimeError):  # a name that is too long, a loop of symbolic links
        found = False
    if not found:
        raise HTTPException(404)
    headers = {"Cache-Control": cache}
    response = FileResponse(path, media_type=TYPES[path.suffix], headers=headers, stat_result=path.stat())
    if response.headers["etag"] in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers | {"ETag": response.headers["etag"]})
    return response


def page_file(request: Request, name: str) -> Response:
    """Return a page, or a file beside the pages."""
    return _file(request, name, "no-cache")


@router.api_route("/", methods=["GET", "HEAD"])
async def index(request: Request) -> Response:
    """Return the front page."""
    if find_pages() is None:
        return HTMLResponse(NOT_BUILT, status_code=503)
    return _file(request, "index.html", "no-cache")


@router.api_route("/assets/{name:path}", methods=["GET", "HEAD"])
@guests_may(GuestRight.ALWAYS)
async def asset(request: Request, name: str) -> Response:
    """Return a file whose name contains a digest of its content, which never changes."""
    return _file(request, f"assets/{name}", "public, max-age=31536000, immutable")


@router.get("/3d")
async def three_d(sessions: Sessions, session: str) -> Response:
    """Redirect to the 3D view of a session, without viser's panel: the controls are in the page of the session."""
    found = sessions.get(session)
    return RedirectResponse(f"/scenes/{found.id}/plain/", status_code=307)


@router.api_route("/{name}", methods=["GET", "HEAD"])
async def page(request: Request, name: str) -> Response:
    """Return a page, or a file beside the pages."""
    return page_file(request, name)
