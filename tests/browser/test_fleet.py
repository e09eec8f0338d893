"""The page of the fleet in Chromium: all logs mapped by one press, their maps, findings and failures."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import await_true


@pytest.mark.usefixtures("two_logs")
@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_one_press_maps_all_logs(page: Page, server: str) -> None:
    page.goto(f"{server}/logs.html")
    page.get_by_role("link", name="Map all logs").click()
    yard = page.locator(".fleet-card", has_text="fleet-yard.log")
    empty = page.locator(".fleet-card", has_text="fleet-empty.log")
    expect(yard).to_contain_text("Not mapped yet")
    page.get_by_role("button", name="Map").click()
    expect(yard).to_contain_text("40 scans")
    expect(empty).to_contain_text("The log holds no scans")
    yard.scroll_into_view_if_needed()
    await_true(page, "() => [...document.images].some((one) => one.alt.includes('fleet-yard') && one.naturalWidth > 0)")
    page.get_by_role("searchbox", name="Search logs").fill("fleet")
    page.get_by_role("radio", name="Failed").check()
    expect(page.locator(".fleet-card")).to_have_count(1)
    expect(page.get_by_text("1 log found")).to_be_visible()
    page.get_by_role("radio", name="All").check()
    yard.get_by_role("link").click()
    expect(page).to_have_url(re.compile("log=folder-"))


def test_without_logs_the_page_says_what_it_does_and_shows_the_sample(page: Page, server: str) -> None:
    counts = dict.fromkeys(("none", "queued", "running", "done", "failed"), 0)
    nothing: dict[str, object] = {
        "revision": 0,
        "whole": True,
        "workers": 1,
        "cluster": None,
        "counts": counts,
        "logs": [],
    }
    page.route("**/api/fleet?*", lambda route: route.fulfill(json=nothing))  # other tests put logs into the folder
    page.goto(f"{server}/fleet.html")
    start = page.get_by_role("region", name="Without logs")
    expect(start.get_by_text("There are no logs with scans here yet.")).to_be_visible()
    await_true(
        page, "() => [...document.images].some((one) => one.alt === 'Map of the sample' && one.naturalWidth > 0)"
    )
    expect(start).to_contain_text("600 scans")
    expect(start.get_by_role("link", name="Add logs")).to_have_attribute("href", "/logs.html")
    start.get_by_role("link", name="A simulated office (sample)").click()
    expect(page).to_have_url(re.compile("log=sample-office"))
