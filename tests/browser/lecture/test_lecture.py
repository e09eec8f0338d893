"""The lecture as a page in Chromium: opened, presented, printed, and its link to the log page."""

from __future__ import annotations

import re
from itertools import product

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.browser.lecturing import never_idle, open_lecture, set_up_every_figure
from tests.browser.looking import await_true, until
from tests.browser.slides import cut_labels
from tests.browser.stillness import AWAITED, FOUND, HOLD, JUMP, LET_GO, OFF, STILL_WITHIN, WATCH
from tests.browser.visits import SIZES
from tests.marks import also_long_rows

# On a phone innerWidth grows with a page that is too wide, clientWidth does not.
NARROW = "() => document.documentElement.scrollWidth <= document.documentElement.clientWidth + 1"
# Whether all that a section holds lies within the window.
WITHIN = """section => Math.max(...[...section.querySelectorAll(":not(svg *)")].map(
  one => one.getBoundingClientRect().right)) <= innerWidth + 1"""

# The sections of tables that reach out of the section and do not scroll by themselves.
TABLES_OUT = """() => [...document.querySelectorAll(".lesson table")].filter(table => {
  let room = table;
  while (room.parentElement && getComputedStyle(room).overflowX !== "auto") room = room.parentElement;
  const seen = Math.min(table.getBoundingClientRect().right, room.getBoundingClientRect().right);
  return seen > table.closest(".lesson").getBoundingClientRect().right + 1;
}).map(table => table.closest(".lesson").id)"""

#: Waits until the page has not scrolled for ten frames.
STANDS = """async () => {
  for (let y = scrollY, still = 0; still < 10; still = y === scrollY ? still + 1 : 0, y = scrollY)
    await new Promise(requestAnimationFrame);
}"""

#: A size and a colour scheme: `make test` opens the lecture in one pair, `make test-long` in all others.
LOOKS = [
    pytest.param(*look, marks=() if look == ("phone", "light") else pytest.mark.long)
    for look in product(SIZES, ("light", "dark"))
]


@pytest.mark.parametrize(("context", "scheme"), LOOKS, indirect=["context"])
def test_the_lecture_opens_completely(page: Page, server: str, scheme) -> None:
    page.emulate_media(color_scheme=scheme)  # most of the time would go to drawing
    never_idle(page)
    open_lecture(page, server)
    sections = page.locator(".lesson")
    expect(page.locator(".figure-awaited")).not_to_have_count(0)  # figures far from the window are not set up yet
    for i in range(sections.count()):
        section = sections.nth(i)
        section.scroll_into_view_if_needed()
        expect(section.locator("figure, .dropzone")).not_to_have_count(0)
        # Canvases take their size in the frame after they were set up.
        await_true(page, NARROW)
        await_true(page, WITHIN, arg=section.element_handle())
    expect(page.locator(".figure-awaited")).to_have_count(0)


#: A window, the size of text in percent of the usual one, and whether the page's fonts come.
@pytest.mark.parametrize(
    ("width", "height", "text", "fonts"),
    [
        (901, 800, 200, True),
        (1537, 900, 100, False),
        *also_long_rows(
            (390, 844, 100, True), (390, 844, 200, False), (1111, 700, 100, True), (1440, 900, 200, True),
            (1920, 1080, 100, True),
        ),
    ],
)  # fmt: skip
def test_nothing_in_view_moves_while_the_page_fills(
    context: BrowserContext, server: str, width: int, height: int, text: int, fonts: bool
) -> None:
    page = context.new_page()
    page.set_viewport_size({"width": width, "height": height})
    page.add_init_script(
        f"addEventListener('DOMContentLoaded', () => {{ document.documentElement.style.fontSize = '{text}%'; }});"
        f"({HOLD})()"
    )
    if not fonts:
        page.route("**/*.woff2", lambda route: route.abort())
    page.goto(f"{server}/lecture.html#terrain")

    def is_at(section: str) -> bool:
        return bool(abs(page.evaluate(OFF, section)) <= STILL_WITHIN)

    expect(page.locator("#next")).to_be_attached()  # the sections whose code comes later are there
    until("the section of the address", lambda: is_at("terrain"))
    for section in ("rays", "lifetime", "mount"):
        page.evaluate(JUMP, section)
        page.evaluate(WATCH)
        assert is_at(section), section
    assert page.evaluate(AWAITED) > 15
    page.evaluate(LET_GO)
    expect(page.locator(".figure-awaited")).to_have_count(0)
    page.evaluate("() => new Promise(requestAnimationFrame)")
    seen, moved = page.evaluate(FOUND)
    assert seen > 1
    assert moved == []
    assert is_at("mount")


@pytest.mark.parametrize(("width", "height"), [(1440, 900), *also_long_rows((390, 844))])
def test_figures_are_enlarged_with_the_text(page: Page, server: str, width: int, height: int) -> None:
    page.set_viewport_size({"width": width, "height": height})
    open_lecture(page, server)
    set_up_every_figure(page)
    drawn = page.locator("#model .profile-svg").bounding_box()
    page.evaluate("document.documentElement.style.fontSize = '200%'")
    curve = page.locator("#model .profile-svg")
    until("a figure for larger text", lambda: curve.evaluate("one => one.currentCSSZoom") > 1)
    box = curve.bounding_box()
    assert box is not None
    assert drawn is not None
    assert box["height"] > drawn["height"]
    assert box["width"] <= drawn["width"] + 1
    assert cut_labels(page, ".lesson") == []
    assert page.locator(".lesson table").count() >= 9
    assert page.evaluate(TABLES_OUT) == []


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_text_of_twice_the_size_fits_a_phone(page: Page, server: str) -> None:
    sizes = {"standard": 32, "fixed": 26}
    page.context.new_cdp_session(page).send("Page.setFontSizes", {"fontSizes": sizes})
    open_lecture(page, server)
    assert page.evaluate("matchMedia('(max-width: 20rem)').matches")
    set_up_every_figure(page)
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390


@pytest.mark.moving
def test_the_page_is_read_by_wheel_and_keys(page: Page, server: str) -> None:
    page.add_init_script(
        "window.moved = 0; new PerformanceObserver(list => {"
        " for (const shift of list.getEntries()) window.moved += shift.value;"
        "}).observe({ type: 'layout-shift', buffered: true });"
    )
    page.goto(f"{server}/lecture.html#sonar")
    # The figures around it come, and then all others, without anybody going there.
    expect(page.locator("#next")).to_be_attached()
    expect(page.locator(".figure-awaited")).to_have_count(0)
    assert abs(page.evaluate(OFF, "sonar")) <= STILL_WITHIN
    # The section in sight is marked in the list beside the lecture, and another one is a key press away.
    sections = page.get_by_role("navigation", name="Sections of the lecture")
    expect(sections.locator("[aria-current]")).to_have_text(re.compile(r"\d+\s+Sonar cones"))
    page.mouse.move(700, 500)
    for way in (-700, 700):
        for _ in range(30):
            page.mouse.wheel(0, way)
            page.evaluate("() => new Promise(requestAnimationFrame)")
    page.evaluate(STANDS)  # the last turn of the wheel may be carried out later than it is sent
    assert page.evaluate("window.moved") < 0.02
    page.evaluate(JUMP, "terrain")
    assert abs(page.evaluate(OFF, "terrain")) <= STILL_WITHIN
    sections.get_by_role("button").click()
    sections.get_by_role("link", name="Rays on a grid").focus()
    page.keyboard.press("Enter")
    expect(sections.locator("[aria-current]")).to_have_text(re.compile("Rays on a grid"))
    until("the section of the list", lambda: abs(page.evaluate(OFF, "rays")) <= STILL_WITHIN)


# --- your own log ----------------------------------------------------------------------------------------------------


def test_printed_it_shows_every_figure_in_light_colours_without_controls(page: Page, server: str) -> None:
    page.emulate_media(color_scheme="dark")
    # What there is when the printer takes its picture: figures that are set up, and canvases with light paint on them.
    page.add_init_script("""addEventListener("afterprint", () => {
      const light = canvas => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return data.reduce((sum, value) => sum + value, 0) / data.length > 128;
      };
      const canvases = [...document.querySelectorAll(".stage canvas")];
      window.printed = {
        figures: document.querySelectorAll(".lesson:has(.lesson-figure figure)").length,
        canvases: canvases.length,
        light: canvases.filter(light).length,
        unfinished: document.querySelectorAll(".drift [data-awaited], .matching [data-awaited]").length,
      };
    })""")
    open_lecture(page, server)
    expect(page.locator("#grid figure")).to_be_visible()
    page.pdf()
    printed = page.evaluate("printed")
    assert printed["figures"] == page.locator(".lesson").count()
    assert printed["light"] == printed["canvases"] >= 14
    assert printed["unfinished"] == 0  # also of figures that were never in view
    expect(page.locator("html")).not_to_have_attribute("data-theme", "light")
    # All that is seen once every figure is set up, with tables, captions, labels and formulas: few enough to be read.
    words = [word for word in page.locator("main").inner_text().split() if any(map(str.isalnum, word))]
    assert 7000 < len(words) <= 8500
    page.emulate_media(media="print")
    # Nobody drags paper; this reads what the print shows.
    asks = r"\b(?:[Dd]rag|[Pp]ress|[Cc]lick|[Tt]ap|Switch|Move the|Choose|Guess|Step on) [^.]*\."
    asked = re.findall(asks, page.locator("main").inner_text())
    assert asked == []
    expect(page.locator(".section-list")).to_be_hidden()
    expect(page.locator("#rays .stage")).to_be_visible()
    expect(page.locator("#rays .rays-controls")).to_be_hidden()
    expect(page.locator("#cell .cell-buttons")).to_be_hidden()
