"""The log page as one screen: map, time and the open group of the dock are in the viewport, and nothing covers them."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import await_map

SIZES = ((1280, 720), (1440, 900), (1920, 1080), (1024, 768))

# The boxes of the map, of its time and of the open group; whether the page scrolls; how much of the map lies on top.
_MEASURED = """() => {
  const box = (selector) => document.querySelector(selector).getBoundingClientRect().toJSON();
  const map = box(".viewer-map");
  const places = [0.05, 0.5, 0.95].flatMap((x) => [0.05, 0.5, 0.95].map((y) => [x, y]));
  const covered = places.filter(([x, y]) => {
    const top = document.elementFromPoint(map.left + x * map.width, map.top + y * map.height);
    return !top?.closest(".viewer-map");
  });
  const root = document.documentElement;
  return {
    map, time: box(".viewer-transport"), group: box(".dock-group:not([hidden])"), covered,
    scrolls: root.scrollHeight > innerHeight || root.scrollWidth > innerWidth,
  };
}"""


def test_map_and_open_group_share_one_screen(page: Page, server: str) -> None:
    page.emulate_media(reduced_motion="reduce")
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    await_map(page)
    tabs = page.get_by_role("tab").all()
    assert len(tabs) >= 7
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        maps = []
        for tab in tabs:
            tab.click()
            expect(tab).to_have_attribute("aria-selected", "true")
            seen: dict[str, Any] = page.evaluate(_MEASURED)
            where = (width, height, tab.inner_text())
            assert not seen["scrolls"], where
            assert seen["covered"] == [], where
            for name in ("map", "time", "group"):
                box = seen[name]
                assert box["left"] >= 0, (*where, name)
                assert box["top"] >= 0, (*where, name)
                assert box["right"] <= width, (*where, name)
                assert box["bottom"] <= height, (*where, name)
            assert seen["group"]["height"] > 0.25 * height, where
            maps.append(seen["map"])
        assert all(one == maps[0] for one in maps), (width, height, "a group that opens moves the map")
        if width >= 1200:
            assert maps[0]["width"] == pytest.approx(2 / 3 * width, rel=0.08)
            assert maps[0]["height"] > 0.6 * height
        else:
            assert maps[0]["height"] > 0.3 * height


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
