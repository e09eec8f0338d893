"""What visitors do, in Firefox and WebKit: each story is written once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from tests.browser.conftest import SEED
from tests.browser.drifting import drifting_ring
from tests.browser.engines.tab import PHONE, Tab
from tests.browser.logs.test_map_editing import written
from tests.browser.looking import SECONDS, until
from tests.server.service import Service

pytestmark = pytest.mark.long

STORE = "gridbloom.connection.store"
_OBSERVED = "() => Object.values(gridbloom.cells()).reduce((a, b) => a + b, 0)"
# A wall cell away from the robot, seen from so near that a click cannot miss it.
_WALL = """() => {
  const { store } = gridbloom.connection;
  const { geometry, cells } = store.map.peek();
  const [x, y] = store.frame.peek().pose;
  let best = null;
  for (let row = 0; row < geometry.rows; row++)
    for (let col = 0; col < geometry.cols; col++) {
      const xy = [0, 1].map((k) => geometry.origin[k] + ([col, row][k] + 0.5) * geometry.resolution);
      const byte = cells.at(row, col);
      if (Math.hypot(xy[0] - x, xy[1] - y) > 0.6 && !(best?.byte >= byte)) best = { byte, xy };
    }
  store.setView({ x: best.xy[0], y: best.xy[1], scale: 0.005 });
  return best.xy;
}"""


def place(tab: Tab, xy: list[float], nth: int = 0) -> tuple[float, float]:
    """Return where a place of the map lies in the window, on a picture of it."""
    tab.run("(nth) => document.querySelectorAll('.picture')[nth].scrollIntoView({ behavior: 'instant' })", nth)
    x, y = tab.until("(xy) => gridbloom.screen(xy)", xy)
    left, top, _, _ = tab.box(".picture", nth)
    return left + x, top + y


def far_end(tab: Tab) -> list[float]:
    """Return a place on the other side of the world than the robot."""
    x0, y0, x1, _ = tab.run(f"() => {STORE}.world.peek().bounds")
    x = tab.run(f"() => {STORE}.frame.peek().pose[0]")
    return [x1 - 2.5 if x < (x0 + x1) / 2 else x0 + 2.5, y0 + 2.5]


def await_robot(tab: Tab, xy: list[float], within: float = 2.0) -> None:
    """Wait until the robot is near a place: it may go on from there."""
    tab.until(
        f"([x, y], within) => {{ const [px, py] = {STORE}.frame.peek().pose;"
        " return Math.hypot(px - x, py - y) < within; }",
        xy,
        within,
    )


def standing_lab(tab: Tab, world: str = "office") -> None:
    """Open the lab on a world that stands still."""
    tab.open("/missing.html")
    wanted = {"kind": "simulation", "world": world, "seed": SEED, "playing": False, "story": {"steps": 225}}
    session = tab.run(
        """async (wanted) => (await (await fetch("/api/sessions", {
          method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(wanted),
        })).json()).id""",
        wanted,
    )
    tab.open(f"/lab.html?session={session}")
    tab.await_map()
    tab.shows("figure.profile")


def on_a_phone(tab: Tab) -> None:
    """The page as it stands fits a phone, and axe finds nothing on it."""
    tab.driver.resize(*PHONE)
    tab.fits()
    assert tab.violations() == []


def test_the_front_page(tab: Tab) -> None:
    tab.open("/")
    tab.await_map()
    to, before = far_end(tab), tab.run(_OBSERVED)
    tab.click_at(*place(tab, to))
    await_robot(tab, to)
    tab.until(f"(before) => ({_OBSERVED})() > before + 100", before)
    # The handle of the curve changes the parameter, and with it the map.
    handle = '.hero-curve [role=slider][aria-label="Max range"]'
    value = f"(css) => Number(document.querySelector('{handle}').getAttribute('aria-valuenow'))"
    range_max = tab.run(value, handle)
    tab.drag(f"{handle} .handle-grab", -120, 0)
    tab.until(f"(before) => ({value})() < before", range_max)
    tab.until(f"(before) => {STORE}.mapping.values.peek()?.range_max < before", range_max)
    tab.until("() => gridbloom.connection.store.map.peek().geometry.epoch > 0")
    on_a_phone(tab)


def test_the_lab(tab: Tab) -> None:
    standing_lab(tab)
    tab.open_group("Map")
    before = tab.run(f"() => {STORE}.mapping.values.peek().resolution")
    tab.click("[role=tabpanel] input[type=range]", "Resolution")
    tab.until(f"(before) => {STORE}.map.peek().geometry.resolution !== before", before)
    tab.press("Control", "z")
    tab.until(f"(before) => {STORE}.map.peek().geometry.resolution === before", before)
    # Why a cell is as it is.
    xy = tab.run(_WALL)
    tab.until(f"(xy) => {STORE}.view.peek().scale === 0.005 && gridbloom.screen(xy) !== null", xy)
    tab.click_at(*place(tab, xy, 1), "Shift")
    tab.until(f"() => {STORE}.why.peek() !== null")
    tab.shows("[role=tabpanel] h3, [role=tabpanel] h2", "Why…")
    # 3D: viser's client connects and draws, or a sentence says why it cannot.
    tab.open_group("3D view")
    inside = "document.querySelector('iframe.scene')?.contentDocument"
    if tab.driver.name == "firefox":
        tab.until(f"() => {inside}?.body?.innerText.includes('does not offer WebGL')")
    else:
        tab.until(f"() => [...({inside}?.querySelectorAll('canvas') ?? [])].some((one) => one.width > 100)")
    on_a_phone(tab)


def test_the_lecture(tab: Tab) -> None:
    tab.open("/lecture.html#cell")
    tab.shows("#cell figcaption")
    tab.click("#cell button", "Reset the cell")
    tab.says("#cell figcaption", "ℓ = 0.00")
    tab.press("h")
    tab.says("#cell figcaption", "ℓ = 0.85")
    tab.open("/lecture.html#grid")
    number = '#grid [role=slider][aria-label="prior of a cell"]'
    before = tab.text(number)
    tab.drag(number, 60, 0)
    tab.until("(css, before) => document.querySelector(css).innerText !== before", number, before)
    # A section is reached by the keys of its link in the contents.
    tab.click("nav[aria-label='Sections of the lecture'] button")
    tab.shows("nav a[href$='#sonar']")
    tab.run("() => document.querySelector(\"nav[aria-label='Sections of the lecture'] a[href$='#sonar']\").focus()")
    tab.press("Enter")
    tab.until(
        "() => location.hash === '#sonar'"
        " && Math.abs(document.querySelector('#sonar').getBoundingClientRect().top) < 200"
    )
    tab.click("button", "Presentation mode")
    tab.shows(".presenter-number")
    tab.press("Home")
    tab.says(".presenter-number", "1 /")
    for _ in range(3):
        tab.press("PageDown")
    tab.until("() => location.hash.length > 1")
    tab.press("Escape")
    tab.shows(".presenter", n=0)
    on_a_phone(tab)


def test_a_log(tab: Tab, tmp_path: Path) -> None:
    log = tmp_path / "ring.log"
    log.write_bytes(drifting_ring())
    tab.open("/logs.html")
    tab.choose_files("input[type=file]", [log])
    tab.await_map()
    playing, index = f"{STORE}.frame.peek().playing", f"{STORE}.frame.peek().index"
    timeline = "[role=slider][aria-label='Scans in the map']"
    tab.until("(css) => { document.querySelector(css).focus(); return true; }", timeline)
    tab.press("End")
    tab.until(f"() => {index} === {STORE}.frame.peek().count && !{playing}")
    tab.press("Home")
    tab.until(f"() => {index} < 5")
    tab.click("button", "Play")
    tab.until(f"() => {index} > 20")
    tab.run("(css) => document.querySelector(css).focus()", timeline)
    tab.press("End")
    tab.until(f"() => {index} === {STORE}.frame.peek().count")
    xy = tab.run(_WALL)
    tab.until("(xy) => gridbloom.screen(xy) !== null", xy)
    tab.click_at(*place(tab, xy), "Shift")
    tab.until(f"() => {STORE}.why.peek() !== null")
    tab.click(".correction-offer button", "Heal its poses")
    until(
        "the log to be healed",
        lambda: (
            "Healed" in tab.text("section[aria-label='Heal its poses'], [role=region][aria-label='Heal its poses']")
        ),
        5 * SECONDS,
    )
    on_a_phone(tab)


@pytest.fixture
def lecturer(browser: Browser, service: Service) -> Any:
    """The page of a lecturer in Chromium."""
    context = browser.new_context(viewport={"width": 1440, "height": 900}, reduced_motion="reduce")
    context.set_default_timeout(SECONDS * 1000)
    yield context.new_page()
    context.close()


def test_a_class_that_is_led_in_chromium(tab: Tab, lecturer: Page, service: Service) -> None:
    lecturer.goto(f"{tab.server}/logs.html")
    lecturer.get_by_role("button", name="Class", exact=True).click()
    code = lecturer.locator(".class-code-small").text_content() or ""
    lecturer.get_by_role("dialog").get_by_role("button", name="Close").click()
    tab.open("/join")
    tab.click("input")
    tab.type(code)
    tab.press("Enter")
    tab.shows("h1, h2", "You are in the class…")
    lecturer.get_by_role("button", name="Ask", exact=True).click()
    form = lecturer.get_by_role("dialog", name="Ask the class")
    form.get_by_role("textbox", name="Question").fill("Is the door open?")
    form.get_by_role("button", name="Ask", exact=True).click()
    tab.click("button", "A Yes…")
    lecturer.get_by_text("1 of 1 answered").wait_for()
    lecturer.get_by_role("button", name="Show the result").click()
    tab.says("main, aside, [role=complementary]", "1 answered")
    lecturer.get_by_role("button", name="Remove the question").click()
    # Into the lab, and there with a world of one's own.
    session = service.begin(kind="simulation", world="office", seed=SEED, playing=False, story={"steps": 225})
    lecturer.goto(f"{tab.server}/lab.html?session={session}")
    tab.await_map()
    lecturer.evaluate("() => { gridbloom.connection.store.pinned.value = [3.5, 2.5]; }")
    tab.until(f"() => {STORE}.pinned.peek()?.[0] === 3.5")
    scans = tab.run(f"() => {STORE}.frame.peek().count")
    tab.click("button", "Try it yourself")
    tab.shows("button", "Back to the class")
    tab.await_map()
    tab.click("button", "Play")
    tab.until(f"(scans) => {STORE}.frame.peek()?.count > scans", scans)
    assert lecturer.evaluate(f"() => {STORE}.frame.peek().count") == scans
    on_a_phone(tab)


def test_a_map_is_edited(tab: Tab, tmp_path: Path) -> None:
    tab.open("/logs.html")
    tab.choose_files("input[type=file]", written(tmp_path))
    edits = f"{STORE}.part('map_edits').message.peek()"
    tab.until(f"() => window.gridbloom && {edits} && {STORE}.map.peek()")
    state = (
        f"(xy) => {{ {STORE}.pinned.value = xy; return document.querySelector('[data-state]')?.dataset.state ?? ''; }}"
    )
    tab.click("label", "Brush")
    tab.drag_at(*(place(tab, [x, 3.05]) for x in (2.0, 4.0, 6.0)))
    tab.until(f"() => {edits}.n === 1")
    tab.until(f"(xy) => ({state})(xy) === 'occupied'", [4.05, 3.05])
    tab.press("Control", "z")
    tab.until(f"(xy) => ({state})(xy) === 'free'", [4.05, 3.05])
    tab.click("button", "Redo…")
    tab.until(f"(xy) => ({state})(xy) === 'occupied'", [4.05, 3.05])
    on_a_phone(tab)


def test_a_puzzle_is_solved(tab: Tab) -> None:
    tab.open("/puzzles.html")
    tab.click("button", "Open The closed doors")
    tab.await_map()
    tab.says(".case-score", "0 of 100 points")
    tab.click("label", "The cells are too large")
    tab.click("button", "This is the cause")
    tab.run(f"() => {STORE}.setParameter('resolution', 0.05)")
    tab.until(f"() => {STORE}.map.peek()?.geometry.resolution === 0.05")
    tab.click("button", "Check the map")
    tab.shows("h2, h3", "Solved:…")
    on_a_phone(tab)
