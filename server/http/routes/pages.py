"""The pages and their assets."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, RedirectResponse, Response

from server.http.guests import GuestRight, guests_may
from server.http.page_files import NOT_BUILT, built_file, find_pages, front_page, page_file, page_names

router = APIRouter(include_in_schema=False)


@router.api_route("/", methods=["GET", "HEAD"])
async def index(request: Request) -> Response:
    """Return the front page."""
    if find_pages() is None:
        return HTMLResponse(NOT_BUILT, status_code=503)
    return front_page(request)


@router.api_route("/assets/{name:path}", methods=["GET", "HEAD"])
@guests_may(GuestRight.ALWAYS)
async def asset(request: Request, name: str) -> Response:
    """Return a file whose name contains a digest of its content, which never changes."""
    return built_file(request, f"assets/{name}", "public, max-age=31536000, immutable")


@router.api_route("/{name}", methods=["GET", "HEAD"])
async def page(request: Request, name: str) -> Response:
    """Return a page, or another file in the folder of pages. A page's name without ``.html`` redirects to the page."""
    if name in page_names():
        query = f"?{request.url.query}" if request.url.query else ""
        return RedirectResponse(f"/{name}.html{query}", status_code=307)
    return page_file(request, name)
