"""A page in an engine as a person uses it: what is found by its words, pressed, dragged and waited for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tests.browser.engines.driver import Driver, DriverError
from tests.browser.looking import STILL, until
from tests.browser.pages.test_axe import AXE
from tests.browser.pages.test_pages import FITS

PHONE, DESKTOP = (390, 844), (1440, 900)
#: Keys by their names in the DOM, as WebDriver writes them.
KEYS = {
    "Enter": "\ue007", "Shift": "\ue008", "Control": "\ue009", "Escape": "\ue00c", " ": "\ue00d", "PageUp": "\ue00e",
    "PageDown": "\ue00f", "End": "\ue010", "Home": "\ue011", "ArrowLeft": "\ue012", "ArrowUp": "\ue013",
    "ArrowRight": "\ue014", "ArrowDown": "\ue015",
}  # fmt: skip

# Elements on show that a CSS selector selects, with a name or words: the whole of them, or as "Map…" those that begin
# with this word, and not with "Mapping".
_FOUND = """(css, words) => [...document.querySelectorAll(css)].filter((element) => {
  if (!element.checkVisibility({ visibilityProperty: true })) return false;
  if (words === null) return true;
  const names = [element.getAttribute("aria-label"), element.labels?.[0]?.textContent, element.textContent];
  return names.some((name) => {
    const text = name?.replace(/\\s+/g, " ").trim();
    if (!words.endsWith("…")) return text === words;
    const begin = words.slice(0, -1);
    return text?.startsWith(begin) && !/^[a-z]/.test(text.slice(begin.length));
  });
})"""
# The middle of the first of them once it is at rest and nothing covers it, else what is in the way.
_MIDDLE = f"""async (css, words, nth) => {{
  const found = ({_FOUND})(css, words)[nth];
  if (!found) return "there is none";
  if (found.disabled) return "it is disabled";
  const inView = () => {{
    const box = found.getBoundingClientRect();
    return box.top >= 0 && box.left >= 0 && box.bottom <= innerHeight && box.right <= innerWidth;
  }};
  if (!inView()) found.scrollIntoView({{ block: "center", behavior: "instant" }});
  await ({STILL})(found);
  const {{ x, y, width, height }} = found.getBoundingClientRect();
  const [middleX, middleY] = [x + width / 2, y + height / 2];
  const hit = document.elementFromPoint(middleX, middleY);
  const control = found.closest("[role=slider], label, button, a") ?? found;
  const isHit = hit && (control.contains(hit) || hit.contains(found) || found.labels?.[0]?.contains(hit));
  return isHit ? [middleX, middleY] : `covered by ${{hit?.outerHTML.slice(0, 120)}}`;
}}"""

_VIOLATIONS = """async () => {
  const options = { resultTypes: ["violations"], selectors: false };
  const { violations } = await axe.run("html", options);
  return violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map(({ html }) => html.slice(0, 120))}`);
}"""


class Tab:
    """A page in an engine. Elements are named by a CSS selector and, where that is not enough, their words."""

    def __init__(self, driver: Driver, server: str) -> None:
        self.driver = driver
        self.server = server

    def open(self, path: str) -> None:
        """Open a page of the service, or an address."""
        self.driver.goto(path if path.startswith("http") else self.server + path)

    def run(self, function: str, *arguments: Any) -> Any:
        """Call a JavaScript function on the page; return its result, awaited."""
        return self.driver.run(function, *arguments)

    def until(self, condition: str, *arguments: Any) -> Any:
        """Wait until a JavaScript function returns something true; return that."""
        last = [""]

        def holds() -> Any:
            try:
                return self.run(condition, *arguments)
            except DriverError as error:  # the page is being left, or has not come so far
                last[0] = str(error)
                return None

        try:
            return until(f"{condition} {list(arguments)}", holds)
        except AssertionError as error:
            raise AssertionError(f"{error}; last error: {last[0]}; at {self.run('() => location.href')}") from None

    def shows(self, css: str, words: str | None = None, *, n: int | None = None) -> None:
        """Wait until such an element is on show, or ``n`` of them are."""
        wanted = "length > 0" if n is None else f"length === {n}"
        self.until(f"(css, words) => ({_FOUND})(css, words).{wanted}", css, words)

    def text(self, css: str) -> str:
        """Return the words of the first element, white space as one space."""
        return str(self.run("(css) => document.querySelector(css)?.innerText.replace(/\\s+/g, ' ') ?? ''", css))

    def says(self, css: str, words: str) -> None:
        """Wait until an element has these words among its own."""
        self.until(
            "(css, words) => [...document.querySelectorAll(css)].some((one) => one.innerText.includes(words))",
            css,
            words,
        )

    def middle(self, css: str, words: str | None = None, nth: int = 0) -> tuple[float, float]:
        """Return the middle of an element, scrolled into view, once a mouse can reach it there."""
        last: list[Any] = [None]

        def reached() -> bool:
            try:
                last[0] = self.run(_MIDDLE, css, words, nth)
            except DriverError as error:
                last[0] = str(error)
            return not isinstance(last[0], str)

        try:
            until(f"{css} {words!r} to be reached", reached)
        except AssertionError as error:
            raise AssertionError(f"{error}: {last[0]}") from None
        x, y = last[0]
        return x, y

    def box(self, css: str, nth: int = 0) -> tuple[float, float, float, float]:
        """Return an element's left and upper edge, width and height in the window, CSS pixels."""
        x, y, width, height = self.run(
            "(css, nth) => { const box = document.querySelectorAll(css)[nth].getBoundingClientRect();"
            " return [box.x, box.y, box.width, box.height]; }",
            css,
            nth,
        )
        return x, y, width, height

    def _mouse(self, *actions: dict[str, Any]) -> None:
        pointer = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": list(actions)}
        self.driver.perform([pointer])

    def click_at(self, x: float, y: float, key: str | None = None) -> None:
        """Click a place of the window, with a key held down if one is named."""
        if key:
            self._keys(("keyDown", KEYS[key]))
        self._mouse(_move(x, y), {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0})
        if key:
            self._keys(("keyUp", KEYS[key]))

    def click(self, css: str, words: str | None = None, nth: int = 0) -> None:
        """Click the middle of an element."""
        self.click_at(*self.middle(css, words, nth))

    def drag_at(self, *places: tuple[float, float]) -> None:
        """Drag from a place of the window over others to the last."""
        first, *others = places
        steps = [_move(*place) for one, other in zip(places, others, strict=False) for place in _between(one, other)]
        self._mouse(_move(*first), {"type": "pointerDown", "button": 0}, *steps, {"type": "pointerUp", "button": 0})

    def drag(self, css: str, dx: float, dy: float, words: str | None = None) -> None:
        """Drag an element by its middle."""
        x, y = self.middle(css, words)
        self.drag_at((x, y), (x + dx, y + dy))

    def _keys(self, *events: tuple[str, str]) -> None:
        actions = [{"type": kind, "value": key} for kind, key in events]
        self.driver.perform([{"type": "key", "id": "keyboard", "actions": actions}])

    def press(self, *keys: str) -> None:
        """Press keys together, such as ``press("Control", "z")``."""
        codes = [KEYS.get(key, key) for key in keys]
        self._keys(*(("keyDown", one) for one in codes), *(("keyUp", one) for one in reversed(codes)))

    def type(self, text: str) -> None:
        """Type a text where the focus is."""
        self._keys(*((kind, one) for one in text for kind in ("keyDown", "keyUp")))

    def open_group(self, title: str) -> None:
        """Open a group of a dock, and before it the section that it is in, whose hint has the titles of its groups."""
        tab = ("[role=tab]", f"{title}…")
        self.until(
            f"""(css, words) => {{
              if (({_FOUND})(css, words).length > 0) return true;
              const sections = [...document.querySelectorAll(".dock-tabs [title]")];
              sections.find(({{ title }}) => title.split(", ").includes(words.slice(0, -1)))?.click();
            }}""",
            *tab,
        )
        self.click(*tab)

    def choose_files(self, css: str, files: Sequence[Path]) -> None:
        """Choose files in an input."""
        self.until("(css) => document.querySelector(css) !== null", css)
        self.driver.choose_files(css, files)

    def await_map(self) -> None:
        """Wait until the page holds a map with something in it."""
        self.until("() => window.gridbloom && gridbloom.cells().free > 50")

    def fits(self) -> None:
        """Wait until the page, in its fonts, does not scroll sideways."""
        self.run("() => document.fonts.ready.then(() => null)")
        self.until(FITS)

    def violations(self) -> list[str]:
        """Return what axe-core finds on the page: the rules, and the first elements that break them."""
        if not self.run("() => 'axe' in window"):
            self.run(f"() => {{ {AXE.read_text()} }}")
        return list(self.run(_VIOLATIONS))

    def problems(self) -> list[str]:
        """Return what went wrong on the pages so far: errors, failed requests, other hosts; see ``watch.js``."""
        return list(self.run("() => JSON.parse(sessionStorage.getItem('engines.problems') ?? '[]')"))

    def end_sessions(self) -> None:
        """End the sessions that this visitor began."""
        self.run("""async () => {
          const { sessions } = await (await fetch("/api/sessions")).json();
          for (const { id } of sessions) await fetch(`/api/sessions/${id}`, { method: "DELETE" });
        }""")


def _move(x: float, y: float) -> dict[str, Any]:
    return {"type": "pointerMove", "x": round(x), "y": round(y), "duration": 0}


def _between(start: tuple[float, float], end: tuple[float, float], steps: int = 6) -> list[tuple[float, float]]:
    """Return the places after ``start`` on the way to ``end``, evenly spaced."""
    fractions = [(i + 1) / steps for i in range(steps)]
    return [(start[0] + f * (end[0] - start[0]), start[1] + f * (end[1] - start[1])) for f in fractions]
