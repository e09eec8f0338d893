"""axe-core finds no violation on any page in any state, no text is hidden; sliders have names and value texts.

``make test`` looks at a wide window in light colours and at a phone in dark ones, at whole pages and the lab in one of
the two, and ``make test-long`` at all pairs.

axe-core is read from node_modules: nothing is downloaded.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from tests.browser.lecturing import set_up_every_figure
from tests.browser.looking import (
    SECONDS,
    await_map,
    await_true,
    frame,
    open_group,
    open_groups,
    settled_digest,
    until,
    without_canvas_in_3d,
)
from tests.browser.text_boxes import hidden_texts
from tests.marks import also_long_rows

AXE = Path(__file__).parents[3] / "static" / "node_modules" / "axe-core" / "axe.min.js"
READY = {
    "/": ".hero canvas",
    "/lecture.html": ".lesson-figure figure",
    "/lecture.html?present": ".own-title.on-slide",  # the first slide; test_slides.py looks at every one
    "/lab.html": ".picture canvas",
    "/logs.html": ".log-card",
    "/puzzles.html": ".puzzles .card",
    "/missing.html": "h1",
}
MODELS = ("step_window", "smooth_ramp", "sonar_cone", "moravec_elfes", "hit_counting", "fixed_increments")

# Sliders on show without a name, without a value in words with its unit, or without a sentence on what they do.
_UNTOLD = """() => [...document.querySelectorAll("[role=slider], input[type=range]")]
  .filter(slider => slider.checkVisibility())
  .map(slider => {
    const name = slider.getAttribute("aria-label") ?? slider.labels?.[0]?.textContent ?? "";
    const sentence = document.getElementById(slider.getAttribute("aria-describedby") ?? "")?.textContent ?? "";
    return { name: name.trim(), value: slider.getAttribute("aria-valuetext") ?? "", sentence: sentence.trim() };
  })"""


# Resolves when colours are what they were going to be: they change by transitions, however short.
_FADED = """async () => {
  for (let i = 0; i < 2; i++) await new Promise(requestAnimationFrame);
  const fading = document.getAnimations().filter(one => one instanceof CSSTransition);
  await Promise.allSettled(fading.map(one => one.finished));
}"""


def violations(page: Page, within: str = "html") -> list[str]:
    """Return what axe-core finds in a part of the page: the rule, and the first elements that break it.

    It is not asked for selectors nor for what passes.
    """
    if not page.evaluate("() => 'axe' in window"):
        page.evaluate(AXE.read_text())
    options = {"resultTypes": ["violations"], "selectors": False}
    found: list[dict[str, Any]] = page.evaluate(
        "async ([within, options]) => (await axe.run(within, options)).violations", [within, options]
    )
    return [
        f"{one['id']} ({one['impact']}): {one['help']}: {[node['html'][:120] for node in one['nodes'][:3]]}"
        for one in found
    ]


def told_sliders(page: Page) -> int:
    """Return how many sliders are on show; all of them have to be told in full."""
    sliders: list[dict[str, str]] = page.evaluate(_UNTOLD)
    for slider in sliders:
        assert slider["name"], slider
        assert slider["value"], slider
        assert slider["sentence"].endswith("."), slider
    return len(sliders)


def nothing_wrong(page: Page, within: str = "html") -> None:
    """Look at the page as it stands, in its fonts."""
    page.evaluate("document.fonts.ready.then(() => true)")
    # What is computed says so over the pictures, and over the divider of a comparison.
    expect(page.locator(".working-place.inside .working")).to_have_count(0)
    page.evaluate(_FADED)
    assert violations(page, within) == []
    assert hidden_texts(page, within) == []


@pytest.fixture
def dressed(page: Page, request: pytest.FixtureRequest) -> Page:
    """Return the page in the colour scheme that an indirect parameter names, without motion."""
    page.emulate_media(color_scheme=request.param)
    return page


LOOKS = (("desktop", "light"), ("phone", "dark"), ("desktop", "dark"), ("phone", "light"))


def each_look(in_make_test: int) -> pytest.MarkDecorator:
    """Run a test in each look; ``make test`` does so in the first ones only."""
    looks = [pytest.param(*look, marks=pytest.mark.long if i >= in_make_test else ()) for i, look in enumerate(LOOKS)]
    return pytest.mark.parametrize(("context", "dressed"), looks, indirect=True)


each_page = pytest.mark.parametrize(
    ("path", "context", "dressed"),
    [
        pytest.param(path, *look, marks=() if i == n % 2 else pytest.mark.long)
        for n, path in enumerate(READY)
        for i, look in enumerate(LOOKS)
    ],
    indirect=["context", "dressed"],
)


@each_page
def test_axe_finds_nothing(dressed: Page, server: str, path: str) -> None:
    page = dressed
    page.goto(server + path)
    page.locator(READY[path]).first.wait_for()
    if path == "/lecture.html":
        set_up_every_figure(page)
        assert told_sliders(page) > 40
    nothing_wrong(page)


@each_look(in_make_test=2)
@pytest.mark.usefixtures("mapped_logs")
def test_the_maps_of_all_logs(dressed: Page, server: str) -> None:
    dressed.goto(f"{server}/fleet.html")
    for state in ("done", "failed"):
        expect(dressed.locator(f".fleet-card.{state}").first).to_be_visible()
    dressed.evaluate("() => { for (const one of document.querySelectorAll('details')) one.open = true; }")
    nothing_wrong(dressed)


@pytest.mark.parametrize(
    ("context", "dressed", "every"),
    [(*LOOKS[0], 10), *also_long_rows(*((*look, 1) for look in LOOKS))],
    indirect=["context", "dressed"],
)
def test_the_lab_in_every_state(dressed: Page, open_lab: Callable[..., Page], every: int) -> None:
    """Axe looks at one group of the dock, and at the curve of one model, in ``every``."""
    page = dressed
    without_canvas_in_3d(page)  # axe does not look into it
    open_lab(scans=15)
    page.evaluate(
        "() => { const { store } = gridbloom.connection; store.explain(store.frame.peek().pose.slice(0, 2)); }"
    )
    expect(page.locator(".why-chart").first).to_be_visible()
    assert told_sliders(page) > 7
    nothing_wrong(page)
    page.keyboard.press("Escape")
    open_group(page, "Faults")
    page.get_by_role("switch", name="Odometry drift").click()
    page.get_by_role("switch", name="Polished walls").click()
    page.get_by_role("switch", name="Show the correct map").click()
    expect(page.locator(".plate .compare-name").first).to_be_visible()
    settled_digest(page)
    for _ in open_groups(page, every):
        told_sliders(page)
        nothing_wrong(page, ".dock")
    panel = open_group(page, "3D map")
    panel.get_by_role("radio", name="TSDF").check()
    expect(panel.get_by_role("slider", name="Truncation").first).to_be_visible()
    assert told_sliders(page) > 5
    nothing_wrong(page, ".dock")
    if page.viewport_size and page.viewport_size["width"] < 500:
        return
    open_group(page, "Sensor model")
    for model in MODELS[(len(MODELS) - 1) % every :: every]:  # up to the last one, whose cells have an order
        page.evaluate("model => gridbloom.connection.store.setParameter('model', model)", model)
        settled_digest(page)
        told_sliders(page)
        nothing_wrong(page, ".lab-curve, .dock")
    open_group(page, "Steps").get_by_text("cell", exact=True).click()
    page.get_by_role("button", name="Forward one cell").click()
    expect(page.locator(".steps-note")).to_be_visible()
    nothing_wrong(page, ".lab")
    open_group(page, "Draw")
    page.get_by_role("button", name="Draw furniture").click()
    nothing_wrong(page, ".lab")
    open_group(page, "Path")
    page.get_by_role("radio", name="Keepout").check()
    nothing_wrong(page, ".lab")
    open_group(page, "Costmap")
    expect(page.locator(".cost-curve")).to_be_visible()
    told_sliders(page)
    nothing_wrong(page, ".lab")
    page.get_by_role("button", name="End the costmap").click()
    page.evaluate("""() => {
      const { store } = gridbloom.connection;
      store.send({ type: "world", name: "room" });
      store.send({ type: "teleport", x: 4, y: 5, yaw: 0 });
    }""")
    await_true(page, "() => gridbloom.connection.store.world.peek().name === 'room'")
    until("the robot to be there", lambda: abs(frame(page)["pose"][1] - 5) < 0.5)
    open_group(page, "Moving table")
    page.get_by_role("button", name="Add a table").click()
    expect(page.get_by_role("slider", name="My guess")).to_be_visible()
    told_sliders(page)
    nothing_wrong(page, ".lab")


@pytest.mark.parametrize(
    ("dressed", "every"), [("dark", 9), *also_long_rows(("dark", 1), ("light", 1))], indirect=["dressed"]
)
def test_the_logs_page_in_every_state(dressed: Page, server: str, every: int) -> None:
    """Axe looks at one group of the dock in ``every``."""
    page = dressed
    without_canvas_in_3d(page)
    facts: dict[str, Any] = dict.fromkeys(("scans", "beams", "duration_s", "format", "time", "mount"))
    facts |= {"has_picture": False, "tags": ["hall"]}
    record = {"bytes": 4_200_000, "progress": 0.0, "error": None, "upside_down": False, "topics": [],
              "trajectories": [], "notes": [], "source": "upload"} | facts  # fmt: skip
    states: list[dict[str, Any]] = [
        {"id": "a", "name": "waits.log", "state": "queued"},
        {"id": "b", "name": "is-read.bag", "state": "reading", "progress": 0.4},
        {"id": "c", "name": "failed.mcap", "state": "failed",
         "error": {"code": "log.storage", "message": "The log could not be kept."}},
    ]  # fmt: skip
    lists = iter([[], [record | state for state in states]])

    def answer(route: Route) -> None:
        found = next(lists)
        body = json.dumps({"logs": found, "total": len(found), "tags": {"hall": 3} if found else {}})
        route.fulfill(status=200, content_type="application/json", body=body)

    page.route("**/api/logs?*", answer, times=2)
    page.goto(f"{server}/logs.html")
    expect(page.locator(".library")).to_contain_text("no logs yet")
    nothing_wrong(page)
    page.reload()
    expect(page.locator(".log-card.failed")).to_contain_text("could not be kept")
    nothing_wrong(page)
    page.reload()
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    await_map(page)
    open_group(page, "Overview")
    doctor = page.get_by_role("region", name="Log doctor")
    expect(doctor).to_contain_text("Poses:", timeout=4 * SECONDS * 1000)
    for _ in open_groups(page, every):
        page.evaluate("() => { for (const one of document.querySelectorAll('details')) one.open = true; }")
        told_sliders(page)
        nothing_wrong(page, ".dock")
    localize = open_group(page, "Localize")
    localize.get_by_role("button", name="Use this map").click()
    localize.get_by_text("At a pose").click()
    expect(localize.get_by_label("heading (°)")).to_be_visible()
    nothing_wrong(page, ".dock")
    open_group(page, "Settings")
    assert told_sliders(page) > 10


def test_axe_would_find_something(page: Page, server: str) -> None:
    page.goto(f"{server}/logs.html")
    page.evaluate("() => { document.body.innerHTML = '<main><button></button></main>'; }")
    assert any("button-name" in one for one in violations(page))


def test_hidden_text_would_be_found(page: Page) -> None:
    field = "<input style='position: absolute; left: 0; top: 0; width: 80px; height: 30px'>"
    page.set_content(f"""<style>div {{ margin: 20px; position: relative; font: 16px/1.5 monospace }}</style>
      <div style="height: 30px"><label>covered</label>{field}</div>
      <div style="height: 30px; overflow: auto"><p style="margin: 60px 0 0">scrolled away</p></div>
      <div style="width: 40px; overflow: hidden; white-space: nowrap">cut in width</div>
      <div style="width: 40px; overflow: hidden; white-space: nowrap; text-overflow: ellipsis">with an ellipsis</div>
      <div style="height: 34px; overflow: hidden">first line<br>second line</div>
      <div style="width: 1px; height: 1px; overflow: hidden; white-space: nowrap">for screen readers</div>
      <div><label style="display: block; width: 40px; white-space: nowrap">too wide a label</label></div>
      <div style="visibility: hidden; width: 10px; overflow: hidden">not shown</div>
      <div><label>beside <input style="width: 80px"></label></div>""")
    found = [one.split('"')[1:] for one in hidden_texts(page, "body")]
    assert [text for text, *_ in found] == ["cut in width", "second line", "too wide a label", "covered"]


def test_a_cell_under_the_cursor_is_spoken_in_its_turn(open_lab: Callable[..., Page]) -> None:
    page = open_lab()
    picture = page.locator(".picture").first
    box = picture.bounding_box()
    assert box is not None
    page.evaluate("""() => {
      window.said = [];
      const voice = document.querySelector(".readout [role=status]");
      const listen = new MutationObserver(() => {
        const words = voice.textContent;
        if (words && words !== said.at(-1)?.[1]) said.push([performance.now(), words]);
      });
      listen.observe(voice, { childList: true, characterData: true, subtree: true });
    }""")
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for i in range(30):  # over many cells: not each of them is said, but the last one is, in full
        page.mouse.move(x + 4 * i, y)
    row, column = page.locator(".readout dd").first, page.locator(".readout dd").nth(1)

    def said() -> str:
        return str(page.evaluate("() => said.at(-1)?.[1] ?? ''"))

    def last() -> str:
        words = said()
        return words if words.startswith(f"Row {row.inner_text()}, column {column.inner_text()}:") else ""

    words = until("the last cell", last)
    assert "never observed" in words or "probability" in words
    picture.focus()
    page.keyboard.press("Shift+ArrowUp")
    until("the next cell", lambda: last() not in ("", words))
    times = page.evaluate("() => said.map(([at]) => at)")
    assert len(times) >= 2
    assert min(later - at for at, later in pairwise(times)) > 300
