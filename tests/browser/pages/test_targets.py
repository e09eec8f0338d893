"""Whatever one presses is at least 24 pixels wide and high (WCAG 2.5.8), on every page and in every open panel."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page

from tests.browser.lecturing import open_lecture, set_up_every_figure
from tests.browser.looking import await_map, open_groups, without_canvas_in_3d
from tests.marks import also_long_rows

LEAST = 24

# Targets on show that are smaller. Links within a sentence are as high as its lines; what is larger than it looks (a
# handle with a wide grip, a box with its label) is measured by what takes the pointer.
_SMALL = """(least) => {
  const found = [];
  const targets = "a[href], button, select, summary, textarea, input:not([type=file]), [role=slider], [role=tab]";
  for (const one of document.querySelectorAll(targets)) {
    if (!one.checkVisibility({ visibilityProperty: true, opacityProperty: true })) continue;
    if (one.disabled || one.closest("[inert], .visually-hidden, .skip-link")) continue;
    if (one.matches("a") && getComputedStyle(one).display === "inline") continue;
    if (getComputedStyle(one).clipPath === "inset(50%)") continue;
    const shown = one.querySelector(".handle-grab, .drag-handle-grab")
      ?? (one.matches("[type=checkbox], [type=radio]") ? one.closest("label") : null) ?? one;
    const box = shown.getBoundingClientRect();
    if (box.width < 1 || box.height < 1) continue;
    if (Math.min(box.width, box.height) < least - 0.5)
      found.push([Math.round(box.width), Math.round(box.height), one.outerHTML.slice(0, 130)]);
  }
  return found;
}"""


def small(page: Page) -> list[object]:
    """Return the targets on show that are too small: width, height, what it is."""
    for _ in range(20):  # frames: what has just been opened takes its size in one of the next
        found = list(page.evaluate(_SMALL, LEAST))
        if not found:
            break
        page.evaluate("() => new Promise(requestAnimationFrame)")
    return found


@pytest.mark.usefixtures("mapped_logs")
@pytest.mark.parametrize(
    ("context", "every"), [("phone", 6), *also_long_rows(("phone", 1), ("desktop", 1))], indirect=["context"]
)
def test_every_target_is_large_enough(page: Page, server: str, open_lab: Callable[..., Page], every: int) -> None:
    """On every page, and in one group of each dock in ``every``."""
    found: dict[str, list[object]] = {}
    page.goto(server)
    await_map(page)
    found["front page"] = small(page)
    open_lecture(page, server)
    set_up_every_figure(page)
    found["lecture"] = small(page)
    page.goto(f"{server}/fleet.html")
    page.locator(".fleet-card.failed").first.wait_for()
    page.evaluate("() => { for (const one of document.querySelectorAll('details')) one.open = true; }")
    found["fleet"] = small(page)
    without_canvas_in_3d(page)
    open_lab(scans=15)
    for place in ("lab", "log", "puzzle"):
        if place == "log":
            page.goto(f"{server}/logs.html")
            card = page.locator(".log-card", has_text="sample")
            card.wait_for()
            found["logs"] = small(page)
            card.get_by_role("button", name="Open map").click()
            await_map(page)
        elif place == "puzzle":
            page.goto(f"{server}/puzzles.html")
            page.locator(".puzzles .card").first.wait_for()
            found["puzzles"] = small(page)
            page.get_by_role("button", name="Open The thick walls").click()
            await_map(page)
        for title in open_groups(page, every):
            page.evaluate("() => { for (const one of document.querySelectorAll('details')) one.open = true; }")
            found[f"{place}, {title}"] = small(page)
    assert {where: targets for where, targets in found.items() if targets} == {}
