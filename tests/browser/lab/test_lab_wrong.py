"""The switches of "What goes wrong", in Chromium: each changes the map, explains it, and can be undone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import frame, map_digest, open_group, settled_digest, until

FAULTS: dict[str, dict[str, Any]] = {
    "Laser mounted at an angle": {"mount_yaw": 0.15},
    "Laser upside down": {"mount_upside_down": True},
    "Odometry drift": {},
    "No return counted as a hit": {"no_return": "hit", "range_max": 4},
    "Polished walls": {"no_return": "free"},
    "Each beam counts": {"clamp": False},
    "No clamp": {"clamp": False},
}


# The place of a cell that is occupied in the map and free in the correct one.
_DIFFERENT = """() => {
  const { map, second } = gridbloom.connection.store;
  const { geometry, cells } = map.peek();
  const correct = second.peek()?.map.peek()?.cells;
  if (!correct) return null;
  for (let row = 0; row < geometry.rows; row++)
    for (let col = 0; col < geometry.cols; col++)
      if (cells.at(row, col) > 200 && correct.at(row, col) > 0 && correct.at(row, col) < 60)
        return [0, 1].map((k) => geometry.origin[k] + ([col, row][k] + 0.5) * geometry.resolution);
  return null;
}"""


def store(page: Page, name: str) -> Any:
    """Return a signal of the page's store."""
    return page.evaluate("(name) => gridbloom.connection.store[name].peek()", name)


def values(page: Page) -> dict[str, Any]:
    """Return the mapping parameters as the page has them."""
    result: dict[str, Any] = page.evaluate("() => gridbloom.connection.store.mapping.values.peek()")
    return result


@pytest.fixture
def lab(open_lab: Callable[..., Page]) -> Page:
    """The lab, standing still, with the group of faults open."""
    page = open_lab()
    open_group(page, "Faults")
    return page


def test_each_switch_changes_the_map_and_restores_it(lab: Page) -> None:
    lab.evaluate("() => gridbloom.connection.store.setParameter('mount_yaw', 0.02)")
    before = settled_digest(lab)
    before_values = values(lab)
    assert before_values["mount_yaw"] == 0.02
    for label, changed in FAULTS.items():
        switch = lab.get_by_role("switch", name=label)
        expect(switch).to_have_attribute("aria-checked", "false")
        switch.click()
        expect(switch).to_have_attribute("aria-checked", "true")
        assert settled_digest(lab) != before, label
        assert changed.items() <= values(lab).items()
        expect(lab.locator(".faults-note")).to_contain_text("Look for:")
        switch.click()
        expect(switch).to_have_attribute("aria-checked", "false")
        assert settled_digest(lab) == before, label
        assert values(lab) == before_values, label


def test_a_slider_ends_a_fault_and_undo_brings_it_back(lab: Page) -> None:
    switch = lab.get_by_role("switch", name="Laser mounted at an angle")
    switch.click()
    expect(switch).to_have_attribute("aria-checked", "true")
    lab.evaluate("() => gridbloom.connection.store.setParameter('mount_yaw', 0.05)")
    expect(switch).to_have_attribute("aria-checked", "false")
    lab.keyboard.press("Control+z")
    expect(switch).to_have_attribute("aria-checked", "true")
    lab.keyboard.press("Control+z")
    expect(switch).to_have_attribute("aria-checked", "false")
    assert values(lab)["mount_yaw"] == 0
    lab.keyboard.press("Control+Shift+Z")
    expect(switch).to_have_attribute("aria-checked", "true")


def test_the_correct_map_is_shown_in_the_picture_of_the_wrong_one(lab: Page) -> None:
    right = settled_digest(lab)
    lab.get_by_role("switch", name="Laser upside down").click()
    until("the wrong map", lambda: map_digest(lab) != right)
    lab.get_by_role("switch", name="Show the correct map").click()
    names = lab.get_by_role("region", name="The belief").locator(".compare-name")
    expect(names).to_have_text(["A correct", "B as set"])
    assert store(lab, "compared") == {"values": {"mount_upside_down": False}, "with_faults": False}
    # Another fault with it: the second map is right of both.
    lab.get_by_role("switch", name="Odometry drift").click()
    until("the drift", lambda: store(lab, "faults")["drift"])
    lab.get_by_role("switch", name="No clamp").click()
    until("both set right", lambda: store(lab, "compared")["values"] == {"mount_upside_down": False, "clamp": True})
    # Left of the divider the correct map is shown, right of it the other.
    settled_digest(lab)
    wrong = until("a cell in which the maps differ", lambda: lab.evaluate(_DIFFERENT))
    divider = lab.get_by_role("slider", name="Divider between A, on the left, and B")
    colours = []
    for key in ("Home", "End"):
        divider.press(key)
        colours.append(lab.evaluate("(xy) => gridbloom.colourAt(xy)", wrong))
    assert sum(abs(a - b) for a, b in zip(*colours, strict=True)) > 60
    lab.get_by_role("switch", name="Show the correct map").click()
    expect(names).to_have_count(0)
    until("no second map", lambda: store(lab, "compared") is None)


def test_a_drifting_robot_is_drawn_where_the_map_has_it(lab: Page) -> None:
    lab.get_by_role("switch", name="Odometry drift").click()
    lab.get_by_role("button", name="Play").click()
    lab.evaluate("() => gridbloom.connection.store.send({ type: 'speed', value: 8 })")
    until(
        "some drift", lambda: (f := frame(lab)).get("believed_pose") and abs(f["believed_pose"][1] - f["pose"][1]) > 0.2
    )
    shown = lab.evaluate(
        "() => { const s = gridbloom.connection.store;"
        " return [s.beliefFrame.peek().pose, s.frame.peek().believed_pose, s.beliefPose.peek(),"
        " s.frame.peek().believed_scan_pose]; }"
    )
    assert shown[0] == shown[1]
    assert shown[2] == pytest.approx(shown[3])
