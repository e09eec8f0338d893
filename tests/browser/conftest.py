"""The running service and real Chromium, for every browser test: without a Chromium they fail, they never skip."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page

from tests.browser.running import running_chromium, running_server

SIZES = {"desktop": (1440, 900), "laptop": (1024, 700), "phone": (390, 844)}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark all tests of this folder; the timeout leaves room for kernels that compile in a fresh clone.

    ``make test`` runs them by themselves, after all others: a page that shares its core with another misses frames.
    """
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.browser)
            item.add_marker(pytest.mark.timeout(240))


@pytest.fixture(scope="session")
def logs_dir(tmp_path_factory: pytest.TempPathFactory, real_logs: Path | None) -> Path:
    """Return a folder of logs that the service lists: Intel, where the real logs are."""
    folder = tmp_path_factory.mktemp("logs")
    if real_logs is not None:
        shutil.copy(real_logs / "carmen" / "intel-corrected.log.gz", folder)
    return folder


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory, logs_dir: Path) -> Iterator[str]:
    """Return the address of a running service."""
    with running_server(tmp_path_factory.mktemp("data"), "--logs-dir", str(logs_dir)) as address:
        yield address


# Not longer than a module: while it runs, Playwright keeps an event loop in this thread, and asyncio tests need theirs.
@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Return headless Chromium."""
    with running_chromium() as chromium:
        yield chromium


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
            self.problems.append(f"console: {message.text}")

    def _request(self, url: str) -> None:
        if not url.startswith((self._server, self._server.replace("http", "ws", 1), "data:", "blob:", "about:")):
            self.problems.append(f"asked another host: {url}")


@pytest.fixture
def context(browser: Browser, request: pytest.FixtureRequest) -> Iterator[BrowserContext]:
    """Return a fresh visitor's browser, at the size that an indirect parameter names."""
    width, height = SIZES[getattr(request, "param", "desktop")]
    phone = getattr(request, "param", "desktop") == "phone"
    context = browser.new_context(viewport={"width": width, "height": height}, has_touch=phone, is_mobile=phone)
    yield context
    context.close()


@pytest.fixture
def watched(context: BrowserContext, server: str) -> Iterator[WatchedPage]:
    """Return a page on which any console error or uncaught exception fails the test at its end."""
    page = WatchedPage(context, server)
    yield page
    assert page.problems == []


@pytest.fixture
def page(watched: WatchedPage) -> Page:
    """Return the page of :func:`watched`."""
    return watched.page
