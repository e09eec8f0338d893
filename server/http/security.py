"""Access checks: Host, Origin, the token, the visitor's cookie, security headers, and the size of bodies.

Plain ASGI, so that WebSockets are checked like requests and uploads are not buffered.
"""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import re
import secrets
import socket
from collections.abc import Sequence
from contextlib import suppress
from http.cookies import CookieError, SimpleCookie
from math import ceil
from urllib.parse import parse_qsl, urlencode

from fastapi.responses import HTMLResponse, RedirectResponse, Response
from starlette.datastructures import Headers, MutableHeaders
from starlette.routing import BaseRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.http.brake import Brake, Counts
from server.http.errors import error_response
from server.http.guests import GuestRight, right_of_request
from server.http.services import services_of
from server.http.sign_ins import SIGNED_IN_COOKIE, TOKEN_COOKIE, VALID_S, SignIns
from server.settings import Settings
from server.stream.close_codes import SIGNED_OUT
from server.workers.places import VISITOR_COOKIE

YEAR_S = 365 * 24 * 3600
MAX_BODY_BYTES = 64 * 1024  #: of a request that is not an upload
BODY_S = 30.0  #: seconds within which it must arrive
#: PUT routes here limit their bodies themselves as they arrive.
UPLOADS = re.compile(
    r"/api/logs|/api/(logs|sessions)/[^/]+/trajectories/[^/]+"
    r"|/api/sessions/[^/]+/(relations|localization/map-files)"
)

CSP = (
    "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; form-action 'self'; "
    "frame-ancestors 'self'"
)
HEADERS = {
    "Content-Security-Policy": CSP,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
}
ENTRANCE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Gridbloom: token</title></head>
<body><h1>Gridbloom needs its access token</h1>
<p>The token is part of the address that the service printed when it started.</p>
<form method="get"><label>Token <input type="password" name="token" autocomplete="current-password" required></label>
<button>Open</button></form></body></html>
"""

_VISITOR = re.compile(r"[A-Za-z0-9_-]{24}")
_NETLOC = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+)(:[0-9]{1,5})?")
_SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


class Security:
    """Middleware inside of :class:`server.http.errors.Ending`; all others are inside of it."""

    def __init__(
        self,
        app: ASGIApp,
        settings: Settings,
        routes: Sequence[BaseRoute],
        sign_ins: SignIns,
        wrong_tokens: Counts | None = None,
    ) -> None:
        self._app = app
        self._routes = routes
        self._hosts = frozenset(name.lower() for name in settings.allowed_hosts)
        self._loopback = settings.is_loopback
        self._own_name = "" if settings.is_loopback else socket.gethostname().lower()
        self._host = settings.host.strip("[]").lower()
        token = None if settings.token is None else settings.token.get_secret_value()
        self._token = token
        self._sign_ins = sign_ins
        #: Wrong tokens. Clients with the cookie are not affected.
        self._brake = Brake(burst=50, per_minute=30.0, counts=wrong_tokens)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check a request or a WebSocket, and forward it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        cookies = _cookies(headers)
        refusal = self._refusal(scope, headers, cookies)
        new_visitor = self._identify(scope, cookies)

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                out = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    out.setdefault(name, value)
                if new_visitor and not scope["path"].startswith("/assets/"):
                    out.append("Set-Cookie", _cookie(VISITOR_COOKIE, new_visitor, scope))
            await send(message)

        if refusal is not None:
            if scope["type"] == "websocket":
                await _refuse_socket(receive, send)
            else:
                await refusal(scope, receive, send_with_headers)
            return
        if scope["type"] == "http" and self._takes_small_body(scope):
            body = await _read_small(receive, headers)
            if isinstance(body, Response):
                await body(scope, receive, send_with_headers)
                return
            receive = _replay(body, receive)
        cookie = cookies.get(TOKEN_COOKIE, "")
        if scope["type"] == "websocket" and self._sign_ins.is_valid(cookie):
            await self._while_valid(cookie, scope, receive, send)
        else:
            await self._app(scope, receive, send_with_headers)

    async def _while_valid(self, cookie: str, scope: Scope, receive: Receive, send: Send) -> None:
        """Forward a WebSocket that was opened with a cookie; close it once the cookie is no longer valid."""
        with self._sign_ins.watching(cookie) as ended:
            forwarded = asyncio.ensure_future(self._app(scope, receive, send))
            ending = asyncio.ensure_future(ended.wait())
            try:
                await asyncio.wait((forwarded, ending), return_when=asyncio.FIRST_COMPLETED)
                if not forwarded.done():
                    forwarded.cancel()
                    with suppress(asyncio.CancelledError):
                        await forwarded
                    with suppress(OSError, RuntimeError):  # the browser has closed it in the meantime
                        await send({"type": "websocket.close", "code": SIGNED_OUT.code, "reason": "security.token"})
            finally:
                ending.cancel()
                forwarded.cancel()
            if not forwarded.cancelled():
                forwarded.result()

    # -- checks ----------------------------------------------------------------------------------------------------

    def _refusal(self, scope: Scope, headers: Headers, cookies: dict[str, str]) -> Response | None:
        """Return the answer that refuses the request, None if it is allowed."""
        host = headers.get("host", "")
        if not self._host_allowed(host):
            message = "This address is not one of the service's own; see the setting GRIDBLOOM_ALLOWED_HOSTS."
            return error_response(421, "security.host", message)
        unsafe = scope["type"] == "websocket" or scope["method"] not in _SAFE_METHODS
        if unsafe and not _same_origin(headers.getlist("origin"), host):
            return error_response(403, "security.origin", "Requests from pages of other sites are refused.")
        refusal = None if self._token is None else self._token_refusal(scope, headers, cookies)
        scope.setdefault("state", {})["is_signed_in"] = refusal is None
        return None if refusal is not None and refusal.status_code == 401 and self._guests_may(scope) else refusal

    def _host_allowed(self, host: str) -> bool:
        """Return whether the Host header names this service, which prevents DNS rebinding by pages of other sites."""
        match = _NETLOC.fullmatch(host)
        if match is None:
            return False
        name = match[1].strip("[]").lower()
        if "*" in self._hosts or name in self._hosts or name in ("localhost", self._host):
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return bool(self._own_name) and name in (self._own_name, f"{self._own_name}.local")
        return address.is_loopback or not self._loopback  # an address cannot be rebound

    def _token_refusal(self, scope: Scope, headers: Headers, cookies: dict[str, str]) -> Response | None:
        if self._sign_ins.is_valid(cookies.get(TOKEN_COOKIE, "")):
            return None
        kind, _, bearer = headers.get("authorization", "").partition(" ")
        query = parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)
        token = next((value for name, value in query if name == "token"), None)
        is_bearer = kind.lower() == "bearer"
        address = (scope.get("client") or ("",))[0]
        if is_bearer or token is not None:
            wait_s = self._brake.wait_s(address)
            if wait_s > 0.0:
                message = "Too many wrong tokens came from this network: try again later."
                return error_response(429, "security.guesses", message, headers={"Retry-After": str(ceil(wait_s))})
            if not (is_bearer and self._is_token(bearer.strip())) and not (token is not None and self._is_token(token)):
                self._brake.count(address)
        if is_bearer and self._is_token(bearer.strip()):
            return None
        if token is not None and self._is_token(token):
            if scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD"):
                return None
            # Move the token from the address into a cookie, because addresses are copied, shared and kept in histories.
            rest = urlencode([(name, value) for name, value in query if name != "token"])
            path = "/" + scope["path"].lstrip("/\\")
            response: Response = RedirectResponse(path + (f"?{rest}" if rest else ""), status_code=303)
            response.headers.append("Set-Cookie", _cookie(TOKEN_COOKIE, self._sign_ins.cookie(), scope, VALID_S))
            mark = _cookie(SIGNED_IN_COOKIE, "1", scope, VALID_S).replace("; HttpOnly", "")
            response.headers.append("Set-Cookie", mark)
            return response
        if "text/html" in headers.get("accept", ""):
            return HTMLResponse(ENTRANCE, status_code=401)
        message = "This service needs its access token: as ?token=…, or in the header Authorization: Bearer …"
        return error_response(401, "security.token", message, headers={"WWW-Authenticate": "Bearer"})

    def _is_token(self, token: str) -> bool:
        return self._token is not None and hmac.compare_digest(token.encode(), self._token.encode())

    def _guests_may(self, scope: Scope) -> bool:
        """Return whether the route may be called without the token."""
        right, parameters = right_of_request(self._routes, scope)
        if right is not GuestRight.LINKED_SESSION:
            return right is GuestRight.ALWAYS
        live = services_of(scope["app"]).sessions.all()
        return any(session.id == parameters["session_id"] and session.link is not None for session in live)

    # -- the visitor -----------------------------------------------------------------------------------------------

    def _identify(self, scope: Scope, cookies: dict[str, str]) -> str | None:
        """Store the visitor's id in the scope; if the visitor is new, return it for the cookie."""
        known = cookies.get(VISITOR_COOKIE, "")
        visitor = known if _VISITOR.fullmatch(known) else secrets.token_urlsafe(18)
        scope.setdefault("state", {})["visitor"] = visitor
        return None if visitor == known else visitor

    @staticmethod
    def _takes_small_body(scope: Scope) -> bool:
        return scope["method"] not in _SAFE_METHODS and not (
            scope["method"] == "PUT" and UPLOADS.fullmatch(scope["path"])
        )


def _same_origin(origins: list[str], host: str) -> bool:
    """Return whether the Origin is the service's own, or absent.

    Browsers send it with every WebSocket and unsafe request; other programs do not.
    """
    if not origins:
        return True
    if len(origins) > 1:
        return False
    scheme, _, netloc = origins[0].partition("://")  # an origin has no path
    if scheme not in ("http", "https"):
        return False
    default = ":443" if scheme == "https" else ":80"
    return netloc.lower().removesuffix(default) == host.lower().removesuffix(default)


def _cookies(headers: Headers) -> dict[str, str]:
    try:
        return {name: morsel.value for name, morsel in SimpleCookie("; ".join(headers.getlist("cookie"))).items()}
    except CookieError:
        return {}


def _cookie(name: str, value: str, scope: Scope, age_s: int = YEAR_S) -> str:
    secure = "; Secure" if scope["scheme"] in ("https", "wss") else ""
    return f"{name}={value}; Path=/; Max-Age={age_s}; HttpOnly; SameSite=Lax{secure}"


async def _refuse_socket(receive: Receive, send: Send) -> None:
    await receive()  # the connect event
    await send({"type": "websocket.close", "code": 1008, "reason": ""})


async def _read_small(receive: Receive, headers: Headers) -> Message | Response:
    """Return a request's body as one message, or the answer if it is too large or too slow."""
    declared = headers.get("content-length", "0")
    if declared.isascii() and declared.isdigit() and int(declared[:20]) > MAX_BODY_BYTES:
        return _cut(413, "request.too_large", f"A request has at most {MAX_BODY_BYTES} bytes.")
    body = bytearray()
    try:
        async with asyncio.timeout(BODY_S):
            while True:
                message = await receive()
                if message["type"] != "http.request":
                    return message
                body += message.get("body", b"")
                if len(body) > MAX_BODY_BYTES:
                    return _cut(413, "request.too_large", f"A request has at most {MAX_BODY_BYTES} bytes.")
                if not message.get("more_body", False):
                    return {"type": "http.request", "body": bytes(body), "more_body": False}
    except TimeoutError:
        return _cut(408, "request.stalled", f"The request was incomplete after {BODY_S:g} s.")


def _cut(status: int, code: str, message: str) -> Response:
    """Return an error answer that closes the connection, so that the rest of the request is not read."""
    return error_response(status, code, message, headers={"Connection": "close"})


def _replay(body: Message, receive: Receive) -> Receive:
    waiting = [body]

    async def replayed() -> Message:
        return waiting.pop() if waiting else await receive()

    return replayed
