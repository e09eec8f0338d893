"""The map keeps its size when a pointer first enters it: what is said about a cell has its room beforehand."""

from __future__ import annotations

from playwright.sync_api import Page, expect

from tests.browser.looking import await_map, await_true, painted
from tests.browser.one_screen import SIZES

#: Wide, low and narrow windows, and one like a phone's.
WINDOWS = (*SIZES, (412, 915))
BOXES = "() => [...document.querySelectorAll('.picture')].map((one) => JSON.stringify(one.getBoundingClientRect()))"


def moves_nothing(page: Page, picture: str) -> None:
    """Move the pointer from outside to the middle of the map, in each window."""
    await_map(page)
    for width, height in WINDOWS:
        page.mouse.move(0, 0)
        await_true(page, "() => gridbloom.connection.store.cell.peek() === null")
        page.set_viewport_size({"width": width, "height": height})
        painted(page)
        before = page.evaluate(BOXES)
        page.locator(picture).first.hover()
        await_true(page, "() => gridbloom.connection.store.cell.peek() !== null")
        painted(page)
        assert page.evaluate(BOXES) == before, (width, height)


def test_of_a_log(page: Page, server: str) -> None:
    page.goto(f"{server}/logs.html")
    page.get_by_role("button", name="Open map").first.click()
    expect(page.locator(".viewer .picture").first).to_be_visible()
    moves_nothing(page, ".viewer .picture")


def test_of_the_lab(page: Page, server: str) -> None:
    page.goto(f"{server}/lab.html")
    moves_nothing(page, ".lab .picture")
