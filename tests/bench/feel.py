"""``python -m tests.bench feel``: how the lab feels, measured in real Chromium on loopback, beside what is wanted."""

from __future__ import annotations

import gzip
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, Response

from tests.browser.looking import await_map, frame, settled_digest, until
from tests.browser.running import running_chromium, running_server

TIMES = 40  # of each hand movement
OPENED = 8  # of the page
RUNNING_S = 4.0
ASLEEP_S = 3.0

# From an input event to the paint that follows the first change that `watch` reports.
_STOPWATCH = """(watch) => {
  window.feel = [];
  window.ownWork = [];
  let since = null;
  let heard = 0;
  const painted = (then) => requestAnimationFrame(() => {
    const channel = new MessageChannel();
    channel.port1.onmessage = then;
    channel.port2.postMessage(null);
  });
  for (const type of ["pointermove", "pointerup", "input"])
    addEventListener(type, (event) => {
      if (!window.feelArmed || since !== null) return;
      since = event.timeStamp;
      heard = performance.now();
    }, true);
  const changed = () => {
    if (since === null) return;
    const from = since;
    since = null;
    window.feelArmed = false;
    window.ownWork.push(performance.now() - heard);
    painted(() => window.feel.push(performance.now() - from));
  };
  if (watch === "profile") {
    const seen = { subtree: true, childList: true, attributes: true, characterData: true };
    new MutationObserver(changed).observe(document.querySelector("figure.profile"), seen);
  } else gridbloom.connection.store.mapVersion.subscribe(changed);
}"""

_FRAMES = """(seconds) => new Promise((resolve) => {
  const from = performance.now();
  let frames = 0;
  const count = (now) => {
    frames++;
    if (now - from < 1000 * seconds) requestAnimationFrame(count);
    else resolve(frames / ((now - from) / 1000));
  };
  requestAnimationFrame(count);
})"""

_FIRST_CELLS = """() => {
  const look = () => {
    if (window.gridbloom && gridbloom.cells().free > 50) {
      const channel = new MessageChannel();
      channel.port1.onmessage = () => { window.firstCells = performance.now(); };
      requestAnimationFrame(() => channel.port2.postMessage(null));
    } else requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}"""


def p95(values: list[float]) -> float:
    """Return the 95th percentile, nearest rank."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))]


def timed(page: Page, movement: Callable[[int], None]) -> list[float]:
    """Make a movement many times; return the milliseconds that each took to be seen."""
    for i in range(TIMES):
        page.evaluate("() => { window.feelArmed = true; }")
        movement(i)
        until("the answer to be seen", lambda i=i: page.evaluate("() => window.feel.length") > i)  # type: ignore[misc]
    return [float(ms) for ms in page.evaluate("() => window.feel")]


def paused(browser: Browser, server: str) -> Page:
    """Return the lab at 1440 × 900, standing still."""
    page = browser.new_context(viewport={"width": 1440, "height": 900}).new_page()
    page.goto(f"{server}/lab.html")
    await_map(page)
    page.get_by_role("button", name="Pause").click()
    until("the robot to stand", lambda: not frame(page)["playing"])
    settled_digest(page)
    return page


def handle(browser: Browser, server: str) -> tuple[float, float]:
    """Return p95s of milliseconds: from a handle's move to the repainted profile, and what of it the page's code took.

    The rest is the browser's: delivering the event and painting, which share the processor with all else that runs.
    """
    page = paused(browser, server)
    grip = page.locator("figure.profile").get_by_role("slider", name="Hit increment", exact=True)
    grip.scroll_into_view_if_needed()
    box = grip.locator(".handle-grab").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.wait_for_timeout(800)
    page.mouse.down()
    page.evaluate(_STOPWATCH, "profile")
    took = timed(page, lambda i: page.mouse.move(x, y - 12 - 24 * (i % 2)))
    own = [float(ms) for ms in page.evaluate("() => window.ownWork")]
    page.mouse.up()
    page.context.close()
    return p95(took), p95(own)


def teleport(browser: Browser, server: str) -> float:
    """Return the p95 of milliseconds from a click to the first new cells on the canvas."""
    page = paused(browser, server)
    box = page.locator(".picture").first.bounding_box()
    assert box is not None
    page.evaluate(_STOPWATCH, "map")
    places = [[1.5 + 17.0 * ((7 * i) % TIMES) / TIMES, 7.0 - 0.4 * (i % 3)] for i in range(TIMES)]

    def click(i: int) -> None:
        px, py = page.evaluate("(xy) => gridbloom.screen(xy)", places[i])
        page.mouse.click(box["x"] + px, box["y"] + py)

    took = timed(page, click)
    page.context.close()
    return p95(took)


def running(browser: Browser, server: str) -> float:
    """Return frames per second while the lab runs."""
    page = browser.new_context(viewport={"width": 1440, "height": 900}).new_page()
    page.goto(f"{server}/lab.html")
    await_map(page)
    rate = float(page.evaluate(_FRAMES, RUNNING_S))
    page.context.close()
    return rate


def opening(browser: Browser, server: str) -> tuple[float, float]:
    """Return the p95 of seconds from opening the page to its first cells, and kB of JavaScript, gzipped."""
    took = []
    scripts: dict[str, int] = {}

    def keep(response: Response) -> None:
        if response.request.resource_type == "script":
            scripts[response.url] = len(gzip.compress(response.body(), 9))

    for i in range(OPENED):
        page = browser.new_context(viewport={"width": 1440, "height": 900}).new_page()
        page.add_init_script(f"({_FIRST_CELLS})()")
        if i == 0:
            page.on("response", keep)
        page.goto(f"{server}/lab.html")
        page.wait_for_function("() => window.firstCells")
        if i > 0:  # the first visit warms the server
            took.append(float(page.evaluate("() => window.firstCells")) / 1000.0)
        page.context.close()
    return p95(took), sum(scripts.values()) / 1000.0


def busy_share(page: Page) -> float:
    """Return the share of a processor that the page's main thread uses."""
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")

    def task_seconds() -> float:
        metrics: list[dict[str, Any]] = session.send("Performance.getMetrics")["metrics"]
        return next(float(one["value"]) for one in metrics if one["name"] == "TaskDuration")

    page.wait_for_timeout(1500)
    before = task_seconds()
    page.wait_for_timeout(1000 * ASLEEP_S)
    return (task_seconds() - before) / ASLEEP_S


def asleep(browser: Browser, server: str) -> tuple[float, float]:
    """Return the processor shares of a paused page and of a hidden one."""
    page = paused(browser, server)
    still = busy_share(page)
    page.get_by_role("button", name="Play").click()
    page.evaluate(
        "() => { Object.defineProperty(document, 'hidden', { value: true });"
        " document.dispatchEvent(new Event('visibilitychange')); }"
    )
    hidden = busy_share(page)
    page.context.close()
    return still, hidden


def feel() -> None:
    """Print how the lab feels: what was measured, what is wanted at least, what is aimed at."""
    rows: list[tuple[str, str, str, str]] = []
    with tempfile.TemporaryDirectory() as folder, running_server(Path(folder)) as server, running_chromium() as browser:
        seconds, kilobytes = opening(browser, server)
        still, hidden = asleep(browser, server)
        moved, own = handle(browser, server)
        rows += [
            ("handle moved → profile repainted, p95", f"{moved:.1f} ms", "16 ms", "8 ms"),
            ("of which in the page's own code, p95", f"{own:.1f} ms", "", ""),
            ("teleport click → first new cells, p95", f"{teleport(browser, server):.1f} ms", "100 ms", "50 ms"),
            ("lab running at 1440 × 900", f"{running(browser, server):.0f} frames/s", "30", "60"),
            ("page opened → first cells, p95", f"{seconds:.2f} s", "1.5 s", "0.7 s"),
            ("JavaScript of the lab, gzipped", f"{kilobytes:.1f} kB", "120 kB", "60 kB"),
            ("main thread of a paused page", f"{100 * still:.1f} %", "about none", ""),
            ("main thread of a hidden page", f"{100 * hidden:.1f} %", "about none", ""),
        ]
    load = os.getloadavg()[0]
    print(f"\n| the lab in Chromium (load of the machine {load:.1f}) | measured | at least | aim |\n|---|---|---|---|")
    for row in rows:
        print(f"| {' | '.join(row)} |")
