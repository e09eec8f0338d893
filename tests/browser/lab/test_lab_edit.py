"""Drawing into the world, erasing, undo, and the moving table, in Chromium."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import SECONDS, drag_along, frame, open_group, place_on, settled_digest, until


def edits(page: Page) -> dict[str, Any]:
    """Return what was changed in the page's world."""
    result: dict[str, Any] = page.evaluate("() => gridbloom.connection.store.world.peek().edits")
    return result


def pixel(page: Page, xy: list[float]) -> tuple[float, float]:
    """Return where a place of the world lies in the viewport, on the picture of the world."""
    return place_on(page.locator(".picture").first, xy)


def stroke(page: Page, start: list[float], end: list[float]) -> None:
    """Drag on the world from one place to another."""
    drag_along(page, pixel(page, start), pixel(page, end), steps=5)


def send_robot(page: Page, xy: list[float]) -> None:
    """Click on a place, and wait for the robot, and for what it sees there."""
    page.mouse.click(*pixel(page, xy))
    until("the robot to be there", lambda: math.dist(frame(page)["pose"][:2], xy) < 0.3)
    settled_digest(page)


@pytest.fixture
def lab(open_lab: Callable[..., Page]) -> Page:
    """The lab in the cluttered room, standing still."""
    return open_lab("room")


def test_a_wall_and_a_box_are_drawn_and_met_by_beams(lab: Page) -> None:
    open_group(lab, "Draw")
    lab.get_by_role("button", name="Draw furniture").click()
    expect(lab.locator(".plate").first).to_contain_text("Drag to draw a box")
    stroke(lab, [5.0, 5.0], [5.6, 5.4])
    until("the box", lambda: edits(lab)["added"])
    assert edits(lab)["added"] == [["box", *(pytest.approx(v, abs=10) for v in (500, 500, 560, 540))]]
    lab.get_by_role("button", name="Draw a wall").click()
    stroke(lab, [3.0, 5.0], [3.05, 6.5])
    until("the wall", lambda: len(edits(lab)["added"]) == 2)
    kind, x0, _, x1, _ = edits(lab)["added"][1]
    assert (kind, x0) == ("wall", x1)  # nearly upright became upright
    # From beside the wall the next scan meets it.
    lab.get_by_role("button", name="Move the robot").click()
    send_robot(lab, [4.0, 5.8])

    def towards_the_wall() -> float | None:
        reading: float | None = lab.evaluate(
            "() => { const f = gridbloom.connection.store.frame.peek(); const [x, y, yaw] = f.scan_pose;"
            " const i = Math.round((Math.PI - yaw - f.angle_min) / f.angle_increment) % f.ranges.length;"
            " return f.ranges[(i + f.ranges.length) % f.ranges.length]; }"
        )
        return reading

    until("a beam on the wall", lambda: (r := towards_the_wall()) is not None and abs(r - 0.94) < 0.2)


def test_erasing_and_taking_it_back(lab: Page) -> None:
    open_group(lab, "Draw")
    lab.get_by_role("button", name="Erase").click()
    before = lab.evaluate("() => gridbloom.connection.store.world.peek().polygons.length")
    lab.mouse.click(*pixel(lab, [0.6, 0.6]))  # the plant in the corner
    until("it to be gone", lambda: len(edits(lab)["erased"]) == 1)
    assert lab.evaluate("() => gridbloom.connection.store.world.peek().polygons.length") == before - 1
    lab.mouse.click(*pixel(lab, [7.0, 0.08]))  # the outer wall stays
    settled_digest(lab)
    assert len(edits(lab)["erased"]) == 1
    lab.get_by_role("button", name="Undo").click()
    until("it to be back", lambda: edits(lab)["erased"] == [])
    lab.get_by_role("button", name="Redo").click()
    until("it to be gone again", lambda: len(edits(lab)["erased"]) == 1)
    open_group(lab, "Sensor model")
    lab.get_by_role("button", name="Reset to defaults").click()
    until("the world as it was built", lambda: edits(lab) == {"added": [], "erased": []})


def test_the_keyboard_draws_and_erases(lab: Page) -> None:
    open_group(lab, "Draw")
    lab.get_by_role("button", name="Draw furniture").click()
    picture = lab.locator(".picture").first
    picture.focus()
    lab.evaluate("() => { gridbloom.connection.store.pinned.value = [5.0, 5.0]; }")
    lab.keyboard.press("Enter")
    lab.evaluate("() => { gridbloom.connection.store.pinned.value = [5.5, 5.5]; }")
    lab.keyboard.press("Enter")
    until("the box", lambda: edits(lab)["added"] == [["box", 500, 500, 550, 550]])
    lab.get_by_role("button", name="Erase").click()
    picture.focus()
    lab.evaluate("() => { gridbloom.connection.store.pinned.value = [5.2, 5.2]; }")
    lab.keyboard.press("Enter")
    until("no box", lambda: edits(lab)["added"] == [])
    lab.keyboard.press("Escape")
    expect(lab.get_by_role("button", name="Move the robot")).to_have_attribute("aria-pressed", "true")


def test_a_teleport_and_a_world_are_taken_back(open_lab: Callable[..., Page]) -> None:
    lab = open_lab("office")
    lab.locator("label", has_text="World").locator("select").select_option("room")
    until("the room", lambda: lab.evaluate("() => gridbloom.connection.store.world.peek().name") == "room")
    settled_digest(lab)
    pose = frame(lab)["pose"]
    send_robot(lab, [8.5, 5.0])
    open_group(lab, "Draw")
    lab.get_by_role("button", name="Undo").click()
    until("the robot to be back", lambda: abs(frame(lab)["pose"][0] - pose[0]) < 1e-3)
    assert frame(lab)["pose"] == pytest.approx(pose, abs=1e-3)
    lab.get_by_role("button", name="Undo").click()
    until("the office", lambda: lab.evaluate("() => gridbloom.connection.store.world.peek().name") == "office")


@pytest.mark.moving
def test_the_moving_table_is_predicted_and_counted(lab: Page) -> None:
    send_robot(lab, [4.3, 5.2])
    open_group(lab, "Moving table")
    figure = lab.locator(".table-figure")
    figure.get_by_role("button", name="Add a table").click()
    until("the table", lambda: len(edits(lab)["added"]) == 1)
    go = figure.get_by_role("button", name="Remove the table")
    expect(go).to_be_disabled()  # nobody has guessed yet
    guess = figure.get_by_role("slider", name="My guess")
    guess.focus()
    lab.keyboard.press("ArrowLeft")
    expect(go).to_be_enabled()
    go.click()
    until("the table to be gone", lambda: edits(lab)["added"] == [])
    both = lab.locator(".plate .compare-name")
    expect(both).to_have_text(["A without the clamp", "B with it"])
    outcome = figure.locator(".table-outcome")
    expect(outcome).to_contain_text(re.compile(r"With the clamp: \d+"))
    expect(outcome).to_contain_text(re.compile(r"Without: \d+"), timeout=2 * SECONDS * 1000)
    told = lab.evaluate("() => gridbloom.connection.store.part('forgetting').message.peek()")
    assert told["with_clamp"] < told["without_clamp"]
    expect(outcome).to_contain_text(f"With the clamp: {told['with_clamp']}. ")
    expect(figure.locator("svg path.clamped")).to_have_count(1)
    figure.get_by_role("button", name="Continue").click()
    expect(both).to_have_count(0)
    until("the robot to walk", lambda: frame(lab)["auto"] is True)
