"""Proxy between a browser and a scene's viser server: the page, and the WebSocket in both directions.

viser's client is one page without further files, so it is served from the installed package, compressed once. Only the
WebSocket is forwarded; viser's HTTP server, which reads files, is not reachable from outside. Only those of the
browser's messages that :func:`server.scenes.browser_messages.passes` accepts are forwarded, and viser's messages only
as fast as the browser draws them: a browser that draws slowly is sent the newest state instead of every state.

viser's client accepts messages as fast as they come, and processes them frame by frame; in a hidden tab it draws no
frames. A script in its page (:data:`SCRIPT`) reports each processed message. While a few messages are not reported, the
proxy reads no further ones from viser, whose buffer meanwhile drops messages that newer ones replace.
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

import structlog
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import ClientConnection, unix_connect
from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.typing import Subprotocol

from server.scenes.browser_messages import passes
from server.scenes.visitors import PAGE_HEADER, VISITOR_HEADER, Viewer
from server.sessions.drawings import MAX_DRAWING_BYTES

MOST_AHEAD = 4  #: messages that were sent and not reported as drawn; each message of a running scene contains one state
PATIENCE_S = 5.0  #: the next message is sent after this time in any case, because a report may be lost with its message

#: The report, as packed by viser's client: ``{"type": "GridbloomDrawn"}``.
DRAWN = b"\x81\xa4type\xaeGridbloomDrawn"


class Pace:
    """Messages that were sent to one browser and that it has drawn. Used from the event loop.

    There is no wait for a browser that has never reported, such as a program without the script.
    """

    def __init__(self) -> None:
        self._reports = False
        self._ahead = 0
        self._drawn = asyncio.Event()

    def drawn(self) -> None:
        """Record a report. The first one only says that reports will follow."""
        self._ahead = max(0, self._ahead - 1) if self._reports else self._ahead
        self._reports = True
        self._drawn.set()

    async def turn(self) -> None:
        """Wait until another message may be sent, and count it."""
        while self._reports and self._ahead >= MOST_AHEAD:
            self._drawn.clear()
            try:
                async with asyncio.timeout(PATIENCE_S):
                    await self._drawn.wait()
            except TimeoutError:
                self._ahead -= 1
        self._ahead += 1


#: It reports each processed message. viser's worker sends what is posted to it as ``send`` once it has reported the
#: connection, and a message is processed in the frame after its arrival. The first report says that the page has this
#: script.
#:
#: viser's client reconnects only while its document has the focus, which a view inside of a page rarely has. Here it is
#: enough that the page is visible.
#:
#: The target of a touch captures it before any handler is called (Pointer Events 3, "implicit pointer capture"), and
#: viser's client interprets a captured pointer as dragging a gizmo, so that a tap would pick nothing. It is therefore
#: captured after viser's client has handled it.
SCRIPT = b"""<script>
window.Worker = class extends window.Worker {
  constructor(...given) {
    super(...given);
    const report = () => this.postMessage({ type: "send", message: { type: "GridbloomDrawn" } });
    this.addEventListener("message", ({ data }) => {
      if (data?.type === "connected") report();
      if (data?.type === "message_batch") requestAnimationFrame(() => requestAnimationFrame(report));
    });
  }
};
let captured = false;
window.addEventListener("pointerdown", ({ target, pointerId }) => {
  captured = target.hasPointerCapture(pointerId);
  if (captured) target.releasePointerCapture(pointerId);
}, true);
window.addEventListener("pointerdown", ({ target, pointerId }) => {
  if (captured) target.setPointerCapture(pointerId);
});
document.hasFocus = () => document.visibilityState === "visible";
document.addEventListener("visibilitychange", () => window.dispatchEvent(new Event("focus")));
</script>"""


SUBPROTOCOL = f"viser-v{metadata.version('viser')}"  #: from the metadata, because importing viser is slow
MAX_FROM_BROWSER = 16 * 1024  #: maximum size of one message from the browser; a camera message has about 300 bytes
MAX_FROM_SCENE = MAX_DRAWING_BYTES + (
    1 << 20
)  #: maximum size of one message from viser: the largest drawing and its fields
CONNECT_S = 30.0
TOO_BIG = 1009  #: the close code for a message that is too large

_log = structlog.get_logger(__name__)

_TITLE = (b"<title>Viser</title>", b"<title>Gridbloom \xe2\x80\x93 3D view</title>")
#: For a view controlled by the page: only the canvas, on the background of the page.
_PLAIN_STYLE = b"""<style>
body *:not(canvas):not(:has(canvas)) { visibility: hidden !important; pointer-events: none !important; }
[data-dock-root] *:has(canvas) { inset: 0 !important; width: 100% !important; }
:root, body, body *:has(canvas) { background: #faf8f2 !important; }
:root[data-mantine-color-scheme="dark"], [data-mantine-color-scheme="dark"] body,
[data-mantine-color-scheme="dark"] body *:has(canvas) { background: #11151d !important; }
</style></head>"""


@dataclass(frozen=True, slots=True)
class Page:
    """viser's client page, plain and compressed, with its ETag."""

    plain: bytes
    compressed: bytes
    etag: str


@lru_cache(maxsize=2)
def client_page(script: bytes, *, plain_view: bool = False) -> Page:
    """Return the client page of the installed viser with Gridbloom's title; for a plain view, without its panel.

    ``script`` is the built ``static/src/pages/scene.ts``, which reads :mod:`server.scenes.voxel_chunk`.
    """
    spec = find_spec("viser")  # does not import it
    assert spec is not None and spec.origin is not None  # noqa: S101, PT018 - a dependency
    plain = (Path(spec.origin).parent / "client" / "build" / "index.html").read_bytes().replace(*_TITLE, 1)
    # In a function, so that a module's names stay local; those of a plain script are global.
    scripts = SCRIPT + b'<script>(() => {"use strict";' + script + b"})();</script>"
    plain = plain.replace(b"<head>", b"<head>" + scripts, 1)
    if plain_view:
        plain = plain.replace(b"</head>", _PLAIN_STYLE, 1)
    return Page(plain, gzip.compress(plain, mtime=0), f'"{hashlib.sha256(plain).hexdigest()[:32]}"')


def page_headers(host: str) -> dict[str, str]:
    """Return the headers of the 3D page: its content security policy for a service reached as ``host``.

    viser's client has inline scripts and styles, unpacks them with WebAssembly, whose glue code creates functions from
    strings, and runs its socket in a worker from a blob. It may connect only to this service, whatever the query of its
    address.
    """
    policy = {
        "default-src": "'none'",
        "script-src": "'unsafe-inline' 'unsafe-eval' blob:",
        "style-src": "'unsafe-inline'",
        "img-src": "'self' data: blob:",
        "font-src": "data:",
        "worker-src": "blob:",
        "connect-src": f"'self' ws://{host} wss://{host} data: blob:",
        "base-uri": "'none'",
        "form-action": "'none'",
        "frame-ancestors": "'self'",
    }
    return {
        "Content-Security-Policy": "; ".join(f"{name} {value}" for name, value in policy.items()),
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Cache-Control": "private, no-cache",
        "Vary": "Accept-Encoding",
    }


async def take(browser: WebSocket) -> bool:
    """Accept a browser's WebSocket; return False if it was refused because it lacks viser's subprotocol.

    viser itself refuses clients of another version. Call this before the scene is created, because viser's client
    closes a socket that is not accepted within 5 s.
    """
    if SUBPROTOCOL not in browser.scope.get("subprotocols", ()):
        await browser.close(1002, f"The subprotocol must be {SUBPROTOCOL}.")
        return False
    await browser.accept(SUBPROTOCOL)
    return True


async def pass_on(browser: WebSocket, path: Path, viewer: Viewer = Viewer()) -> None:  # noqa: B008 - immutable
    """Connect a browser's accepted WebSocket to viser's Unix socket at ``path`` until one closes; close the other.

    The scene identifies the connection by ``viewer``.
    """
    try:
        async with asyncio.timeout(CONNECT_S):
            scene = await unix_connect(
                str(path),
                subprotocols=[Subprotocol(SUBPROTOCOL)],
                additional_headers={VISITOR_HEADER: viewer.visitor, PAGE_HEADER: viewer.page},
                max_size=MAX_FROM_SCENE,
                max_queue=1,  # further messages, which may be just as large, wait in viser
                compression=None,
                proxy=None,
                ping_interval=None,  # both ends are in one process
            )
    except (OSError, TimeoutError, WebSocketException):
        await browser.close(1011, "The scene does not answer.")
        return
    async with _closed_in_the_end(scene):
        pace = Pace()
        pumps = [
            asyncio.create_task(_to_scene(browser, scene, pace)),
            asyncio.create_task(_to_browser(scene, browser, pace)),
        ]
        try:
            await asyncio.wait(pumps, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for pump in pumps:
                pump.cancel()
            results = await asyncio.gather(*pumps, return_exceptions=True)
    codes = [result for result in results if isinstance(result, int)]
    if scene.protocol.close_sent is not None and scene.protocol.close_sent.code == TOO_BIG:
        _log.warning("message of a 3D view too large", limit=MAX_FROM_SCENE)
        codes = [TOO_BIG]
    if codes and codes[0] != 0:
        await _close(browser, codes[0])
    for result in results:
        if isinstance(result, Exception):
            raise result


@asynccontextmanager
async def _closed_in_the_end(scene: ClientConnection) -> AsyncIterator[None]:
    """Close the connection after the block, even if the wait for viser's answer is cancelled.

    viser answers once it has read what was sent. websockets closes the socket with that answer, but a service that ends
    cancels its tasks, perhaps for the second time while a slow scene has not answered yet.
    """
    try:
        yield
    finally:
        reading = asyncio.create_task(_read_to_the_end(scene))
        try:
            await scene.close()
        finally:
            reading.cancel()
            scene.transport.abort()


async def _read_to_the_end(scene: ClientConnection) -> None:
    with suppress(ConnectionClosed):
        async for _ in scene:
            pass


async def _to_scene(browser: WebSocket, scene: ClientConnection, pace: Pace) -> int:
    """Forward the browser's messages; return the close code for the browser's socket, 0 if it is already closed."""
    while True:
        message = await browser.receive()
        if message["type"] == "websocket.disconnect":
            return 0
        data = message.get("bytes")
        if data is None or len(data) > MAX_FROM_BROWSER:
            return 1003 if data is None else TOO_BIG
        if data == DRAWN:
            pace.drawn()
        elif passes(data):
            try:
                await scene.send(data)
            except ConnectionClosed:
                return 1001


async def _to_browser(scene: ClientConnection, browser: WebSocket, pace: Pace) -> int:
    """Forward viser's messages; return the close code for the browser's socket, 0 if it is already closed."""
    try:
        async for data in scene:
            await pace.turn()
            await browser.send_bytes(data if isinstance(data, bytes) else data.encode())
    except ConnectionClosed as closed:
        return 1002 if closed.rcvd is not None and closed.rcvd.code == 1002 else 1001
    except (WebSocketDisconnect, RuntimeError):  # the browser disconnected during the send
        return 0
    return 1001


async def _close(browser: WebSocket, code: int) -> None:
    try:
        await browser.close(code)
    except RuntimeError:
        return
