"""``/sign-out``: end the cookie of this browser, or all cookies by which browsers prove the token."""

from __future__ import annotations

import asyncio
from urllib.parse import parse_qs

import structlog
from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, RedirectResponse, Response

from server.http.errors import error_response
from server.http.services import services_of
from server.http.sign_ins import SIGNED_IN_COOKIE, TOKEN_COOKIE
from server.storage import StorageError

router = APIRouter(include_in_schema=False)

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Gridbloom: sign out</title></head>
<body><h1>Sign out</h1>
<p>This browser, or all browsers, must give the token again afterwards. Their open maps and classes are
disconnected.</p>
<form method="post"><button>Sign out here</button>
<button name="everywhere" value="1">Sign out everywhere</button></form>
<p><a href="/">Back</a></p></body></html>
"""

_log = structlog.get_logger(__name__)


@router.get("/sign-out")
async def page() -> Response:
    """Return the page that asks where to sign out."""
    return HTMLResponse(PAGE)


@router.post("/sign-out")
async def sign_out(request: Request) -> Response:
    """End the cookie of this browser, or with ``everywhere`` all of them."""
    everywhere = "everywhere" in parse_qs((await request.body()).decode("latin-1"))
    services = services_of(request.app)
    sign_ins = services.sign_ins
    response: Response = RedirectResponse("/", status_code=303)
    try:
        if everywhere:
            await asyncio.to_thread(sign_ins.end_all)
        else:
            await asyncio.to_thread(sign_ins.end, request.cookies.get(TOKEN_COOKIE, ""))
        await services.library.sign_in_ends.put(sign_ins.ended)
    except (OSError, StorageError) as error:
        _log.warning("an ended sign-in cannot be recorded", reason=str(error))
        message = "You are signed out until the service is started again: it cannot record it."
        response = error_response(507, "security.not_recorded", message)
    response.delete_cookie(TOKEN_COOKIE, httponly=True, samesite="lax")
    response.delete_cookie(SIGNED_IN_COOKIE, samesite="lax")
    return response
