"""What the browser tests read from a page: the map that the browser holds, and what its figures show."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Locator, Page

SECONDS = 30.0  # how long anything may take on a slow machine before a test fails

# FNV-1a over the geometry and every byte of the map that the browser holds.
_MAP_DIGEST = """() => {
  const map = gridbloom.connection.store.map.peek();
  if (!map) return "no map";
  const { rows, cols, resolution, origin, log_odds_min, log_odds_max } = map.geometry;
  let hash = 2166136261;
  for (let row = 0; row < rows; row++)
    for (let col = 0; col < cols; col++) hash = Math.imul(hash ^ map.cells.at(row, col), 16777619);
  return [rows, cols, resolution, origin, log_odds_min, log_odds_max, hash >>> 0].join(" ");
}"""

_MAP_BYTES = """() => {
  const map = gridbloom.connection.store.map.peek();
  const { rows, cols } = map.geometry;
  const bytes = [];
  for (let row = 0; row < rows; row++) for (let col = 0; col < cols; col++) bytes.push(map.cells.at(row, col));
  return { ...map.geometry, bytes };
}"""


def until(what: str, condition: Callable[[], Any], seconds: float = SECONDS) -> Any:
    """Return the first true value of ``condition``; fail the test, saying ``what`` was awaited, when none comes."""
    deadline = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        assert time.monotonic() < deadline, f"waited {seconds:g} s in vain: {what}"
        time.sleep(0.05)


def map_digest(page: Page) -> str:
    """Return a digest of the map that the browser holds."""
    return str(page.evaluate(_MAP_DIGEST))


def settled_digest(page: Page) -> str:
    """Return the digest once it has stayed the same for a while."""
    last, since = map_digest(page), time.monotonic()
    deadline = since + SECONDS
    while time.monotonic() - since < 0.5:
        assert time.monotonic() < deadline, "the map never settled"
        page.wait_for_timeout(100)
        now = map_digest(page)
        if now != last:
            last, since = now, time.monotonic()
    return last


def map_bytes(page: Page) -> dict[str, Any]:
    """Return the geometry of the browser's map with ``bytes``, row by row from the smallest y, 0 for never observed."""
    result: dict[str, Any] = page.evaluate(_MAP_BYTES)
    return result


def observed(page: Page) -> int:
    """Return how many cells of the browser's map were ever observed."""
    return int(page.evaluate("() => Object.values(gridbloom.cells()).reduce((a, b) => a + b, 0)"))


def frame(page: Page) -> dict[str, Any]:
    """Return the newest frame message that the page has."""
    result: dict[str, Any] = page.evaluate("() => gridbloom.connection.store.frame.peek()")
    return result


def await_map(page: Page) -> None:
    """Wait until the page holds a map with something in it."""
    page.wait_for_function("() => window.gridbloom && gridbloom.cells().free > 50", timeout=SECONDS * 1000)


def centre(locator: Locator) -> tuple[float, float]:
    """Return the middle of an element, in CSS pixels of the viewport, scrolled into view."""
    locator.scroll_into_view_if_needed()
    box = locator.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def still(page: Page, locator: Locator) -> tuple[float, float]:
    """Return the middle of an element once it has stopped moving."""
    last = centre(locator)
    deadline = time.monotonic() + SECONDS
    while True:
        page.wait_for_timeout(250)
        now = centre(locator)
        if now == last:
            return now
        assert time.monotonic() < deadline, "the element never stood still"
        last = now


def drag(page: Page, locator: Locator, dx: float, dy: float) -> None:
    """Go to an element with the mouse, and when it stands still under it drag it by its middle."""
    page.mouse.move(*centre(locator))
    x, y = still(page, locator)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx, y + dy, steps=6)
    page.mouse.up()
