"""Log page, lecture and lab with touch events of the browser, including its scrolling."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import ElementHandle, Locator, Page, expect

from tests.browser.fingers import Fingers, Place
from tests.browser.lecturing import open_lecture, open_section, set_up_every_figure
from tests.browser.looking import await_map, centre, frame, open_group, place_on, settled_digest, until
from tests.marks import also_long

pytestmark = [pytest.mark.parametrize("context", ["phone"], indirect=True), pytest.mark.moving]


@pytest.fixture
def viewer(page: Page, server: str) -> Page:
    """The viewer of the sample, paused."""
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").tap()
    await_map(page)
    page.get_by_role("button", name="Pause").tap()
    until("the log to stand still", lambda: not frame(page)["playing"])
    return page


@pytest.fixture
def fingers(viewer: Page) -> Fingers:
    return Fingers(viewer)


def place_in(locator: Locator, across: float) -> Place:
    """A place on an element's middle line, ``across`` of its width from the left."""
    box = locator.bounding_box()
    assert box is not None
    return box["x"] + box["width"] * across, box["y"] + box["height"] / 2


def scrolled(page: Page) -> float:
    return float(page.evaluate("() => scrollY"))


def view(page: Page) -> dict[str, float]:
    return dict(page.evaluate("() => ({ ...gridbloom.connection.store.view.peek() })"))


def test_a_finger_drags_the_timeline_and_scrolls_the_page_over_it(viewer: Page, fingers: Fingers) -> None:
    timeline = viewer.get_by_role("slider", name="Scans in the map")
    start, end = place_in(timeline, 0.2), place_in(timeline, 0.75)
    fingers.drag((start, end))
    until("the log at the finger's place", lambda: abs(frame(viewer)["index"] - 0.75 * frame(viewer)["count"]) < 10)
    settled_digest(viewer)  # the finger's last places come after
    at = frame(viewer)["index"]
    x, y = place_in(timeline, 0.4)
    fingers.drag(((x, y), (x + 3, y - 250)))
    until("the page to scroll", lambda: scrolled(viewer) > 50)
    assert frame(viewer)["index"] == at
    # A tap is meant.
    viewer.evaluate("() => scrollTo(0, 0)")
    viewer.touchscreen.tap(*place_in(timeline, 0.4))
    until("the log at the tap", lambda: abs(frame(viewer)["index"] - 0.4 * frame(viewer)["count"]) < 10)


def test_two_fingers_zoom_the_map_and_one_moves_it(viewer: Page, fingers: Fingers) -> None:
    x, y = place_in(viewer.locator(".viewer-map"), 0.5)
    before = view(viewer)
    fingers.drag(((x - 40, y), (x - 120, y)), ((x + 40, y), (x + 120, y)))
    after = until("a closer look", lambda: (now := view(viewer))["scale"] < 0.5 * before["scale"] and now)
    assert after["scale"] == pytest.approx(before["scale"] / 3.0, rel=0.15)
    assert viewer.evaluate("() => visualViewport.scale") == 1.0  # it is the map that grew, not the page
    fingers.drag(((x, y), (x + 100, y)))
    moved = until("the map to move along", lambda: (now := view(viewer))["x"] != after["x"] and now)
    assert (after["x"] - moved["x"]) / moved["scale"] == pytest.approx(100.0, abs=12.0)
    assert scrolled(viewer) == 0.0


def test_the_map_stays_in_sight_of_the_sliders(viewer: Page, fingers: Fingers) -> None:
    open_group(viewer, "Settings")
    handle = viewer.locator("input").and_(viewer.get_by_role("slider", name="Max range", exact=True))
    handle.scroll_into_view_if_needed()
    expect(viewer.locator(".viewer-map")).to_be_in_viewport(ratio=0.95)

    def value() -> float:
        return float(viewer.evaluate("() => gridbloom.connection.store.mapping.values.peek().range_max"))

    share = float(handle.input_value()) / 1000.0
    fingers.drag((place_in(handle, 0.03 + 0.94 * share), place_in(handle, 0.25)))
    until("a shorter range", lambda: value() < 5.0)
    settled_digest(viewer)
    # A finger that comes down on a slider only to scroll changes nothing.
    chosen, before = value(), scrolled(viewer)
    x, y = place_in(handle, 0.7)
    fingers.drag(((x, y), (x, y - 150)))
    until("the page to scroll", lambda: scrolled(viewer) > before + 50)
    settled_digest(viewer)
    assert value() == chosen


@pytest.mark.long
def test_the_choice_of_trajectory_follows_other_clients(viewer: Page) -> None:
    other = viewer.context.new_page()
    other.goto(viewer.url)
    for page in (viewer, other):
        open_group(page, "Trajectories")
    poses_from = {page: page.get_by_role("radiogroup", name="Poses from") for page in (viewer, other)}
    poses_from[other].get_by_text("wheel odometry", exact=True).tap()
    expect(viewer.get_by_role("radio", name="wheel odometry")).to_be_checked()
    poses_from[viewer].get_by_text("ground truth", exact=True).tap()
    expect(other.get_by_role("radio", name="ground truth")).to_be_checked()


@pytest.mark.usefixtures("mapped_logs")
@pytest.mark.long
def test_a_finger_chooses_among_the_maps_of_all_logs_and_opens_one(page: Page, server: str) -> None:
    page.goto(f"{server}/fleet.html")
    yard = page.locator(".fleet-card", has_text="fleet-yard")
    expect(yard).to_be_visible()
    page.locator("label", has_text="Failed").tap()
    expect(yard).to_have_count(0)
    expect(page.locator(".fleet-card")).to_contain_text(["fleet-empty.log"])
    page.locator("label", has_text=re.compile("^All$")).tap()
    yard.get_by_role("link").tap()
    expect(page).to_have_url(re.compile("log=folder-"))


# --- the lecture -----------------------------------------------------------------------------------------------------

# A slider put into the middle of the window: where a finger takes it, how large what it takes is, and what it says.
_HOLD = """slider => {
  slider.scrollIntoView({ block: "center", behavior: "instant" });
  const box = (slider.querySelector(".drag-handle-grab, .handle-grab") ?? slider).getBoundingClientRect();
  let x = box.x + box.width / 2;
  if (slider.type === "range") {
    const share = (slider.value - slider.min) / (slider.max - slider.min);
    x = box.x + 11 + (box.width - 22) * share;
  }
  return { x, y: box.y + box.height / 2, width: box.width, height: box.height };
}"""

# A place of a figure where nothing can be taken hold of.
_PASSIVE = """figure => {
  const taken = "[role=slider], button, input, label, select, a, .program-text";
  const area = figure.querySelector(".stage, .plot, .profile-frame, .cell-chart, .cone-box") ?? figure;
  area.scrollIntoView({ block: "center", behavior: "instant" });
  const box = area.getBoundingClientRect();
  for (let up = 0.9; up > 0.1; up -= 0.1)
    for (let across = 0.05; across < 1; across += 0.1) {
      const [x, y] = [box.x + box.width * across, box.y + box.height * up];
      const here = document.elementFromPoint(x, y);
      if (here && area.contains(here) && !here.closest(taken)) return [x, y];
    }
  return null;
}"""

# Resolves when the page has stood still for some frames: after a finger it rolls on, and the next
# touch would scroll it.
_STILL = """async () => {
  for (let before = NaN, same = 0; same < 8; before = scrollY) {
    await new Promise(requestAnimationFrame);
    same = scrollY === before ? same + 1 : 0;
  }
}"""


def value_of(slider: ElementHandle) -> str:
    return str(slider.get_attribute("aria-valuetext"))


def moves(fingers: Fingers, slider: ElementHandle) -> bool:
    """Whether a finger on a slider changes what it says while it is held."""
    before = value_of(slider)
    held = before

    def look() -> None:
        nonlocal held
        fingers.page.evaluate("() => new Promise(requestAnimationFrame)")  # what the figure says is drawn by then
        held = value_of(slider)

    for dx, dy in ((45, 0), (-45, 0), (0, -45), (0, 45)):
        at = slider.evaluate(_HOLD)
        x, y = at["x"], at["y"]
        fingers.drag(((x, y), (x + dx, y + dy)), steps=3, before_lifting=look)
        if held != before:  # a pose of the graph returns when it is let go
            return True
    return False


@pytest.mark.parametrize("every", [40, *also_long(1)])
def test_every_figure_of_the_lecture_is_moved_by_a_finger(page: Page, server: str, every: int) -> None:
    """A finger takes one in ``every`` sliders, and scrolls the page over one in ``every`` figures, in turn."""
    page.emulate_media(reduced_motion="reduce")
    open_lecture(page, server)
    set_up_every_figure(page)
    fingers = Fingers(page)
    met = driven = 0
    for number, section in enumerate(page.locator(".lesson").all()):
        name = section.get_attribute("id")
        in_figure = section.locator("figure").locator("[role=slider], input[type=range]:enabled").element_handles()
        in_prose = section.locator(".prose .drag-number").element_handles()[:1]
        for slider in in_figure + in_prose:
            at = slider.evaluate(_HOLD)
            assert min(at["width"], at["height"]) >= 24, (name, slider.get_attribute("aria-label"), at)
            if slider.get_attribute("aria-label") == "Cell along the beam":
                continue  # the keyboard's: a finger touches the cells themselves
            met += 1
            if met % every == 0:
                assert moves(fingers, slider), (name, slider.get_attribute("aria-label"), value_of(slider))
                driven += 1
        place = section.locator("figure").first.evaluate(_PASSIVE)
        if name != "log" and number % every == 0:
            assert place, name
            before = scrolled(page)
            x, y = place
            fingers.drag(((x, y), (x + 2, y + 200)), steps=5)  # back: the last figure is at the end of the page
            until(f"the page to scroll on {name}", lambda before=before: scrolled(page) < before - 60)  # type: ignore[misc]
            page.evaluate(_STILL)
    assert met > 100
    assert driven == met // every

    # The list of sections, folded on a phone, leads on and folds up again.
    sections = page.get_by_role("navigation", name="Sections of the lecture")
    expect(sections.get_by_role("link", name="One cell")).to_be_hidden()
    sections.get_by_role("button", name="Sections").tap()
    sections.get_by_role("link", name="One cell").tap()
    expect(page.locator("#cell h2")).to_be_in_viewport()
    expect(sections.get_by_role("link", name="One cell")).to_be_hidden()
    expect(sections.get_by_role("button")).to_contain_text("3 One cell")


@pytest.mark.parametrize("section", ["low-table", "sensor-models"])
def test_a_finger_holds_a_handle_that_moves_up_and_down(page: Page, server: str, section: str) -> None:
    """The page does not scroll under the finger, which would take the handle from it."""
    page.emulate_media(reduced_motion="reduce")
    handle = open_section(page, server, section).locator('.handle[data-axis="y"]').first
    handle.evaluate("it => it.scrollIntoView({ block: 'center', behavior: 'instant' })")
    page.evaluate(_STILL)
    page.evaluate("() => addEventListener('pointercancel', () => (window.cancelled = true))")
    x, y = centre(handle.locator(".handle-grab"))
    before = scrolled(page)
    Fingers(page).drag(((x, y), (x, y - 60)))
    page.evaluate(_STILL)
    assert scrolled(page) == before
    assert not page.evaluate("window.cancelled")


# --- the lab ---------------------------------------------------------------------------------------------------------


def on_world(page: Page, xy: list[float]) -> Place:
    """Position of a point of the world on its picture."""
    return place_on(page.locator(".picture").first, xy)


def test_a_finger_draws_erases_and_moves_the_table(page: Page, open_lab: Callable[..., Page]) -> None:
    page.emulate_media(reduced_motion="reduce")
    open_lab("room")
    fingers = Fingers(page)
    page.evaluate("() => gridbloom.connection.store.send({ type: 'teleport', x: 4, y: 5, yaw: 0 })")
    until("the robot to be there", lambda: abs(frame(page)["pose"][1] - 5) < 0.1)
    settled_digest(page)

    def added() -> list[list[object]]:
        return list(page.evaluate("() => gridbloom.connection.store.world.peek().edits.added"))

    open_group(page, "Draw")
    page.get_by_role("button", name="Draw a wall").tap()
    page.locator(".picture").first.scroll_into_view_if_needed()
    before = scrolled(page)
    fingers.drag((on_world(page, [3.0, 4.0]), on_world(page, [3.0, 6.5])))  # upwards: it draws and does not scroll
    until("the wall", lambda: len(added()) == 1)
    assert scrolled(page) == before
    page.get_by_role("button", name="Erase").tap()
    page.touchscreen.tap(*on_world(page, [3.0, 5.2]))
    until("the wall to be gone", lambda: added() == [])

    page.get_by_role("button", name="Move the robot").tap()
    open_group(page, "Moving table")
    page.get_by_role("button", name="Add a table").tap()
    guess = page.get_by_role("slider", name="My guess")
    guess.wait_for()
    assert moves(fingers, guess.element_handle())
    page.get_by_role("button", name="Remove the table").tap()
    expect(page.locator(".table-outcome")).to_contain_text("Your guess:")
