"""The lab's costmap and path, in Chromium: the goal is dragged, a table taken away, a keepout zone painted."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import await_true, drag_along, open_group, place_on, settled_digest

_STORE = "gridbloom.connection.store"
_PATH = f"{_STORE}.part('path').message.peek()"
_POINTS = "gridbloom.connection.store.layers.content('plan').peek()?.columns"
_LENGTH = f"() => {_PATH}?.length"


def place(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return the place on the page of a point of the map, in the belief's picture."""
    return place_on(page.locator(".lab .picture").last, (x, y))


def check_the_sheet_in_front(page: Page) -> None:
    """The layer whose name is under the pointer is painted in front of the others; a dragged sheet follows."""
    picture = page.locator(".sheets-picture canvas")
    pixels = "canvas => canvas.toDataURL()"
    static = page.get_by_role("switch", name="Static")
    static.hover()
    expect(static).to_have_class(re.compile("in-front"))
    of_static = picture.evaluate(pixels)
    dynamic = page.get_by_role("switch", name="Dynamic")
    dynamic.hover()
    expect(dynamic).to_have_class(re.compile("in-front"))
    expect(static).not_to_have_class(re.compile("in-front"))
    assert picture.evaluate(pixels) != of_static
    box, before = picture.bounding_box(), dynamic.bounding_box()
    assert box is not None
    assert before is not None
    x, y = box["x"] + box["width"] / 2, before["y"] + before["height"] + 30
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 12, steps=3)
    expect(picture).to_have_class("dragged")
    page.mouse.up()
    expect(picture).not_to_have_class("dragged")
    after = dynamic.bounding_box()
    assert after is not None
    assert after["y"] != before["y"]


@pytest.mark.long
def test_the_path_follows_goal_table_and_keepout_zone(open_lab: Callable[..., Page], tmp_path: Path) -> None:
    page = open_lab()
    open_group(page, "Path")
    # A table in the corridor of the office: the path leads around it, until its lifetime is over.
    page.get_by_role("button", name="Put a table in the way").click()
    await_true(page, f"() => {_PATH}?.length > 6.05")
    page.get_by_role("button", name="Take the table away").first.click()
    await_true(page, f"() => {_PATH}?.length < 6")
    settled_digest(page)  # the path that is left is measured, none on the way there
    straight = page.evaluate(_LENGTH)
    # The goal is dragged into the kitchen: the path ends there.
    drag_along(page, place(page, 12.0, 7.0), place(page, 9.0, 7.1), place(page, 7.5, 9.5))
    await_true(page, f"() => Math.hypot({_PATH}.goal[0] - 7.5, {_PATH}.goal[1] - 9.5) < 0.2")
    await_true(page, f"() => {{ const c = {_POINTS}; return c && Math.abs(c[1].at(-1) - 9.5) < 0.2; }}")
    # A click in the other picture sets it back.
    page.mouse.click(*place(page, 12.0, 7.0))
    await_true(page, f"() => Math.abs({_PATH}?.length - {straight}) < 0.2")
    # A keepout zone across half of the corridor: the path leads around it, and back after undo.
    page.get_by_role("radio", name="Keepout").check()
    drag_along(page, place(page, 10.0, 6.1), place(page, 10.0, 6.6), place(page, 10.0, 7.1))
    await_true(page, f"() => {_PATH}?.length > {straight} + 0.1")
    await_true(page, f"() => {_STORE}.part('costmap').message.peek().keepout.length === 1")
    page.get_by_role("button", name="Undo stroke").click()
    await_true(page, f"() => {_PATH}?.length < {straight} + 0.05")
    # A speed limit there: the path stays as it is, and the limit is told where it holds. Undone, none is painted.
    page.get_by_role("radio", name="Speed limit").check()
    drag_along(page, place(page, 6.3, 7.0), place(page, 9.0, 7.1), place(page, 10.0, 7.1))
    await_true(page, "() => gridbloom.connection.store.layers.grid('speed_filter').map.peek() !== null")
    await_true(page, f"() => {_PATH}?.speed_limit === '40 %: 0.20 m/s' && {_PATH}.length < {straight} + 0.05")
    expect(page.get_by_text("40 %: 0.20 m/s")).to_be_visible()
    page.get_by_role("button", name="Undo stroke").click()
    expect(page.get_by_text("40 %: 0.20 m/s")).to_have_count(0)
    # Why a cell has its cost, and what no path says.
    page.get_by_role("radio", name="Why").check()
    page.mouse.click(*place(page, 8.5, 7.4))
    expect(page.get_by_text("The nearest obstacle is")).to_be_visible()
    page.get_by_role("button", name="Make the robot 1 m wide").click()
    expect(page.get_by_text("There is no path to the goal: it would have to pass where the robot")).to_be_visible()
    # The layers as sheets: one is switched off; a handle of the curve is moved; a corner that crosses has a note.
    open_group(page, "Costmap")
    check_the_sheet_in_front(page)
    page.get_by_role("switch", name="Inflation").click()
    await_true(page, f"() => {_PATH}?.reaches_goal")
    page.get_by_role("slider", name="Inflation radius").first.press("ArrowLeft")
    await_true(page, f"() => {_STORE}.part('costmap').message.peek().values.inflation_radius < 1.2")
    page.get_by_role("button", name="Hexagon").click()
    corner = page.get_by_role("button", name="Corner 1 of 6")
    box = corner.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 150, y + 60, steps=4)
    expect(page.get_by_text("crosses itself")).to_be_visible()
    page.mouse.up()
    await_true(page, f"() => {_STORE}.part('costmap').message.peek().footprint[0][0] < -0.2")
    # The parameters as a Nav2 file, out and in; a wrong one says where.
    with page.expect_download() as download:
        page.get_by_role("button", name="Download yaml").click()
    download.value.save_as(tmp_path / "nav2.yaml")
    text = (tmp_path / "nav2.yaml").read_text()
    assert "StaticLayer" in text
    assert "InflationLayer" not in text  # switched off above
    (tmp_path / "wrong.yaml").write_text(text.replace("lookahead_dist: 0.6", "lookahead_dist: -6"))
    page.get_by_label("Nav2 parameter file").set_input_files(tmp_path / "wrong.yaml")
    expect(page.get_by_text("controller_server.FollowPath.lookahead_dist")).to_be_visible()
    (tmp_path / "right.yaml").write_text(text.replace("lookahead_dist: 0.6", "lookahead_dist: 0.9"))
    page.get_by_label("Nav2 parameter file").set_input_files(tmp_path / "right.yaml")
    await_true(page, f"() => {_STORE}.part('costmap').message.peek().values.lookahead_dist === 0.9")
    page.get_by_role("button", name="End the costmap").click()
    expect(page.get_by_role("button", name="Make the costmap")).to_be_visible()
