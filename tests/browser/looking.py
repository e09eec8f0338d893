"""Reading of a page by the browser tests: the map in the browser, and the state of its figures."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import json
import re
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import urlsplit

from playwright.sync_api import Frame, Locator, Page, Route, expect

from tests.server.service import Watcher, stream_at

POLLING_MS = 50.0  # between two looks at what a page is waited for
SECONDS = 240.0  # how long anything may take on a machine with other work to do before a test fails

# The geometry, and SHA-256 over every byte of the map that the browser holds.
_MAP_DIGEST = """async () => {
  const map = gridbloom.connection.store.map.peek();
  if (!map) return null;
  const { rows, cols } = map.geometry;
  const bytes = new Uint8Array(rows * cols);
  for (let row = 0, i = 0; row < rows; row++)
    for (let col = 0; col < cols; col++) bytes[i++] = map.cells.at(row, col);
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", bytes));
  return [map.geometry, [...digest].map(byte => byte.toString(16).padStart(2, "0")).join("")];
}"""

# Waits until the session has carried out what the page has asked of it: commands are carried out in their turn, so
# the answer about a cell comes after them. What the page sends with its next animation frame is sent before. It is
# another cell than the last time: where an answer came late and was asked for again, the second one may still come.
_CARRIED_OUT = """async () => {
  await new Promise(requestAnimationFrame);
  const { store } = gridbloom.connection;
  const geometry = store.map.peek()?.geometry;
  const col = window.askedCol = ((window.askedCol ?? 0) + 1) % Math.min(16, geometry?.cols ?? 1);
  const before = store.inspected.peek();
  for (let waited = 0, askedAt = -Infinity; ; waited += 5) {
    const now = store.inspected.peek();
    if (now !== before && now?.row === 0 && now.col === col) return;
    if (waited - askedAt >= 300) {  // an answer fails to come where another map has begun meanwhile
      askedAt = waited;
      store.send({ type: "inspect", row: 0, col, epoch: store.map.peek()?.geometry.epoch ?? 0 });
    }
    await new Promise(resolve => setTimeout(resolve, 5));
  }
}"""

#: Bytes as a text: numbers in JSON, as Playwright takes them, are slow for a map of a million cells.
BASE64 = """bytes => {
  const texts = [];
  for (let i = 0; i < bytes.length; i += 4096) texts.push(String.fromCharCode(...bytes.slice(i, i + 4096)));
  return btoa(texts.join(""));
}"""

_MAP_BYTES = f"""() => {{
  const map = gridbloom.connection.store.map.peek();
  const {{ rows, cols }} = map.geometry;
  const bytes = [];
  for (let row = 0; row < rows; row++) for (let col = 0; col < cols; col++) bytes.push(map.cells.at(row, col));
  return {{ ...map.geometry, bytes: ({BASE64})(bytes) }};
}}"""


def until(what: str, condition: Callable[[], Any], seconds: float = SECONDS) -> Any:
    """Return the first true value of ``condition``; fail the test, saying ``what`` was awaited, when none comes.

    A condition that takes long, such as a picture of a 3D view, takes a third of the time at most: the page and the
    service need the processor for what is awaited.
    """
    deadline = time.monotonic() + seconds
    while True:
        began = time.monotonic()
        value = condition()
        if value:
            return value
        now = time.monotonic()
        assert now < deadline, f"waited {seconds:g} s in vain: {what}"
        time.sleep(max(POLLING_MS / 1000.0, 2.0 * (now - began)))


def await_true(page: Page, condition: str, arg: Any = None) -> None:
    """Wait until a JavaScript function, given ``arg``, returns something true on the page.

    It is called by a timer: in each animation frame, as Playwright does unless told otherwise, the page and Chromium
    would make 60 frames a second of a page on which nothing changes.
    """
    page.wait_for_function(condition, arg=arg, polling=POLLING_MS)


_BAR_VALUE = "bars => bars[0]?.getAttribute('aria-valuenow') ?? null"
"""The value of the first progress bar, in percent; null if there is none."""


def await_end(progress: Locator) -> None:
    """Wait until a progress bar is gone, for as long as its value goes on changing."""
    value = progress.evaluate_all(_BAR_VALUE)
    while value is not None:
        before = value

        def changed(before: str = before) -> bool:
            return progress.evaluate_all(_BAR_VALUE) != before  # type: ignore[no-any-return]

        until(f"the progress bar leaves {before}", changed)
        value = progress.evaluate_all(_BAR_VALUE)


def map_digest(page: Page | Frame) -> str:
    """Return a digest of the map that the browser holds."""
    held = page.evaluate(_MAP_DIGEST)
    return "no map" if held is None else _digest(*held)


def _digest(geometry: dict[str, Any], cells: str) -> str:
    numbers = [geometry[name] for name in ("rows", "cols", "resolution", "low", "high")]
    return " ".join([*(f"{float(number):.9g}" for number in [*numbers, *geometry["origin"]]), cells])


def _served_digest(page: Page) -> str:
    """Return the digest of the map that the page's session has, as a client of its own gets it that has nothing yet."""
    session = page.evaluate("() => gridbloom.connection.store.hello.peek().session")
    address = f"ws://{urlsplit(page.url).netloc}/api/sessions/{session}/stream"

    async def get() -> str:
        async with stream_at(address) as socket:
            watcher = Watcher(socket)
            await watcher.until(lambda: watcher.complete)
            cells = watcher.picture.view("uint8") ^ 0x80  # int8 −128 … 127 is 0 … 255 in the browser
            return _digest(watcher.newest["geometry"], hashlib.sha256(cells.tobytes()).hexdigest())

    with ThreadPoolExecutor(1) as apart:  # Playwright's own event loop runs in this thread
        return apart.submit(asyncio.run, get()).result(SECONDS)


def carried_out(page: Page) -> None:
    """Wait until the session has carried out what the page has asked of it, and the page has the map of it."""
    page.evaluate(_CARRIED_OUT)


def settled_digest(page: Page) -> str:
    """Return the digest of a standing session's map, after all that the page asked for, once the page has it too."""
    carried_out(page)

    def same() -> str | None:
        digest = _served_digest(page)
        return digest if map_digest(page) == digest else None

    return str(until("the session's map on the page", same))


def map_bytes(page: Page) -> dict[str, Any]:
    """Return the geometry of the browser's map with ``bytes``, row by row from the smallest y, 0 for never observed."""
    result: dict[str, Any] = page.evaluate(_MAP_BYTES)
    return result | {"bytes": base64.b64decode(result["bytes"])}


def observed(page: Page) -> int:
    """Return how many cells of the browser's map were ever observed."""
    return int(page.evaluate("() => Object.values(gridbloom.cells()).reduce((a, b) => a + b, 0)"))


def without_canvas_in_3d(page: Page) -> None:
    """Leave the canvas of the page's 3D views empty: its drawing by the processor takes seconds.

    The views are asked for their settings, as the canvas would make the service open them.
    """

    def empty(route: Route) -> None:
        view, _ = route.request.url.split("/plain/")
        expect(page.request.get(f"{view}/settings")).to_be_ok()
        route.fulfill(content_type="text/html", body="<!doctype html><title>3D</title>")

    page.route("**/scenes/*/plain/**", empty)


def frame(page: Page) -> dict[str, Any]:
    """Return the newest frame message that the page has; it may have to wait for the first."""
    newest = "() => window.gridbloom?.connection.store.frame.peek()"
    while not (found := page.evaluate(newest)):
        await_true(page, newest)
    return dict(found)


def end_session(page: Page) -> None:
    """End the session that the page watches, behind its back."""
    session = page.evaluate("() => gridbloom.connection.store.hello.peek().session")
    origin = "{0.scheme}://{0.netloc}".format(urlsplit(page.url))
    assert page.request.delete(f"{origin}/api/sessions/{session}").status == 204


def open_group(page: Page, title: str) -> Locator:
    """Open a group of a dock, and before it the section that it is in; return its panel."""
    # A tab may have a number or "on" behind its title; titles may begin and end alike.
    name = re.compile(rf"^{re.escape(title)}(?! ?(?!on$)[a-z])")
    tab = page.get_by_role("tab", name=name)
    # The hint of a section's tab has the titles of its groups.
    section = page.locator(".dock-tabs").get_by_title(re.compile(rf"(^|, ){re.escape(title)}(, |$)"))
    tab.or_(section).first.wait_for()
    if not tab.count():
        section.click()
    tab.click()
    return page.get_by_role("tabpanel", name=name)


def told(page: Page) -> dict[str, Any]:
    """Return what the lab's address tells of its world: JSON, deflated, in letters that an address may hold."""
    letters = urlsplit(page.evaluate("() => location.href")).fragment.removeprefix("s=")
    if not letters:
        return {}
    told: dict[str, Any] = json.loads(zlib.decompress(base64.urlsafe_b64decode(letters + "=="), wbits=-15))
    return told


def open_groups(page: Page, every: int = 1) -> Iterator[str]:
    """Open one group of a dock in ``every`` in turn, the first one of all; give their titles."""
    number = 0
    for section in page.locator(".dock-tabs").get_by_role("tab").all():
        section.click()
        expect(section).to_have_attribute("aria-selected", "true")
        for tab in page.locator(".dock-subtabs").get_by_role("tab").all() or [section]:
            number += 1
            if (number - 1) % every:
                continue
            tab.click()
            expect(tab).to_have_attribute("aria-selected", "true")
            yield tab.inner_text().split("\n")[0]


def open_sample(page: Page, server: str) -> None:
    """Open the sample log from the list of logs."""
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()


def await_map(page: Page) -> None:
    """Wait until the page holds a map with something in it."""
    await_true(page, "() => window.gridbloom && gridbloom.cells().free > 50")


def centre(locator: Locator) -> tuple[float, float]:
    """Return the middle of an element, in CSS pixels of the viewport, scrolled into view."""
    locator.scroll_into_view_if_needed()
    box = locator.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


#: Resolves when an element has stayed at its place for a while.
STILL = """async (element) => {
  for (let place = "", since = 0; performance.now() - since < 150 || place === ""; ) {
    await new Promise(requestAnimationFrame);
    const box = element.getBoundingClientRect();
    const now = [box.x, box.y, box.width, box.height].join(" ");
    if (now !== place) since = performance.now();
    place = now;
  }
}"""

# Resolves when the pictures of the map are no longer repainted: no highlight fades, no animation runs.
_PAINTED = """async () => {
  for (let paints = -1, same = 0; same < 3; ) {
    await new Promise(requestAnimationFrame);
    const now = gridbloom.stats().paints;
    same = now === paints ? same + 1 : 0;
    paints = now;
  }
}"""


def painted(page: Page) -> None:
    """Wait until the pictures of a standing map have come to rest."""
    page.evaluate(_PAINTED)


def frames(page: Page, n: int) -> None:
    """Let the page draw ``n`` animation frames, at most 60 in a second: what moves by itself moves in them.

    On a busy machine they take longer; a wait of so many milliseconds could end there before the page has done a thing.
    """
    page.evaluate("async (n) => { for (let i = 0; i < n; i++) await new Promise(requestAnimationFrame); }", n)


def still(locator: Locator) -> tuple[float, float]:
    """Return the middle of an element once it has stopped moving, in CSS pixels of the viewport, scrolled into view."""
    locator.scroll_into_view_if_needed()
    locator.evaluate(STILL)
    return centre(locator)


def place_on(picture: Locator, xy: Sequence[float]) -> tuple[float, float]:
    """Return where a place of the world, metres, lies on its picture, in CSS pixels of the viewport."""
    box = picture.bounding_box()
    assert box is not None
    x, y = picture.page.evaluate("(xy) => gridbloom.screen(xy)", list(xy))
    return box["x"] + x, box["y"] + y


def drag_along(page: Page, *places: tuple[float, float], steps: int = 3) -> None:
    """Drag with the mouse from the first of some places of the viewport along the others."""
    page.mouse.move(*places[0])
    page.mouse.down()
    for one in places[1:]:
        page.mouse.move(*one, steps=steps)
    page.mouse.up()


def drag(page: Page, locator: Locator, dx: float, dy: float) -> None:
    """Go to an element with the mouse, and when it stands still under it drag it by its middle."""
    page.mouse.move(*centre(locator))
    x, y = still(locator)
    drag_along(page, (x, y), (x + dx, y + dy), steps=6)
