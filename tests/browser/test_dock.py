"""The tabs of the log page's dock by keys."""

from __future__ import annotations

from playwright.sync_api import Page, expect


def test_the_tabs_go_by_keys(page: Page, server: str) -> None:
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    tabs = page.get_by_role("tab")
    tabs.first.focus()
    page.keyboard.press("End")
    expect(tabs.last).to_be_focused()
    expect(tabs.last).to_have_attribute("aria-selected", "true")
    page.keyboard.press("ArrowRight")
    expect(tabs.first).to_be_focused()
    # One tab is in the order of the page, the open one; after it comes what it opened.
    page.keyboard.press("Tab")
    expect(page.locator(".dock-group:not([hidden])")).to_be_focused()
