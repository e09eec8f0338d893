"""The lecture as a page in Chromium: opened, presented, printed, and its link to the log page."""

from __future__ import annotations

import re
from itertools import product

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import SIZES
from tests.browser.lecturing import never_idle
from tests.browser.looking import await_true, until

# On a phone innerWidth grows with a page that is too wide, clientWidth does not.
NARROW = "() => document.documentElement.scrollWidth <= document.documentElement.clientWidth + 1"
# Whether all that a section holds lies within the window.
WITHIN = """section => Math.max(...[...section.querySelectorAll(":not(svg *)")].map(
  one => one.getBoundingClientRect().right)) <= innerWidth + 1"""

# Of each section: whether its figure is still awaited, and the height that it takes.
PLACES = """() => [...document.querySelectorAll(".lesson-figure > div")].map(
  place => [place.classList.contains("figure-awaited"), place.offsetHeight])"""

# Of each section whose figure takes another height than the one that was reserved for it at this width: both.
MISPLACED = """() => [...document.querySelectorAll(".lesson")].flatMap(section => {
  const place = section.querySelector(".lesson-figure > div");
  const reserved = parseFloat(getComputedStyle(place).getPropertyValue("--reserved"));
  return Math.abs(place.offsetHeight - reserved) <= 40 ? [] : [[section.id, reserved, place.offsetHeight]];
})"""


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
    page.goto(f"{server}/lecture.html")
    sections = page.locator(".lesson")
    expect(sections.first).to_be_visible()
    # Figures far from the window are not set up yet; the place that is kept for them is as high as they will be.
    expect(page.locator(".figure-awaited")).not_to_have_count(0)
    kept = page.evaluate(PLACES)
    assert sum(waits for waits, _ in kept) >= 10
    for i in range(sections.count()):
        section = sections.nth(i)
        section.scroll_into_view_if_needed()
        expect(section.locator("figure, .dropzone")).not_to_have_count(0)
        # Canvases take their size in the frame after they were set up.
        await_true(page, NARROW)
        await_true(page, WITHIN, arg=section.element_handle())
    expect(page.locator(".figure-awaited")).to_have_count(0)

    def moved() -> list[tuple[int, int]]:
        heights = zip((height for _, height in kept), (height for _, height in page.evaluate(PLACES)), strict=True)
        return [(before, after) for before, after in heights if abs(after - before) > 40]

    until("the figures to be as high as their places", lambda: not moved())


@pytest.mark.moving
def test_the_page_does_not_jump_while_it_fills(page: Page, server: str) -> None:
    page.add_init_script(
        "window.moved = 0; new PerformanceObserver(list => {"
        " for (const shift of list.getEntries()) window.moved += shift.value;"
        "}).observe({ type: 'layout-shift', buffered: true });"
    )
    page.goto(f"{server}/lecture.html#sonar")
    section = page.locator("#sonar")
    expect(section).to_be_in_viewport()
    # The figures around it come, and then all others, without anybody going there. The anchor is where it belongs.
    expect(page.locator(".figure-awaited")).to_have_count(0)
    at = "e => e.getBoundingClientRect().top - parseFloat(getComputedStyle(e).scrollMarginTop)"
    until("the section at the top", lambda: abs(section.evaluate(at)) < 2)
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
    # Another address is followed at once: a scroll that takes a while ends elsewhere if figures are rendered meanwhile.
    top = page.evaluate("""async () => {
      location.hash = "terrain";
      await new Promise(done => addEventListener("hashchange", () => requestAnimationFrame(done), { once: true }));
      const section = document.getElementById("terrain");
      return section.getBoundingClientRect().top - parseFloat(getComputedStyle(section).scrollMarginTop);
    }""")
    assert abs(top) < 2
    sections.get_by_role("button").click()
    sections.get_by_role("link", name="Rays on a grid").focus()
    page.keyboard.press("Enter")
    expect(sections.locator("[aria-current]")).to_have_text(re.compile("Rays on a grid"))
    expect(page.locator("#rays h2")).to_be_in_viewport()
    # The height of each figure is reserved at every width, beside those of the test above.
    for width in (1280, 1920, 768, 1366, 1100, 360):
        page.set_viewport_size({"width": width, "height": 800})
        until(f"the figures to be as high as reserved at {width}", lambda: page.evaluate(MISPLACED) == [])


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
        figures: document.querySelectorAll(".lesson-figure figure").length,
        canvases: canvases.length,
        light: canvases.filter(light).length,
      };
    })""")
    page.goto(f"{server}/lecture.html")
    expect(page.locator("#grid figure")).to_be_visible()
    page.pdf()
    printed = page.evaluate("printed")
    assert printed["figures"] == page.locator(".lesson").count()
    assert printed["light"] == printed["canvases"] >= 14
    expect(page.locator("html")).not_to_have_attribute("data-theme", "light")
    page.emulate_media(media="print")
    expect(page.locator(".section-list")).to_be_hidden()
    expect(page.locator("#rays .stage")).to_be_visible()
    expect(page.locator("#rays .rays-controls")).to_be_hidden()
    expect(page.locator("#cell .cell-buttons")).to_be_hidden()
