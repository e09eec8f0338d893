"""Uses the controls of a page, and measures that each one and what it changes are in the viewport together."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any
from zlib import crc32

from playwright.sync_api import ElementHandle, Error, Locator, Page

from tests.browser.looking import await_true, carried_out

FULL_SCREEN = "Full screen"  #: the name of the button that shows a group alone
PLOTS = "Plots"  #: the button of the plots below the timeline
SIZES = ((1280, 720), (1440, 900), (1920, 1080), (1024, 768))

# What is used: no explanations, no links, no files, no number fields, whose slider stands beside it.
CONTROLS = ", ".join(
    f"{one}:visible"
    for one in ("button:not(.tip-button):enabled",
                "input:not([type=number], [role=spinbutton], [type=file]):enabled",
                "select:enabled", "textarea:enabled", "[role=slider]:not(input)")
)  # fmt: skip

_NAME = """(control) => (control.getAttribute("aria-label") ?? control.labels?.[0]?.innerText ?? control.innerText
  ).trim().replace(/[0-9.:,]+/g, "#")"""

# Whether a control chooses the views of the stage.
_ARRANGES = "(control) => control.closest('.layout-choice, .view-choice') !== null"

# What a control is; keeps what the map is before it is used.
_BEFORE = """(control) => {
  const { geometry, cells } = gridbloom.connection.store.map.peek();
  const bytes = [];
  for (let row = 0; row < geometry.rows; row++)
    for (let col = 0; col < geometry.cols; col++) bytes.push(cells.at(row, col));
  window.kept = { ...geometry, bytes };
  control.scrollIntoView({ block: "nearest", inline: "nearest", behavior: "instant" });  // in its group
  if (control.tagName === "SELECT") return "choice";
  if (control.type === "range" || control.getAttribute("role") === "slider") return "slider";
  if (control.type === "checkbox" || control.type === "radio") return "box";
  return control.matches("textarea:read-write, input:read-write") ? "text" : "button";
}"""

# What is wrong with a control after it was used: null where its middle is what one sees at its place.
_AT_HAND = """(control) => {
  if (!control.isConnected || !control.checkVisibility()) return null;  // it led to what took its place
  const shown = control.querySelector(".handle-grab") ?? control.closest("label") ?? control;
  const box = shown.getBoundingClientRect();
  const top = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
  const isInside = box.x >= 0 && box.y >= 0 && box.right <= innerWidth && box.bottom <= innerHeight;
  const figure = control.closest("figure.profile");
  const isOnTop = shown.contains(top) || control.contains(top) || (figure && top?.closest("figure") === figure);
  return isInside && isOnTop ? null : `${JSON.stringify(box)} under ${top?.outerHTML.slice(0, 200)}`;
}"""

# The boxes of the pictures and of what else has to be in the viewport; how far the page is scrolled; the places of the
# pictures at which something else lies on top.
_SCREEN = """([pictures, others]) => {
  const box = (one) => { const { x, y, width, height } = one.getBoundingClientRect(); return [x, y, width, height]; };
  const all = [...document.querySelectorAll(pictures)];
  const covered = all.flatMap((picture) => {
    const [left, top, width, height] = box(picture);
    const places = [0.03, 0.5, 0.97].flatMap((x) => [0.03, 0.5, 0.97].map((y) => [left + x * width, top + y * height]));
    return places.map((place) => document.elementFromPoint(...place)).filter(
      (found) => !picture.parentElement.contains(found)).map((found) => found?.outerHTML.slice(0, 120) ?? "nothing");
  });
  const root = document.documentElement;
  return {
    pictures: all.map(box),
    others: [...document.querySelectorAll(others)].filter((one) => one.checkVisibility()).map(box),
    scroll: [scrollX, scrollY, root.scrollWidth > innerWidth],
    covered,
  };
}"""

# How many cells of the world have changed since, all that are observed where the map has other cells; and how many of
# them lie in the picture. Faults also put cells outside the world.
_CHANGED = """(pictures) => {
  const picture = [...document.querySelectorAll(pictures)].at(-1);
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


# Resolves when pictures and handles have kept their places for some frames: they take a new size one after the other.
_STILL = """async (pictures) => {
  for (let before = "", same = 0; same < 4; ) {
    await new Promise(requestAnimationFrame);
    const all = [...document.querySelectorAll(`${pictures}, [role=slider]`)];
    const now = all.map((one) => Object.values(one.getBoundingClientRect().toJSON()).join(" ")).join();
    same = now === before ? same + 1 : 0;
    before = now;
  }
}"""


@dataclass
class Screen:
    """A page at one size.

    Attributes:
        page: the page, with a session.
        pictures: selector of the pictures of the map; the last one shows what the controls change.
        others: selector of what has to be in the viewport too.
        changes: how many uses of controls have changed the map.
    """

    page: Page
    pictures: str
    others: str = ".no-others"
    changes: int = 0
    _size: tuple[int, int] = (0, 0)
    _places: list[list[float]] = field(default_factory=list)

    def resize(self, size: tuple[int, int], scheme: str) -> list[list[float]]:
        """Give the page another size and colour scheme; return the boxes of the pictures: x, y, width, height."""
        self.page.set_viewport_size({"width": size[0], "height": size[1]})
        self.page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
        self.page.evaluate(_STILL, self.pictures)
        self._size = size
        self._places = self.page.evaluate(_SCREEN, [self.pictures, self.others])["pictures"]
        assert self._places
        return self._places

    def stands(self, where: str) -> None:
        """The pictures are in the viewport, where they were, and nothing lies on them."""
        seen: dict[str, Any] = self.page.evaluate(_SCREEN, [self.pictures, self.others])
        assert seen["pictures"] == self._places, (self._size, where, "the pictures moved")
        width, height = self._size
        for x, y, wide, high in seen["pictures"] + seen["others"]:
            assert x >= 0, (self._size, where)
            assert y >= 0, (self._size, where)
            assert x + wide <= width + 0.5, (self._size, where)
            assert y + high <= height + 0.5, (self._size, where)
        assert seen["covered"] == [], (self._size, where, seen["covered"])
        assert seen["scroll"] == [0, 0, False], (self._size, where)

    def at_hand(self, controls: Locator) -> None:
        """Each of the controls is in the viewport without scrolling, and nothing lies on it."""
        for control in controls.element_handles():
            wrong = control.evaluate(_AT_HAND)
            assert wrong is None, (self._size, control.evaluate(_NAME), wrong)

    def use(self, control: ElementHandle) -> None:
        """Use a control. It and what it changes of the map have to be in the viewport then."""
        name = control.evaluate(_NAME)
        kind = control.evaluate(_BEFORE)
        if kind == "choice":
            control.select_option(index=int(control.evaluate("(c) => (c.selectedIndex + 1) % c.options.length")))
        elif kind == "slider":
            control.focus()
            for key in ("ArrowLeft", "ArrowDown"):
                self.page.keyboard.press(key)
        elif kind == "box":
            control.press("Space")  # its own box is not what one sees
        elif kind == "text":
            control.fill("3")
        else:
            control.click()
        if control.evaluate(_ARRANGES):
            self._arranged(name)
            return
        carried_out(self.page)
        self._answer(name)
        wrong = control.evaluate(_AT_HAND)
        assert wrong is None, (self._size, name, wrong)
        self.stands(name)
        changed, seen = self.page.evaluate(_CHANGED, self.pictures)
        assert seen == changed, (self._size, name)
        self.changes += bool(changed)

    def _arranged(self, name: str) -> None:
        """What chooses views moves the pictures: each view is in the viewport. The first layout is chosen again."""
        self.page.evaluate(_STILL, self.pictures)
        for view in self.page.locator(".view-pane").all():
            box = view.bounding_box()
            assert box is not None, (self._size, name)
            assert box["x"] >= 0, (self._size, name)
            assert box["y"] >= 0, (self._size, name)
            assert box["x"] + box["width"] <= self._size[0] + 0.5, (self._size, name)
            assert box["y"] + box["height"] <= self._size[1] + 0.5, (self._size, name)
        self.page.locator(".layout-choice select").first.select_option(label="World and belief")
        self.page.evaluate(_STILL, self.pictures)
        self.stands(name)

    def _answer(self, name: str) -> None:
        """Close the dialog that asks whether it is meant, which has to be seen whole; end the full screen."""
        for dialog in self.page.locator("dialog:modal").element_handles():
            box = dialog.bounding_box()
            assert box is not None, name
            assert min(box["x"], box["y"]) >= 0, (self._size, name)
            assert box["x"] + box["width"] <= self._size[0], (self._size, name)
            assert box["y"] + box["height"] <= self._size[1], (self._size, name)
            self.page.keyboard.press("Escape")
        if name == FULL_SCREEN:
            await_true(self.page, "() => document.fullscreenElement")
            self.page.evaluate("() => document.exitFullscreen()")
            self.page.evaluate(_STILL, self.pictures)
        if name == PLOTS:
            self._plots_take_their_room_from_the_picture()

    def _plots_take_their_room_from_the_picture(self) -> None:
        """They and the picture are in the viewport, one below the other; without them the picture is as before."""
        plots = self.page.locator(".timeline-plots")
        self.page.locator(".timeline-plots .u-over").first.wait_for()
        self.page.evaluate(_STILL, self.pictures)
        below, picture = plots.bounding_box(), self.page.locator(self.pictures).last.bounding_box()
        assert below is not None
        assert picture is not None
        assert picture["height"] >= 140, (self._size, picture)
        assert picture["y"] + picture["height"] <= below["y"], (self._size, picture, below)
        assert below["y"] + below["height"] <= self._size[1], (self._size, below)
        self.page.get_by_role("button", name=PLOTS, exact=True).click()
        plots.wait_for(state="detached")
        self.page.evaluate(_STILL, self.pictures)


@dataclass
class Turns:
    """Whose turn it is: each control, by its name, is used at one of the sizes, or one in ``every`` of them."""

    sizes_left: int
    every: int = 1
    used: set[str] = field(default_factory=set)
    gone: set[str] = field(default_factory=set)

    def use_all(self, screen: Screen, where: Locator) -> None:
        """Use the controls of a part of the page that have their turn; at the last size also those that appear."""
        controls = where.locator(CONTROLS)
        share = None
        while fresh := self._fresh(controls):
            share = -(-len(fresh) // self.sizes_left) if share is None else share
            if share == 0:
                return
            first, name = fresh[0]
            self.used.add(name)
            try:
                screen.use(controls.nth(first).element_handle())
            except Error as error:  # the page may have drawn it again meanwhile: it is looked for once more
                if "not attached" not in error.message or name in self.gone:
                    raise
                self.gone.add(name)
                self.used.remove(name)
                continue
            share -= self.sizes_left > 1

    def _fresh(self, controls: Locator) -> list[tuple[int, str]]:
        names: list[str] = controls.evaluate_all(f"(all) => all.map({_NAME})")
        mine = [(i, name) for i, name in enumerate(names) if crc32(name.encode()) % self.every == self.every - 1]
        return [(i, name) for i, name in mine if name not in self.used]
