"""Shared by the tests of the lecture: opening a section, and the numbers in its text."""

from __future__ import annotations

import re

from playwright.sync_api import Locator, Page, expect


def open_section(page: Page, server: str, name: str) -> Locator:
    """Open the lecture at a section, and return the section."""
    page.goto(f"{server}/lecture.html#{name}")
    section = page.locator(f"#{name}")
    expect(section).to_be_in_viewport()
    return section


def numbers(locator: Locator) -> list[int]:
    """Return the whole numbers in an element's text."""
    return [int(found) for found in re.findall(r"\d+", locator.inner_text())]
