"""The running service and Chromium, for every browser test."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from tests.browser.looking import SECONDS, settled_digest, until
from tests.browser.running import running_chromium, running_server
from tests.browser.visits import MOST_KEPT, Motion, Visit, WatchedPage, visiting
from tests.server.library.small_logs import carmen

expect.set_options(timeout=SECONDS * 1000)

SEED = 7  #: of the worlds that stand still; any will do


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark all tests of this folder."""
    here = Path(__file__).parent
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.browser)


@pytest.fixture(scope="session")
def logs_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder whose logs the service lists. It reads what tests put there, so nothing is until it is needed."""
    return tmp_path_factory.mktemp("logs")


@pytest.fixture
def two_logs(logs_dir: Path) -> Iterator[None]:
    """Two logs in the folder of the service, one of them without scans, which other tests do not see."""
    yard, empty = logs_dir / "fleet-yard.log", logs_dir / "fleet-empty.log"
    yard.write_bytes(carmen(40))
    empty.write_text("# CARMEN Logfile\nODOM 0 0 0 0 0 0 1 a 1\n")
    yield
    yard.unlink()
    empty.unlink()


@pytest.fixture
def mapped_logs(context: BrowserContext, server: str, logs_dir: Path, two_logs: None) -> None:
    """The logs of the service mapped, as on the page *Map all logs*: maps, findings and a failure.

    Each worker maps them once: a log of the same name, size and time is the same log to the service.
    """
    del two_logs
    for log in logs_dir.glob("fleet-*.log"):
        os.utime(log, (0, 0))
    assert context.request.post(f"{server}/api/fleet", data={"again": False}).status == 202

    def is_done() -> bool:
        counts = context.request.get(f"{server}/api/fleet", max_retries=2).json()["counts"]
        return bool(counts["done"] and counts["failed"] and not counts["queued"] + counts["running"] + counts["none"])

    until("the logs to be mapped", is_done)


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory, logs_dir: Path) -> Iterator[str]:
    """Return the address of a running service: each of xdist's workers has its own, and a Chromium of its own."""
    with running_server(tmp_path_factory.mktemp("data"), "--logs-dir", str(logs_dir)) as address:
        yield address


# One for the browser tests that follow each other on a worker, as starting one takes as long as a short test. Not for
# the whole run: while it runs, Playwright keeps an event loop in this thread, and asyncio tests need theirs.
_open_chromium = ExitStack()
_chromium: list[Browser] = []  # the one that runs, if one does
_kept: list[Visit] = []  # of earlier tests in it, for later ones
_VISIT = pytest.StashKey[Visit]()


def _close_chromium() -> None:
    _kept.clear()
    _chromium.clear()
    _open_chromium.close()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None, object, object]:
    """End Chromium after the test, where the next one is not of this folder."""
    try:
        return (yield)
    finally:
        if nextitem is None or Path(__file__).parent not in nextitem.path.parents:
            _close_chromium()


@pytest.fixture
def browser(request: pytest.FixtureRequest) -> Browser:
    """Return headless Chromium; where it has crashed in a test before, another one."""
    if not (_chromium and _chromium[0].is_connected()):
        _close_chromium()
        request.config.add_cleanup(_close_chromium)  # where pytest stops before the last test
        _chromium.append(_open_chromium.enter_context(running_chromium()))
    return _chromium[0]


@pytest.fixture
def motion(request: pytest.FixtureRequest) -> Motion:
    """Return what the visitor's browser asks for: less motion, save in tests that are marked ``moving``.

    What moves by itself takes most of the processor and is of no use to other tests.
    """
    return "reduce" if request.node.get_closest_marker("moving") is None else "no-preference"


@pytest.fixture
def context(browser: Browser, server: str, motion: Motion, request: pytest.FixtureRequest) -> Iterator[BrowserContext]:
    """Return a fresh visitor's browser, at the size that an indirect parameter names."""
    window = (server, str(getattr(request, "param", "desktop")), motion)
    kept = next((one for one in _kept if one.window == window), None)
    if kept is not None:
        _kept.remove(kept)
    visit = request.node.stash[_VISIT] = kept or Visit(browser, *window)
    failed = request.session.testsfailed
    yield visit.context
    if request.session.testsfailed == failed and visit.begin_again():
        _kept.append(visit)
    else:
        visit.end()
    while len(_kept) > MOST_KEPT:
        _kept.pop(0).end()


@pytest.fixture
def visitor(browser: Browser, server: str, motion: Motion) -> Iterator[BrowserContext]:
    """Return the browser of another visitor."""
    with visiting(browser, server, reduced_motion=motion) as context:
        yield context


@pytest.fixture
def watched(context: BrowserContext, request: pytest.FixtureRequest) -> Iterator[WatchedPage]:
    """Return a page on which any console error or uncaught exception fails the test at its end."""
    page = request.node.stash[_VISIT].watched()
    yield page
    assert page.problems == []


@pytest.fixture
def page(watched: WatchedPage) -> Page:
    """Return the page of :func:`watched`."""
    return watched.page


@pytest.fixture
def open_lab(page: Page, server: str) -> Callable[..., Page]:
    """Return a function that opens the lab on a world that stands still: each time the same one."""

    def open_(world: str = "office", scans: int = 45) -> Page:
        page.goto(f"{server}/lab.html?session={standing_world(page.context, server, world, scans)}")
        page.locator("figure.profile").wait_for()  # what is below the pictures comes after them
        settled_digest(page)
        return page

    return open_


def standing_world(context: BrowserContext, server: str, world: str = "office", scans: int = 45) -> str:
    """Begin a session of a world in which the robot has walked for a while and stands; return its id."""
    story = {"steps": 5 * scans}  # of 0.02 s; the sensor scans at 10 Hz
    wanted = {"kind": "simulation", "world": world, "seed": SEED, "playing": False, "story": story}
    answer = context.request.post(f"{server}/api/sessions", data=wanted)
    assert answer.status == 201, answer.text()
    return str(answer.json()["id"])
