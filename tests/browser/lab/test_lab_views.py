"""The stage of the lab: one to four views, of which world and belief are the first."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.looking import (
    await_map,
    centre,
    frame,
    map_bytes,
    open_group,
    place_on,
    settled_digest,
    until,
    without_canvas_in_3d,
)
from tests.browser.pages.test_axe import violations


def share_of_width(part: Locator, whole: Locator) -> float:
    """Return the width of an element as a share of another one's."""
    own, all_of_it = (one.bounding_box() or {"width": math.nan} for one in (part, whole))
    return own["width"] / all_of_it["width"]


def test_the_stage_has_up_to_four_views_which_the_address_names(page: Page, open_lab: Callable[..., Page]) -> None:
    without_canvas_in_3d(page)
    open_lab()
    views = page.locator(".lab-stage .view-pane")
    expect(views).to_have_count(2)
    page.keyboard.press("4")
    expect(views).to_have_count(4)
    # Folded controls leave the view its width; unfolded they are beside it.
    solid, controls = views.nth(2).get_by_title("3D view"), views.nth(2).get_by_role("button", name="Controls")
    for is_unfolded in (False, True):
        expect(controls).to_have_attribute("aria-pressed", str(is_unfolded).lower())
        assert (share_of_width(solid, views.nth(2)) > 0.97) != is_unfolded
        controls.click()
    second = page.get_by_role("region", name="Second map")
    second.get_by_role("button", name="Show the correct map").click()
    expect(second.locator(".compare-name")).to_have_text("A correct")
    expect(page.get_by_role("region", name="The belief").locator(".compare-name")).to_have_text("B as set")
    expect(page.locator(".compare-divider")).to_have_count(0)
    border = page.get_by_role("separator", name="Border between the columns of views")
    before = centre(border)[0]
    border.press("PageDown")
    until("a wider first view", lambda: centre(border)[0] > before + 20)
    assert violations(page, ".lab-stage") == []
    # The address names the layout beside the world, which it follows.
    until("the address", lambda: re.search(r"views=four:world,map,3d,second:60:50#s=", page.url))
    page.reload()
    expect(views).to_have_count(4)
    panel = open_group(page, "3D view")
    expect(panel).to_contain_text("The 3D view is on the stage.")
    panel.get_by_label("Layout", exact=True).select_option("World and belief")
    expect(views).to_have_count(2)
    expect(panel.get_by_title("3D view")).to_be_visible()
    until("the usual address", lambda: "views=" not in page.url)


def test_a_phone_shows_world_and_belief_at_once_and_other_views_as_pages(page: Page, server: str) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(f"{server}/lab.html")
    await_map(page)
    world, belief = page.locator(".lab-stage .plate-picture").all()
    expect(belief).to_be_in_viewport(ratio=1.0)
    expect(world).to_be_in_viewport(ratio=1.0)
    expect(page.locator(".lab-stage .select")).to_have_count(0)
    page.goto(f"{server}/lab.html?views=four:map,world,second,3d:50:50")
    await_map(page)
    views = page.locator(".lab-stage .view-pane")
    expect(views.nth(0)).to_be_in_viewport(ratio=0.9)
    expect(views.nth(1)).not_to_be_in_viewport()
    views.nth(0).get_by_role("button", name="Go to view 3").click()
    expect(views.nth(2)).to_be_in_viewport(ratio=0.9)
    assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")


def test_plots_and_frames_of_the_lab_are_views_that_follow_its_scans(page: Page, open_lab: Callable[..., Page]) -> None:
    open_lab()
    page.get_by_label("View 1").select_option("Plots")
    plots = page.locator(".lab-plot")
    expect(plots).to_have_count(4)
    step = "(values) => gridbloom.connection.store.send(values)"
    page.evaluate(step, {"type": "faults", "values": {"drift": True}})
    page.evaluate(step, {"type": "step", "scans": 30})
    settled_digest(page)

    def stated(plot: str) -> float:
        words = re.search(r"([\d.]+) (bit|cells|m|m/s)$", page.locator(f"[data-plot='{plot}'] .number").inner_text())
        return float(words[1]) if words else -1.0

    seen = map_bytes(page)
    cells = np.frombuffer(seen["bytes"], np.uint8)
    cells = cells[cells > 0]
    odds = np.exp(seen["low"] + (cells - 1) / 254.0 * (seen["high"] - seen["low"]))
    p = odds / (1.0 + odds)
    entropy = float(-(p * np.log2(p) + (1.0 - p) * np.log2(1.0 - p)).sum())
    until("the map's entropy", lambda: abs(stated("Entropy of the map") - entropy) < 0.01)
    now = frame(page)
    error = math.dist(now["pose"][:2], now["believed_pose"][:2])
    assert error > 0.01
    until("the error of the belief", lambda: abs(stated("Error of the belief") - error) < 0.006)
    assert violations(page, ".lab-stage") == []
    page.get_by_label("View 1").select_option("Camera")
    page.get_by_role("button", name="Give the robot a depth camera").click()
    page.evaluate(step, {"type": "step", "scans": 5})
    image = page.get_by_role("img", name="Depth image")
    until("an image of 4 : 3", lambda: image.evaluate("one => one.naturalWidth === 96 && one.naturalHeight === 72"))
    assert violations(page, ".lab-stage") == []
    now = frame(page)
    page.get_by_label("View 1").select_option("Frames")
    rows = page.locator(".lab-frames tbody tr")
    for row, pose in ((0, now["believed_pose"]), (1, now["pose"])):
        cells_of = [float(text.replace("−", "-")) for text in rows.nth(row).locator("td").all_inner_texts()]
        assert cells_of == pytest.approx([pose[0], pose[1], math.degrees(pose[2])], abs=0.06)
    assert violations(page, ".lab-stage") == []


def test_a_distance_is_measured_on_the_belief(page: Page, open_lab: Callable[..., Page]) -> None:
    open_lab()
    belief = page.get_by_role("region", name="The belief")
    expect(belief.locator(".map-scale")).to_contain_text(re.compile(r"^\d+ m$"))
    belief.get_by_role("button", name="Measure a distance").click()
    measured = belief.get_by_role("region", name="Measured")
    measured.get_by_role("switch", name="Snap to walls").click()
    for place in ((3.0, 4.0), (6.0, 8.0)):
        page.mouse.click(*place_on(belief.locator(".picture"), place))
    words = until("a length", lambda: re.match(r"(\d+\.\d+) m", measured.locator(".number").inner_text()))
    metres = float(words[1])
    assert abs(metres - 5.0) < 0.1  # of two pixels
    measured.get_by_role("button", name="Close the ruler").click()
    expect(measured).to_have_count(0)
