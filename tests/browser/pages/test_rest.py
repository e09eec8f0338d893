"""A page on which nothing changes rests: it asks for no animation frame and has no style and no layout computed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pytest
from playwright.sync_api import CDPSession, Page

from tests.browser.looking import open_groups, until
from tests.browser.pages.test_one_screen import prepare
from tests.marks import also_long

# Counts how often the page asks for an animation frame.
_COUNT = """() => {
  const ask = window.requestAnimationFrame.bind(window);
  window.framesAsked = 0;
  window.uncountedFrames = async (n) => { for (let i = 0; i < n; i++) await new Promise(ask); };
  window.requestAnimationFrame = (task) => { window.framesAsked += 1; return ask(task); };
}"""
# As if another tab were in front.
_HIDE = """() => {
  Object.defineProperty(document, "hidden", { value: true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""
WATCHED_FRAMES = 15  #: a group that paints for a moment after it is opened is looked at again


def work(page: Page, devtools: CDPSession) -> tuple[float, ...]:
    """Numbers of the page's requests for a frame, and of Chromium's computations of styles and layout."""
    counts = {one["name"]: one["value"] for one in devtools.send("Performance.getMetrics")["metrics"]}
    return page.evaluate("() => window.framesAsked"), counts["RecalcStyleCount"], counts["LayoutCount"]


def rests(page: Page, devtools: CDPSession) -> bool:
    """Whether the page does nothing in some animation frames, which Chromium makes for this test."""
    before = work(page, devtools)
    page.evaluate("n => uncountedFrames(n)", WATCHED_FRAMES)
    return work(page, devtools) == before


@pytest.mark.moving
@pytest.mark.parametrize("every", [3, *also_long(1)])
def test_the_lab_rests_while_it_is_paused_whatever_group_is_open_and_while_it_is_hidden(
    page: Page, open_lab: Callable[..., Page], every: int
) -> None:
    """One group in ``every`` is opened."""
    page.add_init_script(f"({_COUNT})()")
    prepare(page)
    open_lab(scans=15)
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable")
    at_rest = partial(rests, page, devtools)
    opened = []
    for title in open_groups(page, every):
        until(f"the lab to rest with {title} open", at_rest)
        opened.append(title)
    assert len(opened) > 8 / every
    page.get_by_role("button", name="Play").click()
    until("the lab to go", lambda: not at_rest())
    page.evaluate(_HIDE)
    until("the hidden lab to rest", at_rest)
