"""Cause and effect on one screen: what one uses and the part of the map that it changes are in the viewport together.

Of the lab, the log page, the front page and the maps of all logs, at four sizes. ``make test`` uses every 18th
control of the lab, every fifth one of the log page and every second one of the front page at one of the two sizes with
the least room, in turn, and ``make test-long`` all of them at each size in both colour schemes; that the pictures stay
in place and are not covered, and no text of the dock is hidden, is looked at in every group at each of these sizes.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import await_map, open_group, open_groups, settled_digest, without_canvas_in_3d
from tests.browser.one_screen import SIZES, Screen, Turns
from tests.browser.text_boxes import hidden_texts
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded
from tests.marks import also_long

SCHEMES = ("light", "dark", "light", "dark")  #: of the sizes
Looks = list[tuple[tuple[int, int], str]]
ONE_AFTER_THE_OTHER: Looks = list(zip(SIZES, SCHEMES, strict=True))
LEAST_ROOM: Looks = [ONE_AFTER_THE_OTHER[0], ONE_AFTER_THE_OTHER[3]]  #: the lowest and the narrowest window
each_look = pytest.mark.parametrize(
    "looks",
    [LEAST_ROOM, *also_long(*([(size, scheme)] for size in SIZES for scheme in ("light", "dark")))],
    ids=lambda looks: "least room" if len(looks) > 1 else "-".join(map(str, (*looks[0][0], looks[0][1]))),
)  # fmt: skip

EXPLAIN = "() => { const { store } = gridbloom.connection; store.explain(store.frame.peek().pose.slice(0, 2)); }"
#: The session stands again after the button that starts it: only the control that is used may change the map.
PAUSE = "() => gridbloom.connection.store.send({ type: 'pause' })"
#: How many lines of tabs there are, of the sections and of the open section's groups.
LINES = """() => [".dock-tabs", ".dock-subtabs"].map((list) => new Set([
  ...document.querySelectorAll(`${list} [role=tab]`)
].map((tab) => Math.round(tab.getBoundingClientRect().top))).size)"""
#: What is done in a group that is empty without it.
SHOW_SURFACE = """async () => {
  gridbloom.connection.store.setPart("map3d", { kind: "tsdf" });
  while (!document.querySelector(".surface-panel .tsdf-weight")) await new Promise(requestAnimationFrame);
}"""
BEFORE_GROUP = {"Why": EXPLAIN, "3D map": SHOW_SURFACE}


def turns_at(looks: Looks, every: int = 5) -> Turns:
    """Return whose turn it is: at all of the sizes together one in ``every`` controls, at one of them each one."""
    return Turns(len(looks), every=every if len(looks) > 1 else 1)


def prepare(page: Page) -> None:
    """Have the page be without a canvas in 3D and without SLAM, and stay where it is when its map is to be edited."""
    without_canvas_in_3d(page)  # test_scene.py looks at it
    page.route("**/kept-map", lambda route: route.fulfill(status=201, json={"id": "kept"}))
    # The result of SLAM, which test_heal.py looks at, has its place above other controls and could come at any time:
    # who asks for it is told how far it is, which is not begun.
    page.route("**/api/sessions/*/heal", lambda route: route.continue_(method="GET"))
    # A browser that is answered "no content" stays on its page.
    page.route("**/logs.html?log=kept", lambda route: route.fulfill(status=204))


def use_groups(page: Page, screen: Screen, turns: Turns) -> None:
    """Open each group of the dock and use its controls."""
    for title in open_groups(page):
        assert max(page.evaluate(LINES)) == 1, title
        if title in BEFORE_GROUP:
            page.evaluate(BEFORE_GROUP[title])
            settled_digest(page)
        if title in {"3D", "3D view"}:
            controls = page.locator(".dock-group:visible")  # they come with the scene
            expect(controls.get_by_role("button", name="Controls", exact=True)).to_be_visible()
        screen.stands(title)
        assert hidden_texts(page, ".dock") == [], title
        turns.use_all(screen, page.locator(".dock-group:visible"))
        assert hidden_texts(page, ".dock") == [], (title, "after its controls were used")


@each_look
def test_of_the_lab(page: Page, open_lab: Callable[..., Page], looks: Looks) -> None:
    prepare(page)
    open_lab(scans=15)
    screen = Screen(page, ".lab .picture", ".dock-group")
    turns = turns_at(looks, every=18)
    for size, scheme in looks:
        screen.resize(size, scheme)
        profile = page.locator("figure.profile")
        screen.at_hand(profile.get_by_role("slider"))
        turns.use_all(screen, profile)
        turns.use_all(screen, page.locator(".lab-bar"))
        page.evaluate(PAUSE)
        use_groups(page, screen, turns)
        open_group(page, "Sensor model")
        page.get_by_role("button", name="Reset to defaults").click()
        page.evaluate("() => gridbloom.connection.store.editing.take(null)")
        page.evaluate("() => gridbloom.connection.store.send({ type: 'compare', values: null })")
        turns.sizes_left -= 1
    assert screen.changes > 2


@each_look
def test_of_a_log(page: Page, server: str, tmp_path: Path, looks: Looks) -> None:
    prepare(page)
    camera = image(np.full((48, 64), 200, dtype=np.uint8), "mono8", T0 + recorded.SECOND // 2)
    (tmp_path / "robot.mcap").write_bytes(recorded.mcap_bytes([*robot(3), camera]))
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(tmp_path / "robot.mcap")
    await_map(page)
    expect(page.get_by_role("tab", name="Overview")).to_be_visible()
    screen = Screen(page, ".viewer .picture", ".dock-group, .viewer-transport, .viewer-map")
    turns = turns_at(looks)
    for size, scheme in looks:
        screen.resize(size, scheme)
        box = page.locator(".viewer-map").bounding_box()
        assert box is not None
        assert box["height"] > (0.6 if size[0] >= 1200 else 0.3) * size[1]
        if size[0] >= 1200:
            assert box["width"] == pytest.approx(2 / 3 * size[0], rel=0.08)
        turns.use_all(screen, page.locator(".viewer-transport"))
        page.evaluate(PAUSE)
        use_groups(page, screen, turns)
        turns.sizes_left -= 1
    assert screen.changes > 0


@each_look
def test_of_the_front_page(page: Page, server: str, looks: Looks) -> None:
    page.goto(server)
    await_map(page)
    page.get_by_role("button", name="Forward 10 scans").click()
    screen = Screen(page, ".hero .picture")
    turns = turns_at(looks, every=2)
    for size, scheme in looks:
        screen.resize(size, scheme)
        screen.at_hand(page.locator("figure.profile").get_by_role("slider"))
        turns.use_all(screen, page.locator(".hero"))
        more = page.get_by_role("link", name="One cell, the lecture, your own log")
        expect(more).to_be_in_viewport(ratio=1)
        turns.sizes_left -= 1
    assert screen.changes > 0


@pytest.mark.usefixtures("mapped_logs")
def test_of_the_maps_of_all_logs(page: Page, server: str) -> None:
    for size, scheme in ONE_AFTER_THE_OTHER:
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
        page.goto(f"{server}/fleet.html")
        first = page.locator(".fleet-card").first
        used = page.get_by_role("search").locator("input[type=search], .choice-option, select")
        for choice, shown in (("Failed", "failed"), ("All", "done")):
            page.get_by_role("radio", name=choice, exact=True).check()
            expect(page.locator(f".fleet-card.{shown}").first).to_be_visible()
            for one in (*used.all(), first, page.locator(".fleet-work")):
                expect(one).to_be_in_viewport(ratio=0.99)
            assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth"), size


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_on_a_phone_the_pictures_stay_at_the_top(page: Page, open_lab: Callable[..., Page]) -> None:
    open_lab(scans=15)
    screen = Screen(page, ".lab .picture")
    pictures = page.locator(".lab .picture")
    for name in ("Max range", "Hit increment", "Miss increment"):
        slider = page.locator(".lab-settings input[type=range]").and_(page.get_by_role("slider", name=name))
        slider.focus()
        for one in (*pictures.all(), slider):
            expect(one).to_be_in_viewport(ratio=0.95)
        screen.at_hand(slider)
