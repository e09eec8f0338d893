"""Shared by the tests of the lecture: opening a section, and the numbers in its text."""

from __future__ import annotations

import re

from playwright.sync_api import BrowserContext, Locator, Page, expect


def never_idle(opener: Page | BrowserContext) -> None:
    """Have the lectures that are opened there from now on set up only the figures near the window.

    All others are set up when the browser is idle, which takes half of the processor time of an opened lecture.
    """
    opener.add_init_script("window.requestIdleCallback = () => 0")


def open_lecture(page: Page, server: str) -> None:
    """Open the lecture, and wait for its last sections: the code of some comes after the page."""
    page.goto(f"{server}/lecture.html")
    expect(page.locator("#next")).to_be_attached()


def set_up_every_figure(page: Page) -> None:
    """Have the lecture that is open render all its figures."""
    expect(page.locator("#next")).to_be_attached()
    page.evaluate("() => dispatchEvent(new Event('beforeprint'))")
    expect(page.locator(".figure-awaited")).to_have_count(0)
    page.evaluate("() => dispatchEvent(new Event('afterprint'))")


def open_section(page: Page, server: str, name: str) -> Locator:
    """Open the lecture at a section, with the figures near it, and return the section."""
    never_idle(page)
    page.goto(f"{server}/lecture.html#{name}")
    section = page.locator(f"#{name}")
    expect(section).to_be_in_viewport()
    return section


def numbers(locator: Locator) -> list[int]:
    """Return the whole numbers in an element's text."""
    return [int(found) for found in re.findall(r"\d+", locator.inner_text())]
