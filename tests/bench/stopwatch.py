"""A stopwatch in the page: from the instant of an input event to the paint that follows what it changed.

The page's own clock is used throughout, so what the driver takes to send an event and to hear of it does not count. A
lap begins with ``event.timeStamp``, when the browser took the event in, and has four parts:

========== =========================================================================================================
delivered  until the page's code hears of it: the browser holds moves back until its next frame, 16.7 ms at 60 Hz
own        until the page has changed what it shows: its own code
painted    until style, layout and painting of that frame are done
next       the whole, from the event until the frame after that one began: by then it was handed over to the screen
========== =========================================================================================================

The same laps on an empty page, in which the event moves one rectangle, are the floor of the method: no page is faster.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from playwright.sync_api import Locator, Page

from tests.browser.looking import still, until

# `change` is where a change ends the lap: the attribute of an element, or a new map, whole or any part of it.
_STOPWATCH = """([starts, change]) => {
  window.laps = [];
  window.lap = null;
  for (const type of starts)
    addEventListener(type, (event) => {
      if (!window.lap || window.lap.since) return;
      window.lap.since = event.timeStamp;
      window.lap.heard = performance.now();
    }, true);
  const painted = (then) => requestAnimationFrame(() => {
    const channel = new MessageChannel();
    channel.port1.onmessage = then;
    channel.port2.postMessage(null);
  });
  const changed = () => {
    const lap = window.lap;
    if (!lap || !lap.since) return;
    window.lap = null;
    lap.changed = performance.now();
    painted(() => {
      const done = performance.now();
      requestAnimationFrame(() => window.laps.push([
        lap.heard - lap.since, lap.changed - lap.heard, done - lap.changed, done - lap.since,
        performance.now() - lap.since,
      ]));
    });
  };
  if (change === "map" || change === "whole map") {
    const { store } = gridbloom.connection;
    let before = store.progress();
    store.mapVersion.subscribe(() => queueMicrotask(() => {
      const now = store.progress();
      const whole = now && (!before || now.epoch !== before.epoch || now.revision > before.revision);
      if (change === "map" || whole) changed();
      if (whole) before = now;
    }));
  } else {
    const seen = { attributes: true, attributeFilter: [change] };
    new MutationObserver(changed).observe(document.activeElement, seen);
  }
}"""

EMPTY = """<!doctype html><title>floor</title><svg width="700" height="400">
<rect tabindex="0" role="slider" aria-valuenow="0" x="100" y="100" width="200" height="200" fill="#c66"></rect></svg>
<script>
const rect = document.querySelector("rect");
addEventListener("pointermove", (event) => {
  rect.setAttribute("y", event.clientY - 100);
  rect.setAttribute("aria-valuenow", event.clientY);
});
</script>"""


def p95(values: Sequence[float]) -> float:
    """Return the 95th percentile, nearest rank."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))]


@dataclass(frozen=True, slots=True)
class Laps:
    """Laps in milliseconds, part by part."""

    delivered: tuple[float, ...]
    own: tuple[float, ...]
    painting: tuple[float, ...]
    painted: tuple[float, ...]
    next: tuple[float, ...]

    def told(self) -> str:
        """Return the figures in one cell of a table: the 95th percentile, then the median."""
        return f"{p95(self.painted):.1f} ms (half {sorted(self.painted)[len(self.painted) // 2]:.1f})"

    def parts(self) -> str:
        """Return the 95th percentile of each part."""
        return (
            f"delivered {p95(self.delivered):.1f}, own code {p95(self.own):.1f}, painting {p95(self.painting):.1f}; "
            f"next frame {p95(self.next):.1f}"
        )


def laps(page: Page, starts: Sequence[str], change: str, movement: Callable[[int], None], times: int) -> Laps:
    """Make a movement many times; return how long each took to be seen. See :data:`_STOPWATCH` for ``change``."""
    page.evaluate(_STOPWATCH, [list(starts), change])
    for i in range(times):
        page.evaluate("() => { window.lap = {}; }")
        movement(i)
        until("the answer to be seen", lambda i=i: page.evaluate("() => window.laps.length") > i)  # type: ignore[misc]
    columns = zip(*page.evaluate("() => window.laps"), strict=True)
    return Laps(*(tuple(float(ms) for ms in column) for column in columns))


def dragged(page: Page, grip: Locator, times: int, *, dx: float = 0.0, dy: float = 0.0) -> Laps:
    """Take a handle (``role=slider``) by a part of it and move it to and fro; return the laps to its new value."""
    x, y = still(grip)
    page.mouse.move(x, y)
    page.wait_for_timeout(500)
    x, y = still(grip)
    page.mouse.move(x, y)
    page.mouse.down()
    try:
        return laps(
            page,
            ["pointermove"],
            "aria-valuenow",
            lambda i: page.mouse.move(x + dx * (0.5 + i % 2), y + dy * (0.5 + i % 2)),
            times,
        )
    finally:
        page.mouse.up()


def floor(page: Page, times: int) -> Laps:
    """Return the laps of an empty page: what no page can better in this browser on this machine."""
    page.set_content(EMPTY)
    page.locator("rect").focus()
    return dragged(page, page.locator("rect"), times, dy=-20.0)
