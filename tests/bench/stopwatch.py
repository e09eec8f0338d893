"""A stopwatch in the page: from the instant of an input event to the paint that follows what it changed.

The page's own clock is used throughout, so what the driver takes to send an event and to hear of it does not count. A
lap begins with ``event.timeStamp``, when the browser took the event in, and has three parts:

========== =========================================================================================================
delivered  until the page's code hears of it: a browser at rest begins a frame for a move at once, one that is painting
           holds it back until its next frame, 16.7 ms at 60 Hz
own        until the page has changed what it shows: its own code
painted    until style, layout and painting of that frame are done, and it is handed over to be composed
========== =========================================================================================================

The stopwatch asks for no frame of its own, and does not look at the page while it answers: either would keep the
browser painting, and the next move would wait for that. The same laps on an empty page, in which the event moves one
rectangle, are the floor of the method: no page is faster.

A handle is moved in two ways: one move after the other, each to a page that has answered the last, and dragged as by
a hand, with the moves of an ordinary mouse, 125 a second, whether or not the page keeps up. While it is dragged the
browser paints all the time, and a move that comes just after a frame has begun is seen with the next: no page is then
faster than a frame, and what a page adds is its distance from the floor.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from playwright.sync_api import Locator, Page

from tests.bench.hand import Hand
from tests.browser.looking import still, until

FRAME_S = 1.0 / 60.0
REST_S = 0.12  # within which an answer is seen, and the page comes to rest

# `change` is where a change ends the lap: the attribute of an element, a new path, a new map, whole or in part. As many
# laps are taken as `window.wanted` says.
_STOPWATCH = """([starts, change]) => {
  window.laps = [];
  window.wanted = 0;
  let lap = null;
  let painting = null;
  const painted = () => {
    if (!painting) return;
    const { since, heard, changed } = painting;
    const done = performance.now();
    painting = null;
    window.laps.push([heard - since, changed - heard, done - changed, done - since]);
  };
  // A frame is one task, from its callbacks to its painting: whatever task runs next finds it painted. The message
  // below is such a task, but a timer may run before it, and a browser that has the next frame to begin lets it wait.
  const ask = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (task) => ask((frame) => {
    if (painting && frame > painting.frame) painted();
    task(frame);
  });
  const wait = window.setTimeout.bind(window);
  window.setTimeout = (task, ms) => wait(() => {
    painted();
    task();
  }, ms);
  for (const type of starts)
    addEventListener(type, (event) => {
      painted();
      if (window.wanted > 0) lap = { since: event.timeStamp, heard: performance.now() };
    }, true);
  const changed = () => {
    if (!lap) return;
    const { since, heard } = lap;
    const changed = performance.now();
    lap = null;
    window.wanted--;
    ask((frame) => {
      painted();
      painting = { since, heard, changed, frame };
      const channel = new MessageChannel();
      channel.port1.onmessage = painted;
      channel.port2.postMessage(null);
    });
  };
  if (change === "path") {
    let before = null;
    gridbloom.connection.store.layers.content("plan").subscribe((now) => {
      if (now && now !== before) queueMicrotask(changed);
      before = now;
    });
  } else if (change === "map" || change === "whole map") {
    const { store } = gridbloom.connection;
    let before = store.layers.grid("map").complete;
    store.mapVersion.subscribe(() => queueMicrotask(() => {
      const now = store.layers.grid("map").complete;
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

    def told(self) -> str:
        """Return the figures in one cell of a table: the 95th percentile, then the median."""
        return f"{p95(self.painted):.1f} ms (half {sorted(self.painted)[len(self.painted) // 2]:.1f})"

    def parts(self) -> str:
        """Return the 95th percentile of each part."""
        return f"delivered {p95(self.delivered):.1f}, own code {p95(self.own):.1f}, painting {p95(self.painting):.1f}"


def laps(page: Page, starts: Sequence[str], change: str, movement: Callable[[int], None], times: int) -> Laps:
    """Make a movement many times; return how long each took to be seen. See :data:`_STOPWATCH` for ``change``."""
    page.evaluate(_STOPWATCH, [list(starts), change])
    chance = random.Random(4)  # moves that kept step with the browser's frames would all wait equally long
    for i in range(times):
        page.evaluate("() => { window.wanted = 1; }")
        time.sleep(chance.uniform(0.0, FRAME_S))
        movement(i)
        time.sleep(REST_S)
        _await(page, i + 1)
    return _taken(page)


def _await(page: Page, count: int) -> None:
    until("the answer to be seen", lambda: page.evaluate("() => window.laps.length") >= count)


def _taken(page: Page) -> Laps:
    columns = zip(*page.evaluate("() => window.laps"), strict=True)
    return Laps(*(tuple(float(ms) for ms in column) for column in columns))


@contextmanager
def gripped(page: Page, grip: Locator) -> Iterator[tuple[float, float]]:
    """Hold a handle by a part of it until the block ends; yield where."""
    x, y = still(grip)
    page.mouse.move(x, y)
    page.wait_for_timeout(500)
    x, y = still(grip)
    page.mouse.move(x, y)
    page.mouse.down()
    try:
        yield x, y
    finally:
        page.mouse.up()


def moved(page: Page, grip: Locator, times: int, *, dx: float = 0.0, dy: float = 0.0) -> Laps:
    """Take a handle (``role=slider``) and move it to and fro, move by move; return the laps to its new value."""
    with gripped(page, grip) as (x, y):

        def move(i: int) -> None:
            page.mouse.move(x + dx * (0.5 + i % 2), y + dy * (0.5 + i % 2))

        for i in range(2):  # a figure whose axes have to grow for these places does so now
            move(i)
            page.wait_for_timeout(500)
        return laps(page, ["pointermove"], "aria-valuenow", move, times)


def dragged(page: Page, grip: Locator, hand: Hand, times: int, *, dx: float = 0.0, dy: float = 0.0) -> Laps:
    """Take a handle (``role=slider``) and drag it to and fro by ``hand``; return the laps to its new values."""
    with gripped(page, grip) as (x, y):
        page.evaluate(_STOPWATCH, [["pointermove"], "aria-valuenow"])
        page.evaluate("(times) => { window.wanted = times; }", times)
        with hand.dragging(page.url, (x, y), (x + dx, y + dy)):
            _await(page, times)
        return _taken(page)


def floor(page: Page, hand: Hand, times: int, frames: int) -> tuple[Laps, Laps]:
    """Return the laps of an empty page, move by move and dragged: what no page can better in this browser here."""
    page.set_content(EMPTY)
    rect = page.locator("rect")
    rect.focus()
    return moved(page, rect, times, dy=-20.0), dragged(page, rect, hand, frames, dy=-60.0)
