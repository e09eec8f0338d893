"""The tabs of a dock: by keys, and in a window at 200 %."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page, expect

from tests.browser.looking import centre, drag_along, open_group, open_sample, until
from tests.browser.text_boxes import hidden_texts


def test_the_tabs_go_by_keys(page: Page, server: str) -> None:
    open_sample(page, server)
    sections = page.locator(".dock-tabs").get_by_role("tab")
    expect(sections).to_have_count(7)
    sections.first.focus()
    page.keyboard.press("End")
    expect(sections.last).to_be_focused()
    expect(sections.last).to_have_attribute("aria-selected", "true")
    page.keyboard.press("ArrowRight")
    expect(sections.first).to_be_focused()
    # One tab is in the order of the page, the open one; after it comes what it opened.
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Tab")
    expect(page.locator(".dock-group:not([hidden])")).to_be_focused()
    # Of a section of several groups it is their tabs; the section opens again at the group that was open last.
    sections.first.focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    groups = page.locator(".dock-subtabs").get_by_role("tab")
    page.keyboard.press("End")
    expect(groups.last).to_be_focused()
    page.keyboard.press("Tab")
    expect(page.locator(".dock-group:not([hidden])")).to_be_focused()
    sections.last.click()
    sections.first.click()
    expect(groups.last).to_have_attribute("aria-selected", "true")


def test_the_column_is_resized_and_hidden(page: Page, server: str) -> None:
    open_sample(page, server)
    stage = page.locator(".viewer-map")
    border = page.get_by_role("separator", name="Size of the column")
    border.wait_for()

    def width() -> float:
        box = stage.bounding_box()
        assert box is not None
        return box["width"]

    first = width()
    border.press("PageUp")
    until("a narrower map", lambda: width() < first - 50)
    x, y = centre(border)
    drag_along(page, (x, y), (x + 200, y), steps=4)
    until("a wider map", lambda: width() > first)
    page.get_by_role("button", name="Hide the column").click()
    expect(page.locator(".dock")).to_be_hidden()
    window = page.viewport_size
    assert window is not None
    until("a map as wide as the window", lambda: width() > 0.9 * window["width"])
    page.reload()  # the browser keeps it
    page.get_by_role("button", name="Show the column").click()
    border.press("Enter")
    until("the first size", lambda: abs(width() - first) < 1)
    expect(page.get_by_role("tabpanel", name="Overview")).to_be_visible()


def test_a_window_of_200_percent_has_the_tabs(open_lab: Callable[..., Page]) -> None:
    page = open_lab(scans=15)
    page.set_viewport_size({"width": 720, "height": 450})  # 1440 × 900 at 200 %
    tabs = page.locator(".dock-tabs, .dock-subtabs").get_by_role("tab")
    for title in ("Sensor model", "Faults", "Costmap", "3D map"):
        open_group(page, title).scroll_into_view_if_needed()
        for tab in tabs.all():
            expect(tab).to_be_visible()
            tab.click(trial=True)  # what lies over a tab, or is clipped, fails here
        assert hidden_texts(page, "main") == [], title
