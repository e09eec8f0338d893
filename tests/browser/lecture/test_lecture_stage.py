"""The stage of the lecture in Chromium: what it shows on the way, how a reader leaves the way and comes back."""

from __future__ import annotations

import re
from itertools import pairwise

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.lecturing import never_idle, open_lecture
from tests.browser.looking import await_true, centre, drag_along, still
from tests.marks import also_long_rows

# What each place of the lecture makes visible to a reader who only scrolls.
POINTS = {
    "start": r"passed are free, cells in which they ended are occupied",
    "landmarks": r"[1-9]\d* of 22 corners seen, \d+ numbers",
    "grid": r"9,600 cells with a side of 0\.1 m",
    "cell": r"marked cell has ℓ = \+3\.50, which is p = 0\.97",
    "log-odds": r"Each scan only adds to ℓ",
    "model": r"−0\.41 for the cells before the window, \+0\.85 in it",
    "window": r"The wall is thin: 3\.\d cells of 5 cm thick, \d % of it with holes or jumps",
    "endpoint": r"counted from the origin, in cells of 0\.50 m",
    "rays": r"every cell but the last is free",
    "algorithm": r"163 of 600 lie in the perceptual field .* ℓ 0\.00 becomes −0\.40",
    "sonar": r"walls become thick and doors narrow",
    "no-return": r"Max range 3\.0 m\. Ignored",
    "mount": r"rotated by 8°: [1-9]\d+ occupied cells where no wall is",
    "forgetting": r"taken away 4 scans ago, and the map still shows it",
    "counting": r"one scan counts many times",
    "resolution": r"cells of 10 cm",
    "polished": r"shows only the part that the robot has faced",
    "people": r"[1-9]\d* cells of the trail are in the map",
    "low-table": r"calls its place free, and the robot would drive into it",
    "odometry": r"drifts 0\.15° per scan; [1-9]\d+ occupied cells of doubled walls",
    "probable": r"end points lie beside the walls",
    "matching": r"end points lie on the walls",
    "graph": r"each wall is drawn once",
    "file": r"[1-9]\d* cells occupied, [\d,]+ free, the others unknown",
    "particles": r"4,000 poses, .* effective number is \d+:",
    "sensor-models": r"Here log p\(z \| x, m\) = −52\.\d, at the ring log p\(z \| x, m\) = −19",
    "kidnapping": r"carried away 4 scans ago\. 0 % of the belief",
    "layers": r"Under the cross: cost 1\d\d\.",
    "inflation": r"In the middle of the right door: \d+\. Drag",
    "path": r"[\d,]+ cells expanded; .* 14\.8 m long",
    "lifetime": r"12 seconds ago\. 3\d lethal cells of it are in the obstacle layer, and the path is 1\.2\d m longer",
    "stack": r"Nav2: a path of \d\.\d m",
    "octree": r"At 0\.45 m above the floor .* low table is not in this plane",
    "tsdf": r"Where in its cell the wall is",
    "terrain": r"each patch gets a plane",
    "next": r"77 scans with 240 readings each",
}

# Scrolls so that the place of a scene is just above the reading line.
TO_SCENE = """name => {
  const place = [...document.querySelectorAll("[data-scene]")].find(one => one.dataset.scene === name);
  const stage = document.querySelector(".lecture-stage").getBoundingClientRect();
  const top = stage.width > 0.7 * innerWidth ? stage.bottom : 60;
  scrollTo({ top: scrollY + place.getBoundingClientRect().top - top - 20, behavior: "instant" });
}"""


# Whether the stage is beside the heading of a section, or a strip above it that does not cover it.
_BOXES = """name => {
  const heading = document.querySelector(`#${name} h2`).getBoundingClientRect();
  const stage = document.querySelector(".lecture-stage").getBoundingClientRect();
  """
BESIDE = _BOXES + "return heading.right <= stage.left + 1; }"
ABOVE = _BOXES + "return stage.height < 0.45 * innerHeight && heading.top >= stage.bottom - 1; }"


def stage_of(page: Page) -> Locator:
    return page.get_by_role("complementary", name="Stage")


def to_scene(page: Page, name: str) -> None:
    """Scroll to a scene until the stage shows it: figures above may still take their places."""
    stage = stage_of(page)
    for _ in range(20):
        page.evaluate(TO_SCENE, name)
        try:
            expect(stage).to_have_attribute("data-shown", name, timeout=1500)
        except AssertionError:
            continue
        return
    expect(stage).to_have_attribute("data-shown", name)


@pytest.mark.parametrize(
    ("context", "every"),
    [("desktop", 8), ("phone", 16), *also_long_rows(("desktop", 1), ("phone", 1))],
    indirect=["context"],
)
def test_who_only_scrolls_sees_the_point_of_each_section(page: Page, server: str, every: int) -> None:
    """The reader stops at one scene in ``every``."""
    never_idle(page)
    open_lecture(page, server)
    stage = stage_of(page)
    caption = stage.locator(".world-stage-caption > p").first
    expect(caption).to_have_text(re.compile(POINTS["start"]))
    names = page.locator("[data-scene]").evaluate_all("all => all.map(one => one.dataset.scene)")
    assert set(names) == POINTS.keys() - {"start"}
    wide = page.viewport_size is not None and page.viewport_size["width"] > 1200
    for name in names[::every]:
        to_scene(page, name)
        expect(caption).to_have_text(re.compile(POINTS[name]))
        expect(stage.locator("canvas")).to_be_in_viewport(ratio=0.9)
        await_true(page, BESIDE if wide else ABOVE, arg=name)
    assert page.get_by_role("button", name="Back to the lecture’s path").count() == 0


@pytest.mark.moving
def test_the_view_goes_from_the_floor_to_one_cell_without_a_jump(page: Page, server: str) -> None:
    never_idle(page)
    open_lecture(page, server)
    to_scene(page, "grid")
    still(stage_of(page).get_by_role("slider", name="Robot"))
    # The side of the selected cell on the screen, at every frame of the way.
    page.evaluate("""() => {
      window.sides = [];
      const look = () => {
        const side = document.querySelector(".lecture-stage .world-stage-selected")?.getBoundingClientRect().width;
        if (side) sides.push(side);
        requestAnimationFrame(look);
      };
      look();
    }""")
    to_scene(page, "cell")
    still(stage_of(page).get_by_role("slider", name="Selected cell"))
    sides = page.evaluate("sides")
    assert sides[0] < 30
    assert sides[-1] > 100
    assert all(later >= earlier - 1 for earlier, later in pairwise(sides))
    assert len({round(side) for side in sides}) > 4


def test_a_reader_leaves_the_path_and_comes_back_with_one_click(page: Page, server: str) -> None:
    never_idle(page)
    open_lecture(page, server)
    stage = stage_of(page)
    robot = stage.get_by_role("slider", name="Robot")
    back = stage.get_by_role("button", name="Back to the lecture’s path")
    first = robot.get_attribute("aria-valuetext")
    robot.focus()
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    moved = robot.get_attribute("aria-valuetext")
    assert moved != first
    expect(back).to_be_visible()
    # The mouse moves it too, and what was done stays from section to section.
    x, y = centre(robot)
    drag_along(page, (x, y), (x + 30, y), steps=4)
    assert robot.get_attribute("aria-valuetext") != moved
    moved = robot.get_attribute("aria-valuetext")
    hit = page.get_by_role("slider", name="evidence of a hit")
    hit.focus()
    page.keyboard.press("End")
    to_scene(page, "forgetting")
    assert robot.get_attribute("aria-valuetext") == moved
    ladder = stage.locator(".world-stage-ladder-name")
    expect(ladder).not_to_contain_text("after 66 scans")  # those of the robot's new way are added
    back.click()
    expect(back).to_have_count(0)
    expect(hit).to_have_attribute("aria-valuenow", "0.85")
    assert robot.get_attribute("aria-valuetext") != moved
    expect(ladder).to_contain_text("after 66 scans")


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_the_way_back_leaves_the_caption_its_room_on_a_phone(page: Page, server: str) -> None:
    never_idle(page)
    open_lecture(page, server)
    stage = stage_of(page)
    stage.get_by_role("slider", name="Robot").focus()
    page.keyboard.press("ArrowDown")
    expect(stage.get_by_role("button", name="Back to the lecture’s path")).to_be_visible()
    caption = stage.locator(".world-stage-caption > p").first
    for name in ("sensor-models", "octree"):  # the longest captions
        to_scene(page, name)
        expect(caption).to_have_text(re.compile(POINTS[name]))
        assert caption.evaluate("it => it.scrollHeight <= it.clientHeight + 1")


def test_what_a_hand_sets_in_the_text_changes_the_stage(page: Page, server: str) -> None:
    never_idle(page)
    open_lecture(page, server)
    caption = stage_of(page).locator(".world-stage-caption > p").first
    to_scene(page, "window")
    for look in ("broken", "thick", "thin"):
        page.locator("#window").get_by_role("button", name=look).click()
        expect(caption).to_contain_text(f"The wall is {look}")
    to_scene(page, "polished")
    page.get_by_role("switch", name="polished wall").press("Space")
    expect(caption).to_contain_text("all of it is mapped")
    to_scene(page, "people")
    page.get_by_role("switch", name="someone walks").press("Space")
    expect(caption).to_contain_text("Nobody walks")
    to_scene(page, "low-table")
    laser = page.get_by_role("slider", name="Laser height")
    laser.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("ArrowDown")
    expect(laser).to_have_attribute("aria-valuetext", "0.35 m")
    expect(caption).to_contain_text("cuts the low table")
    to_scene(page, "algorithm")
    page.get_by_role("button", name="Next row").click()
    expect(page.locator("#algorithm .lit")).to_have_count(3)  # a cell at the left border: outside the field
    to_scene(page, "endpoint")
    steps = page.locator(".endpoint-steps dd")
    expect(steps.nth(2)).to_contain_text("= 12")
    origin = stage_of(page).get_by_role("slider", name="Origin of the grid")
    origin.focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    expect(origin).to_have_attribute("aria-valuetext", "0.70 m, 0.20 m")
    expect(steps.nth(2)).to_contain_text("(6.556 − 0.70) / 0.5) = floor(11.71) = 11")


def test_slides_and_paper_contain_the_pictures_of_the_stage(page: Page, server: str) -> None:
    page.goto(f"{server}/lecture.html?present#window/3")
    expect(page.locator(".on-slide .world-stage canvas")).to_be_in_viewport()
    page.locator(".on-slide").get_by_role("button", name="broken").click()
    expect(page.locator(".on-slide .world-stage-caption")).to_contain_text("The wall is broken")
    page.add_init_script("""addEventListener("afterprint", () => {
      const painted = canvas => canvas.getContext("2d")
        .getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data[3] === 255;
      window.printed = [...document.querySelectorAll(".on-stage")].map(figure =>
        [...figure.querySelectorAll(".world-stage.still canvas")].filter(painted).length);
    })""")
    open_lecture(page, server)
    expect(stage_of(page).locator("canvas")).to_be_visible()
    page.pdf()
    printed = page.evaluate("printed")
    assert len(printed) >= 10
    assert set(printed) == {1}
    page.emulate_media(media="print")
    expect(stage_of(page)).to_be_hidden()


def test_on_a_wide_screen_a_figure_stays_beside_its_text(page: Page, server: str) -> None:
    page.set_viewport_size({"width": 1920, "height": 1080})
    page.goto(f"{server}/lecture.html#cell")
    section = page.locator("#cell")
    title, text, figure = (section.locator(one).first for one in ("h2", ".prose", ".lesson-figure"))
    for part in (title, text, figure, page.get_by_label("Stage", exact=True)):
        expect(part).to_be_in_viewport(ratio=1)
    beside, words = figure.bounding_box(), text.bounding_box()
    assert beside is not None
    assert words is not None
    assert beside["x"] >= words["x"] + words["width"]
    page.mouse.move(words["x"] + 9, words["y"] + 9)
    page.mouse.wheel(0, 600)
    expect(title).not_to_be_in_viewport()
    expect(figure).to_be_in_viewport(ratio=1)
