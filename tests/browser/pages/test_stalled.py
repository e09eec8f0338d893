"""A service that stands still (SIGSTOP): after two seconds a page that waits for it says so, until it answers."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from subprocess import Popen

import pytest
from playwright.sync_api import Browser, expect

from tests.browser.looking import await_map
from tests.browser.running import running_service
from tests.browser.visits import visiting

Service = tuple[str, Popen[bytes]]
STAYS = "The server does not answer. What is shown stays; the page continues as soon as it answers."


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory, logs_dir: Path) -> Iterator[Service]:
    """Return the address of a service of these tests, and its process."""
    with running_service(tmp_path_factory.mktemp("data"), "--logs-dir", str(logs_dir)) as service:
        yield service


@contextmanager
def standing(process: Popen[bytes]) -> Iterator[None]:
    """Have a service stand still until the block ends, with its workers if it has some."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    numbers = [process.pid, *map(int, children.read_text().split() if children.exists() else ())]

    def send(number: int) -> None:
        for process_number in numbers:
            with suppress(ProcessLookupError):  # a job's, which has ended
                os.kill(process_number, number)

    send(signal.SIGSTOP)
    try:
        yield
    finally:
        send(signal.SIGCONT)


def test_a_page_that_waits_for_a_request_says_so_until_the_server_answers(browser: Browser, own: Service) -> None:
    address, process = own
    with visiting(browser, address, reduced_motion="reduce") as context:
        page = context.new_page()
        page.goto(f"{address}/lecture.html")
        expect(page.locator("#grid figure")).to_be_visible()
        says = page.locator(".no-answer")
        with standing(process):
            page.get_by_role("button", name="Class", exact=True).click()
            expect(says).to_have_text(
                "The server does not answer. The lecture works without it; a class continues as soon as it answers."
            )
        expect(says).to_have_count(0)
        expect(page.get_by_role("dialog")).to_be_visible()


def test_a_log_that_is_shown_says_so_in_one_place(browser: Browser, own: Service) -> None:
    address, process = own
    with visiting(browser, address, reduced_motion="reduce") as context:
        page = context.new_page()
        page.goto(f"{address}/logs.html?log=sample-office")
        await_map(page)
        over = page.locator(".viewer-over")
        with standing(process):
            expect(over.first).to_have_text(STAYS)
            expect(page.locator(".no-answer")).to_have_count(0)
        expect(over).to_have_count(0)


def test_a_list_that_is_awaited_says_so_and_then_comes(browser: Browser, own: Service) -> None:
    address, process = own
    with visiting(browser, address, reduced_motion="reduce") as context:
        page = context.new_page()
        page.goto(f"{address}/logs.html?log=sample-office")
        await_map(page)
        says, logs = page.locator(".no-answer"), page.locator(".log-card")
        with standing(process):
            page.get_by_role("button", name="All logs").click()
            expect(says).to_have_text(STAYS)
            expect(logs).to_have_count(0)
        expect(says).to_have_count(0)
        expect(logs).not_to_have_count(0)


def test_a_puzzle_of_a_list_is_opened_once_the_server_answers(browser: Browser, own: Service) -> None:
    address, process = own
    with visiting(browser, address, reduced_motion="reduce") as context:
        page = context.new_page()
        page.goto(f"{address}/puzzles.html")
        puzzle = page.get_by_role("button", name="Open The closed doors")
        expect(puzzle).to_be_visible()
        says = page.locator(".no-answer")
        with standing(process):
            puzzle.click()
            expect(says).to_have_text(STAYS)
            expect(page.get_by_role("heading", name="The closed doors")).to_be_visible()
        expect(says).to_have_count(0)
        await_map(page)
