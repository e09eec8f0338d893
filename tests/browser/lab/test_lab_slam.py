"""The lab's robot with drifting wheels runs SLAM while it drives, in real Chromium."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import await_map, open_group, until

ERROR = """() => {
  const { pose, believed_pose } = gridbloom.connection.store.frame.peek();
  return believed_pose ? Math.hypot(pose[0] - believed_pose[0], pose[1] - believed_pose[1]) : null;
}"""
NODES = "() => gridbloom.connection.store.layers.content('slam').peek()?.columns[0].length ?? 0"


@pytest.mark.long
def test_the_believed_path_stays_on_the_true_one(page: Page, server: str) -> None:
    page.goto(f"{server}/lab.html")
    await_map(page)
    open_group(page, "SLAM")
    page.get_by_role("switch", name="Drifting wheels").check()
    page.evaluate("gridbloom.connection.store.send({ type: 'speed', value: 8 })")
    page.get_by_role("button", name="Play", exact=True).click()
    until("the wheels to drift", lambda: (page.evaluate(ERROR) or 0) > 0.3)
    off = page.locator(".slam-off")
    expect(off).to_have_text(re.compile(r"\d"))
    page.get_by_role("switch", name="SLAM while driving").check()
    until("SLAM", lambda: page.evaluate(NODES) > 20 and page.evaluate(ERROR) < 0.15)
    # On a slow machine seconds of the drive pass between two frames, and a turn is corrected some scans later.
    until("its graph to grow", lambda: page.evaluate(NODES) > 60 and page.evaluate(ERROR) < 0.15)
    expect(page.locator(".slam-group .facts-list")).to_contain_text("Scans matched")
    # The layers end with the switch.
    page.get_by_role("switch", name="SLAM while driving").uncheck()
    until("the graph to go", lambda: page.evaluate(NODES) == 0)
