"""Visits of browser tests: a fresh visitor's browser context and page, used again by the next test where that is sound.

To open a page in a new context takes about a second of the processor more than in a page that is there, as it needs
another renderer process. The next test with the same window gets the page without cookies, storage, sessions, routes
and emulated media, at an empty document. What cannot be taken back in Playwright (listeners, scripts that run first,
permissions, sessions of the debugger) makes the context end with its test; so does a test that fails.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Literal

from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page
from playwright.sync_api import Error as PlaywrightError

from tests.browser.lateness import late_script
from tests.browser.looking import SECONDS

SIZES = {"desktop": (1440, 900), "laptop": (1024, 700), "tablet": (768, 1024), "phone": (390, 844)}
TOUCHED = ("tablet", "phone")
Motion = Literal["reduce", "no-preference"]  #: what a visitor's browser asks for
MOST_KEPT = 2  #: visits that wait for another test; each has a renderer process

# Methods of pages and contexts whose effect cannot be taken back.
_LASTING = (
    "add_init_script", "add_locator_handler", "expose_binding", "expose_function", "grant_permissions",
    "new_cdp_session", "on", "once", "route_web_socket", "set_default_timeout", "set_extra_http_headers",
    "set_geolocation", "set_offline",
)  # fmt: skip


class WatchedPage:
    """A page whose console errors, uncaught exceptions and requests to other hosts are kept for the test to judge."""

    def __init__(self, context: BrowserContext, server: str) -> None:
        self.page: Page = context.new_page()
        self.problems: list[str] = []
        self._server = server
        self.page.on("console", self._console)
        self.page.on("pageerror", lambda error: self.problems.append(f"uncaught: {error}"))
        self.page.on("request", lambda request: self._request(request.url))

    def _console(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            where = message.location  # of a request that failed: its address
            self.problems.append(f"console: {message.text} ({where['url']}:{where['lineNumber']}, on {self.page.url})")

    def _request(self, url: str) -> None:
        own = (self._server, self._server.replace("http", "ws", 1), "data:", "blob:", "about:", "file:")
        if not url.startswith(own):
            self.problems.append(f"asked another host: {url}")


@contextmanager
def visiting(browser: Browser, server: str, **options: Any) -> Iterator[BrowserContext]:
    """Yield a fresh visitor's browser that asks for less motion.

    What sessions they begin end with them: many tests must not fill the server.
    """
    context = _new_context(browser, **options)
    yield context
    _close_pages(context)
    _end_sessions(context, server)
    context.close()


def _new_context(browser: Browser, **options: Any) -> BrowserContext:
    still = {"viewport": {"width": 1440, "height": 900}, "reduced_motion": "reduce"}
    context = browser.new_context(**(still | options))
    context.set_default_timeout(SECONDS * 1000)
    if script := late_script():
        context.add_init_script(script)
    return context


def _close_pages(context: BrowserContext, but: Page | None = None) -> None:
    """Close all pages ``but`` one, after the handlers of their requests: a request of a handler would fail later."""
    for page in context.pages:
        if page is not but:
            page.unroute_all(behavior="wait")
            page.close()
    context.unroute_all(behavior="wait")


def _end_sessions(context: BrowserContext, server: str) -> None:
    # The service closes connections that were idle for 5 s, perhaps just now: such a request is sent again.
    for session in context.request.get(f"{server}/api/sessions", max_retries=2).json()["sessions"]:
        context.request.delete(f"{server}/api/sessions/{session['id']}", max_retries=2)


class Visit:
    """A visitor's browser with a window of a size of :data:`SIZES`, and in it one page that is watched."""

    def __init__(self, browser: Browser, server: str, size: str, motion: Motion) -> None:
        width, height = SIZES[size]
        touched = size in TOUCHED
        self.window = (server, size, motion)
        self._server = server
        self._motion = motion
        self._is_lasting = False
        self._viewport = {"width": width, "height": height}
        self.context = _new_context(
            browser, viewport=self._viewport, has_touch=touched, is_mobile=touched, reduced_motion=motion
        )
        self._watched: WatchedPage | None = None
        self._note_lasting(self.context)

    def _note_lasting(self, made: Page | BrowserContext) -> None:
        """Note calls of the methods whose effect lasts."""

        def noting(method: Callable[..., Any]) -> Callable[..., Any]:
            def call(*arguments: Any, **named: Any) -> Any:
                self._is_lasting = True
                return method(*arguments, **named)

            return call

        for name in _LASTING:
            if hasattr(made, name):
                setattr(made, name, noting(getattr(made, name)))

    def watched(self) -> WatchedPage:
        """The page, of which nothing was noted yet."""
        if self._watched is None:
            self._watched = WatchedPage(self.context, self._server)
            self._note_lasting(self._watched.page)
        self._watched.problems.clear()
        return self._watched

    def end(self) -> None:
        """End the sessions that were begun, and close the context."""
        _close_pages(self.context)
        with suppress(PlaywrightError):  # the visit may be kept for longer than a test's own service runs
            _end_sessions(self.context, self._server)
        self.context.close()

    def begin_again(self) -> bool:
        """Make this a new visitor's; return False where that cannot be done."""
        page = None if self._watched is None else self._watched.page
        if self._is_lasting or page is None or page.is_closed():
            return False
        try:
            _close_pages(self.context, but=page)
            page.unroute_all(behavior="wait")
            page.goto(f"{self._server}/livez")
            page.evaluate("() => { localStorage.clear(); sessionStorage.clear(); }")
            page.goto("about:blank")
            page.mouse.move(-10, -10)  # nothing is under the mouse, as on a new page
            # "null" would be what this machine prefers, whatever the context asks for.
            page.emulate_media(media="null", color_scheme="light", reduced_motion=self._motion)
            page.set_viewport_size(self._viewport)  # type: ignore[arg-type]
            _end_sessions(self.context, self._server)
            self.context.clear_cookies()
        except PlaywrightError:
            return False
        return True
