"""Cause and effect on one screen: what one uses and the part of the map that it changes are in the viewport together.

Of the lab, the log page and the front page, at four sizes. Each control is used at one of the sizes, in turn; that the
pictures stay in place and are not covered is looked at in every group at every size.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.looking import await_map, carried_out

SIZES = ((1280, 720), (1440, 900), (1920, 1080), (1024, 768))

# What is used by the tests below: no explanations, no links, no files, no number fields, whose slider stands beside it.
_CONTROLS = ", ".join(
    f"{one}:visible"
    for one in ("button:not(.tip-button):enabled", "input:not([type=number], [type=file]):enabled", "select:enabled",
                "[role=slider]:not(input)")
)  # fmt: skip

# Keeps what the map is now.
_KEEP = """() => {
  const { geometry, cells } = gridbloom.connection.store.map.peek();
  const bytes = new Uint8Array(geometry.rows * geometry.cols);
  for (let row = 0, i = 0; row < geometry.rows; row++)
    for (let col = 0; col < geometry.cols; col++) bytes[i++] = cells.at(row, col);
  window.kept = { ...geometry, bytes };
}"""

# How many cells of the world have changed since, all that are observed where the map has other cells; and how many of
# them lie in the picture. Faults also put cells outside the world.
_CHANGED = """(picture) => {
  const { geometry, cells } = gridbloom.connection.store.map.peek();
  const { rows, cols, resolution, origin, bytes } = window.kept;
  const isSame = rows === geometry.rows && cols === geometry.cols && resolution === geometry.resolution;
  const { width, height } = picture.getBoundingClientRect();
  const bounds = gridbloom.connection.store.world.peek()?.bounds ?? [-Infinity, -Infinity, Infinity, Infinity];
  let changed = 0;
  let seen = 0;
  for (let row = 0; row < geometry.rows; row++)
    for (let col = 0; col < geometry.cols; col++) {
      if (cells.at(row, col) === (isSame ? bytes[row * cols + col] : 0)) continue;
      const at = [0, 1].map((k) => geometry.origin[k] + ([col, row][k] + 0.5) * geometry.resolution);
      if (at[0] < bounds[0] || at[1] < bounds[1] || at[0] > bounds[2] || at[1] > bounds[3]) continue;
      const [x, y] = gridbloom.screen(at);
      changed += 1;
      seen += x >= 0 && y >= 0 && x <= width && y <= height;
    }
  return [changed, seen];
}"""

# The places of the pictures at which something else lies on top.
_COVERED = """(pictures) => pictures.flatMap((picture) => {
  const box = picture.getBoundingClientRect();
  const places = [0.03, 0.5, 0.97].flatMap((x) => [0.03, 0.5, 0.97].map((y) => [x, y]));
  return places.filter(([x, y]) => {
    const top = document.elementFromPoint(box.left + x * box.width, box.top + y * box.height);
    return !top || !(picture.parentElement.contains(top));
  });
})"""

# Whether the middle of a control is what one sees at its place.
_AT_HAND = """(control) => {
  const shown = control.querySelector(".handle-grab") ?? control.closest("label") ?? control;
  const box = shown.getBoundingClientRect();
  const top = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
  const isInside = box.x >= 0 && box.y >= 0 && box.right <= innerWidth && box.bottom <= innerHeight;
  const isOnTop = shown.contains(top) || control.contains(top) || top?.closest("figure.profile") === control.closest("figure.profile");
  return isInside && isOnTop ? null : { box: box.toJSON(), top: top?.outerHTML.slice(0, 200) };
}"""  # noqa: E501

# Name of a control, its kind, and of a list the number of the next choice.
_ABOUT = """(c) => [
  c.getAttribute("aria-label") ?? c.labels?.[0]?.textContent ?? c.textContent,
  c.tagName === "SELECT" ? "select" : c.type === "range" || c.getAttribute("role") === "slider" ? "slider" : c.type,
  c.tagName === "SELECT" ? (c.selectedIndex + 1) % c.options.length : null,
]"""
_SCROLLED = "() => [scrollX, scrollY, document.documentElement.scrollWidth > innerWidth]"


class Screen:
    """A page at one size: uses controls, and sees whether they and their effect are in the viewport."""

    def __init__(self, page: Page, size: tuple[int, int], pictures: Locator) -> None:
        page.set_viewport_size({"width": size[0], "height": size[1]})
        self.page = page
        self.size = size
        self.pictures = pictures
        carried_out(page)  # a picture takes its new size with the next frames
        self.places = self._places()

    def _places(self) -> list[dict[str, float]]:
        return list(self.pictures.evaluate_all("(all) => all.map((one) => one.getBoundingClientRect().toJSON())"))

    def stands(self, where: str) -> None:
        """The pictures are in the viewport, where they were, and nothing lies on them."""
        width, height = self.size
        assert self._places() == self.places, (self.size, where, "the pictures moved")
        for one in self.places:
            assert one["x"] >= 0, (self.size, where)
            assert one["y"] >= 0, (self.size, where)
            assert one["x"] + one["width"] <= width, (self.size, where)
            assert one["y"] + one["height"] <= height, (self.size, where)
        assert self.pictures.evaluate_all(_COVERED) == [], (self.size, where)
        assert self.page.evaluate(_SCROLLED) == [0, 0, False], (self.size, where)

    def use(self, control: Locator) -> bool:
        """Use a control; return whether the map has changed. Both have to be in the viewport."""
        name, kind, following = control.evaluate(_ABOUT)
        self.page.evaluate(_KEEP)
        control.scroll_into_view_if_needed()  # in its group: the page does not scroll
        if kind == "select":
            control.select_option(index=int(following))
        elif kind == "slider":
            control.focus()
            for key in ("ArrowLeft", "ArrowLeft", "ArrowDown"):
                self.page.keyboard.press(key)
        elif kind in ("checkbox", "radio"):
            control.press("Space")  # its own box is not what one sees
        else:
            control.click()
        carried_out(self.page)
        if control.count():  # some lead to what takes their place
            assert control.evaluate(_AT_HAND) is None, (self.size, name)
        self.stands(name)
        changed, seen = self.pictures.last.evaluate(_CHANGED)
        assert seen == changed, (self.size, name)
        return bool(changed)


def every_fourth(controls: Locator, turn: int) -> Iterator[Locator]:
    """Yield the controls whose turn it is, the first with the first size."""
    for n in range(turn, controls.count(), len(SIZES)):
        if n < controls.count():  # there may be fewer after one was used
            yield controls.nth(n)


def test_of_the_lab(page: Page, open_lab: Callable[..., Page]) -> None:
    page.emulate_media(reduced_motion="reduce")
    open_lab("room", scans=15)
    reset = page.get_by_role("button", name="Reset to defaults")
    changes = 0
    for turn, size in enumerate(SIZES):
        screen = Screen(page, size, page.locator(".lab .picture"))
        profile = page.locator("figure.profile")
        for handle in profile.get_by_role("slider").all():
            assert handle.evaluate(_AT_HAND) is None, (size, handle.get_attribute("aria-label"))
        for handle in every_fourth(profile.get_by_role("slider"), turn):
            changes += screen.use(handle)
        for button in every_fourth(page.locator(".lab-bar").locator(_CONTROLS), turn):
            screen.use(button)
        for tab in page.get_by_role("tab").all():
            tab.click()
            expect(tab).to_have_attribute("aria-selected", "true")
            screen.stands(tab.inner_text())
            if tab.inner_text().startswith(("3D", "Share", "Moving table", "Localize")):
                continue  # they change no map by themselves
            for control in every_fourth(page.locator(".dock-group:visible").locator(_CONTROLS), turn):
                changes += screen.use(control)
        page.get_by_role("tab", name="Model").click()
        reset.click()
        page.evaluate("() => gridbloom.connection.store.editing.take(null)")
        page.evaluate("() => gridbloom.connection.store.send({ type: 'compare', values: null })")
    assert changes > 8


def test_of_a_log(page: Page, server: str) -> None:
    page.emulate_media(reduced_motion="reduce")
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    await_map(page)
    changes = 0
    for turn, size in enumerate(SIZES):
        screen = Screen(page, size, page.locator(".viewer .picture"))
        for control in every_fourth(page.locator(".viewer-transport").locator(_CONTROLS), turn):
            changes += screen.use(control)
        page.get_by_role("tab", name="Settings").click()
        for control in every_fourth(page.locator(".dock-group:visible").locator(_CONTROLS), turn):
            changes += screen.use(control)
    assert changes > 4


def test_of_the_front_page(page: Page, server: str) -> None:
    page.emulate_media(reduced_motion="reduce")
    page.goto(server)
    await_map(page)
    page.get_by_role("button", name="Forward 10 scans").click()
    changes = 0
    for turn, size in enumerate(SIZES):
        screen = Screen(page, size, page.locator(".hero .picture"))
        handles = page.locator("figure.profile").get_by_role("slider")
        for handle in handles.all():
            assert handle.evaluate(_AT_HAND) is None, (size, handle.get_attribute("aria-label"))
        for handle in every_fourth(handles, turn):
            changes += screen.use(handle)
        more = page.get_by_role("link", name="One cell, the lecture, your own log")
        expect(more).to_be_in_viewport(ratio=1)
    assert changes > 1


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_on_a_phone_the_pictures_stay_at_the_top(page: Page, open_lab: Callable[..., Page]) -> None:
    page.emulate_media(reduced_motion="reduce")
    open_lab(scans=15)
    pictures = page.locator(".lab .picture")
    for name in ("Max range", "Hit increment", "Miss increment"):
        slider = page.locator(".lab-settings input[type=range]").and_(page.get_by_role("slider", name=name))
        slider.focus()
        for one in (*pictures.all(), slider):
            expect(one).to_be_in_viewport(ratio=0.95)
        assert slider.evaluate(_AT_HAND) is None, name
