"""A service that stands still (SIGSTOP): after two seconds a page that waits for it says so, until it answers."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import Popen

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import await_map
from tests.browser.running import running_service
from tests.marks import also_long_rows

SAYS = "The server does not answer. What is shown stays, and the page goes on by itself."

Service = tuple[str, Popen[bytes]]


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory, logs_dir: Path) -> Iterator[Service]:
    """Return the address of a service of these tests, and its process."""
    with running_service(tmp_path_factory.mktemp("data"), "--logs-dir", str(logs_dir)) as service:
        yield service


@contextmanager
def standing(process: Popen[bytes]) -> Iterator[None]:
    """Have a service stand still until the block ends."""
    process.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        process.send_signal(signal.SIGCONT)


def search(page: Page) -> None:
    page.get_by_label("Search logs").fill("sample")


def map_all(page: Page) -> None:
    page.get_by_role("button", name=re.compile("^Map ")).click()


def begin_puzzle(page: Page) -> None:
    page.get_by_role("button", name="Open").first.click()


def open_class(page: Page) -> None:
    page.get_by_role("button", name="Class", exact=True).click()


@pytest.mark.parametrize(
    ("path", "asks", "says", "stays"),
    [
        ("/logs.html", search, SAYS, ".log-card"),
        *also_long_rows(
            ("/fleet.html", map_all, SAYS, "h1"),
            ("/puzzles.html", begin_puzzle, SAYS, ".puzzles-level"),
            (
                "/lecture.html",
                open_class,
                "The server does not answer. The lecture works without it; a class goes on by itself.",
                "#grid figure",
            ),
        ),
    ],
    ids=["logs", "all logs", "puzzles", "lecture"],
)
def test_a_page_that_waits_for_a_server_that_stalls_says_so_until_it_answers(
    page: Page, own: Service, path: str, asks: Callable[[Page], None], says: str, stays: str
) -> None:
    address, process = own
    page.goto(address + path)
    expect(page.locator(stays).first).to_be_visible()
    with standing(process):
        asks(page)
        expect(page.locator(".no-answer")).to_have_text(says)
        expect(page.locator(stays).first).to_be_visible()
    expect(page.locator(".no-answer")).to_have_count(0)


def test_a_log_that_is_shown_says_so_in_one_place(page: Page, own: Service) -> None:
    address, process = own
    page.goto(f"{address}/logs.html?log=sample-office")
    await_map(page)
    with standing(process):
        page.get_by_role("button", name="Share").click()
        expect(page.locator(".viewer-over").first).to_have_text(SAYS)
        expect(page.locator(".no-answer")).to_have_count(0)
    expect(page.locator(".viewer-over")).to_have_count(0)
