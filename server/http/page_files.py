"""The built pages as files: static/dist in a checkout, server/pages in an installed wheel."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from html import escape
from pathlib import Path

from fastapi import Request
from fastapi.responses import FileResponse, Response
from starlette.exceptions import HTTPException

from mapper.core.errors import MapperError

_HERE = Path(__file__).resolve().parents[1]
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


def built_file(request: Request, relative: str, cache: str) -> Response:
    """Return a built file; ``cache`` is its Cache-Control. Raises HTTPException 404."""
    root = find_pages()
    if root is None or "\0" in relative:
        raise HTTPException(404)
    try:
        path = (root / relative).resolve()
        # resolve() first, so that neither ".." nor a symbolic link leads out of the folder.
        exists = path.is_relative_to(root.resolve()) and path.suffix in TYPES and path.is_file()
    except (OSError, RuntimeError):  # the name is too long, or there is a loop of symbolic links
        exists = False
    if not exists:
        raise HTTPException(404)
    headers = {"Cache-Control": cache}
    response = FileResponse(path, media_type=TYPES[path.suffix], headers=headers, stat_result=path.stat())
    if response.headers["etag"] in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers | {"ETag": response.headers["etag"]})
    return response


def front_page(request: Request) -> Response:
    """Return the front page, with an absolute address of its preview, as programs that display links require.

    Raises HTTPException 404 if the pages are not built.
    """
    root = find_pages()
    if root is None:
        raise HTTPException(404)
    relative = 'property="og:image" content="'
    page = (root / "index.html").read_text()
    body = page.replace(f"{relative}/", f"{relative}{escape(str(request.base_url))}").encode()
    headers = {"Cache-Control": "no-cache", "ETag": f'"{sha256(body).hexdigest()[:32]}"'}
    if headers["ETag"] in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    return Response(body, media_type=TYPES[".html"], headers=headers)


def page_file(request: Request, name: str) -> Response:
    """Return a page, or another file in the folder of pages."""
    return built_file(request, name, "no-cache")


def page_of_secret(request: Request, name: str, find: Callable[[], object], gone: type[MapperError]) -> Response:
    """Return the page of an address with a secret, with status 404 if ``find`` raises ``gone``."""
    response = page_file(request, name)
    response.headers["X-Robots-Tag"] = "noindex"
    try:
        find()
    except gone:
        if response.status_code == 200:
            response.status_code = 404
    return response


def page_names() -> set[str]:
    """Return the names of the built pages, without ``.html``."""
    root = find_pages()
    return set() if root is None else {page.stem for page in root.glob("*.html")}


def missing_page(request: Request) -> Response | None:
    """Return the page that reports a missing page, status 404; None for a client that does not request a page."""
    if request.method not in ("GET", "HEAD") or "text/html" not in request.headers.get("accept", ""):
        return None
    root = find_pages()
    if root is None or not (root / "missing.html").is_file():
        return None
    return FileResponse(root / "missing.html", 404, {"Cache-Control": "no-cache"}, TYPES[".html"])
