"""What is in view on the lecture stays where it is while the page fills; in WebKit the page itself sees to that."""

from __future__ import annotations

import pytest

from tests.browser.engines.tab import PHONE, Tab
from tests.browser.looking import until
from tests.browser.stillness import AWAITED, FOUND, HOLD, JUMP, LET_GO, OFF, STILL_WITHIN, WATCH

# The text at this size, percent of the usual one, and in a font that is not the page's, as where that does not come.
_LOOK = """(text, ownFont) => {
  const { style } = document.documentElement;
  style.fontSize = `${text}%`;
  if (!ownFont) for (const name of ["ui", "prose"]) style.setProperty(`--font-${name}`, "monospace");
}"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("size", "text", "own_font"), [((901, 800), 200, True), ((1537, 900), 100, False), (PHONE, 100, True)]
)
def test_nothing_in_view_moves_while_the_page_fills(tab: Tab, size: tuple[int, int], text: int, own_font: bool) -> None:
    tab.driver.resize(*size)
    tab.open("/lecture.html")
    tab.run(HOLD)
    tab.run(_LOOK, text, own_font)
    tab.until("() => document.getElementById('next') !== null")
    for section in ("rays", "lifetime", "mount"):
        tab.run(JUMP, section)
        tab.run(WATCH)
        assert abs(tab.run(OFF, section)) <= STILL_WITHIN, section
    assert tab.run(AWAITED) > 15
    tab.run(LET_GO)
    until("all figures to be rendered", lambda: tab.run(AWAITED) == 0)
    tab.run("() => new Promise(requestAnimationFrame)")
    seen, moved = tab.run(FOUND)
    assert seen > 1
    assert moved == []
    assert abs(tab.run(OFF, "mount")) <= STILL_WITHIN
