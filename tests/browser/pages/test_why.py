"""The explanation of a cell in Chromium: in the lab and on a log, by mouse, keyboard and touch."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.looking import await_map, frame, open_group, open_sample, place_on, settled_digest, still, until
from tests.marks import also_long

# The place of the most occupied cell nearest to the robot but out of its reach (a finger on a wall beside the robot
# takes the robot), and a look at it from so near that a click cannot miss it.
_WALL = """() => {
  const { store } = gridbloom.connection;
  const { geometry, cells } = store.map.peek();
  const [x, y] = store.frame.peek().pose;
  let best = null;
  for (let row = 0; row < geometry.rows; row++)
    for (let col = 0; col < geometry.cols; col++) {
      const p = [0, 1].map((k) => geometry.origin[k] + ([col, row][k] + 0.5) * geometry.resolution);
      const found = { byte: cells.at(row, col), away: Math.hypot(p[0] - x, p[1] - y), xy: p };
      if (found.away < 0.6) continue;
      if (!best || found.byte > best.byte || (found.byte === best.byte && found.away < best.away)) best = found;
    }
  store.setView({ x: best.xy[0] + 0.4, y: best.xy[1] + 0.3, scale: 0.005 });
  return best.xy;
}"""


@pytest.fixture
def lab(open_lab: Callable[..., Page]) -> Page:
    """The lab, standing still with a map on show."""
    return open_lab()


@pytest.fixture
def viewer(page: Page, server: str) -> Page:
    """The viewer on the sample log, standing at its end."""
    open_sample(page, server)
    await_map(page)
    page.get_by_role("slider", name="Scans in the map").focus()
    page.keyboard.press("End")
    until("the end of the log", lambda: frame(page)["index"] == frame(page)["count"])
    settled_digest(page)
    return page


def wall_pixel(page: Page, picture: Locator) -> tuple[list[float], tuple[float, float]]:
    """Return the place of a wall cell, now seen from near, and where it lies in the viewport."""
    xy = page.evaluate(_WALL)
    picture.scroll_into_view_if_needed()
    return xy, place_on(picture, xy)


def store(page: Page, name: str) -> Any:
    """Return a signal of the page's store."""
    return page.evaluate("(name) => gridbloom.connection.store[name].peek()", name)


def ask(page: Page) -> list[float]:
    """Shift+click a wall cell of the belief; return its place."""
    xy, (x, y) = wall_pixel(page, page.locator(".picture").last)
    page.keyboard.down("Shift")
    page.mouse.click(x, y)
    page.keyboard.up("Shift")
    page.mouse.move(2, 2)
    until("the answer", lambda: store(page, "why"))
    return xy


def check_answer(page: Page, xy: list[float]) -> dict[str, Any]:
    """Hold the panel against the page's own map; return the answer."""
    why: dict[str, Any] = store(page, "why")
    cell = page.evaluate("(xy) => gridbloom.readState(xy)", xy)
    geometry = page.evaluate("() => gridbloom.connection.store.map.peek().geometry")
    step = (geometry["high"] - geometry["low"]) / 254
    assert (why["row"], why["col"]) == (cell["row"], cell["col"])
    assert why["log_odds"] == pytest.approx(cell["log_odds"], abs=step)
    # The whole story told again, beam by beam, ends at what the map shows.
    values = page.evaluate("() => gridbloom.connection.store.mapping.values.peek()")
    assert why["contributions"][-1]["n"] == why["total"]
    if why["total"] == len(why["contributions"]):
        log_odds = why["prior"]
        for touch in why["contributions"]:
            evidence = 0.0 if touch.get("outweighed") else values["log_odds_hit" if touch["hit"] else "log_odds_miss"]
            assert touch["increment"] == pytest.approx(evidence)
            log_odds = min(max(log_odds + touch["increment"], why["log_odds_min"]), why["log_odds_max"])
        assert log_odds == pytest.approx(cell["log_odds"], abs=step)
        assert why["hits"] == sum(touch["hit"] for touch in why["contributions"])
    panel = page.locator(".why")
    expect(panel.locator(".why-sentence")).to_contain_text(re.compile(r"^Occupied, p 0\.9\d: "))
    expect(panel.locator(".why-sentence")).to_contain_text(f"{why['hits']} beam")
    expect(panel.locator(".why-sentence")).to_contain_text(f"{why['total'] - why['hits']} passed through")
    return why


def test_a_wall_in_the_lab_is_explained(lab: Page) -> None:
    pose = frame(lab)["pose"]
    why = check_answer(lab, ask(lab))
    assert frame(lab)["pose"] == pose  # a question sends nobody anywhere
    slider = lab.get_by_role("slider", name="Beams through this cell")
    assert int(slider.input_value()) == why["total"] > 3
    equation = lab.locator(".why-equation output")
    newest = equation.inner_text()
    assert re.fullmatch(r"−?\d\.\d\d [+−] 0\.\d\d = −?\d\.\d\d( → −?\d\.\d\d)?", newest)
    slider.focus()
    lab.keyboard.press("Home")
    expect(equation).to_have_text(re.compile(r"^0\.00 [+−] "))
    assert store(lab, "selectedContribution")["n"] == 1
    lab.get_by_role("button", name="Next beam").click()
    until("the second touch", lambda: store(lab, "selectedContribution")["n"] == 2)
    expect(lab.locator(".why-update")).to_contain_text(f"2 of {why['total']}")
    expect(lab.locator(".why-update").get_by_role("button")).to_have_count(0)
    lab.keyboard.press("Escape")
    expect(lab.locator(".why")).to_have_count(0)
    assert store(lab, "explainedPoint") is None


@pytest.mark.long
def test_the_answer_follows_the_robot_and_the_parameters(lab: Page) -> None:
    ask(lab)
    before = store(lab, "why")
    lab.evaluate("() => gridbloom.connection.store.setParameter('log_odds_hit', 0.4)")
    until(
        "the new increment", lambda: any(abs(t["increment"] - 0.4) < 1e-6 for t in store(lab, "why")["contributions"])
    )
    lab.get_by_role("button", name="Play").click()
    until("more scans in the answer", lambda: store(lab, "why")["index"] > before["index"] + 10)


def test_a_cell_is_selected_and_left_by_keyboard(lab: Page) -> None:
    picture = lab.locator(".picture").last
    wall_pixel(lab, picture)
    picture.focus()
    lab.keyboard.press("Shift+ArrowUp")
    lab.keyboard.press("?")
    until("the answer", lambda: store(lab, "why"))
    expect(lab.get_by_role("slider", name="Beams through this cell")).to_be_focused()
    expect(lab.locator(".why [role=status]")).to_contain_text(re.compile("beam"))
    lab.keyboard.press("Escape")
    expect(picture).to_be_focused()


def test_the_beam_that_is_looked_at_is_painted(lab: Page) -> None:
    xy, (x, y) = wall_pixel(lab, lab.locator(".picture").last)
    lab.mouse.click(x, y)  # holds the cell
    lab.mouse.move(2, 2)
    lab.locator(".readout").get_by_role("button", name="Why?").click()
    touch = until("the answer", lambda: store(lab, "selectedContribution"))
    away = [touch["pose"][k] - xy[k] for k in (0, 1)]
    length = (away[0] ** 2 + away[1] ** 2) ** 0.5
    # On the beam, a little before it comes to the cell.
    bearing = touch["pose"][2] + touch["bearing"]
    reach = length - 0.3
    on_beam = [touch["pose"][0] + reach * math.cos(bearing), touch["pose"][1] + reach * math.sin(bearing)]
    asked = lab.evaluate("(xy) => gridbloom.colourAt(xy)", on_beam)
    lab.keyboard.press("Escape")
    until("no more questions", lambda: store(lab, "explainedPoint") is None)
    plain = lab.evaluate("(xy) => gridbloom.colourAt(xy)", on_beam)
    assert None not in (asked, plain)
    assert sum(abs(a - b) for a, b in zip(asked, plain, strict=True)) > 60


def test_a_log_seeks_to_the_scan_of_a_contribution(viewer: Page) -> None:
    why = check_answer(viewer, ask(viewer))
    slider = viewer.get_by_role("slider", name="Beams through this cell")
    slider.focus()
    viewer.keyboard.press("Home")
    first = until("the first touch", lambda: (t := store(viewer, "selectedContribution")) and t["n"] == 1 and t)
    assert first["scan"] == why["first_scan"]
    viewer.get_by_role("button", name="Next beam").click()
    second = until("the second touch", lambda: (t := store(viewer, "selectedContribution")) and t["n"] == 2 and t)
    viewer.locator(".why-update").get_by_role("button", name="Go to ").click()
    until("the map of that scan", lambda: frame(viewer)["index"] == second["scan"] + 1)
    until("the answer of that scan", lambda: store(viewer, "why")["index"] == second["scan"] + 1)
    there = store(viewer, "why")
    assert 2 <= there["total"] < why["total"]
    assert store(viewer, "selectedContribution")["scan"] == second["scan"]


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_a_long_press_explains_a_cell(open_lab: Callable[..., Page]) -> None:
    page = open_lab()
    _, (x, y) = wall_pixel(page, page.locator(".picture").first)
    finger = page.context.new_cdp_session(page)
    finger.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
    until("the panel", lambda: page.locator(".why").count() == 1)
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    until("the answer", lambda: store(page, "why"))
    assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")
    # The explanation has been scrolled to, under the pictures.
    expect(page.locator(".why-sentence")).to_be_in_viewport(ratio=1)
    below = (
        "(why) => why.getBoundingClientRect().top - document.querySelector('.lab-stage').getBoundingClientRect().bottom"
    )
    until("the panel below the pictures", lambda: page.locator(".why").evaluate(below) >= 0)
    for picture in page.locator(".picture").all():
        expect(picture).to_be_in_viewport(ratio=0.95)
    page.locator(".why").get_by_role("button", name="Close").click()
    expect(page.locator(".why")).to_have_count(0)


@pytest.mark.parametrize("context", ["phone", *also_long("desktop", "laptop")], indirect=True)
def test_in_a_log_the_explanation_replaces_the_open_group(viewer: Page) -> None:
    open_group(viewer, "Download")
    picture = viewer.locator(".picture").first
    still(picture)
    before = picture.bounding_box()
    ask(viewer)
    group = viewer.get_by_role("tabpanel", name="Why")
    expect(group.locator(".why-chart")).to_be_visible()
    assert picture.bounding_box() == before
    group.get_by_role("button", name="Close").click()
    expect(viewer.get_by_role("tabpanel", name="Download")).to_be_visible()
    assert viewer.locator(".downloads a").count() == 6
    expect(viewer.get_by_role("button", name="Report as PDF")).to_be_visible()
