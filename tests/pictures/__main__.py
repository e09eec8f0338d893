"""Take the README's screenshots of the running program: ``python -m tests.pictures``.

The pictures of real logs are only taken where GRIDBLOOM_TEST_DATA names the folder of real logs.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, ViewportSize, expect

from tests.browser.looking import await_map, frame, open_group, settled_digest, until
from tests.browser.running import running_chromium, running_server

HERE = Path(__file__).parent
# Asks why the most certain cell of a wall within 3 m of the robot is what it is.
_EXPLAIN_WALL = """() => {
  const { store } = gridbloom.connection;
  const { geometry, cells } = store.map.peek();
  const [x, y] = store.frame.peek().pose;
  let [most, at] = [-Infinity, [x, y]];
  for (let row = 0; row < geometry.rows; row++)
    for (let col = 0; col < geometry.cols; col++) {
      const [px, py] = [col, row].map((k, i) => geometry.origin[i] + (k + 0.5) * geometry.resolution);
      const value = cells.at(row, col);
      if (Math.hypot(px - x, py - y) < 3 && value > most) [most, at] = [value, [px, py]];
    }
  store.explain(at);
}"""
SIZE: ViewportSize = {"width": 1440, "height": 900}


def save(page: Page, name: str) -> None:
    """Keep what is on the screen, in a palette: a third of the bytes, and the eye sees no difference."""
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    picture.quantize(192, dither=Image.Dither.NONE).save(HERE / f"{name}.png", optimize=True)


def walk(page: Page, seconds: int) -> None:
    """Have the robot walk for simulated seconds, of ten scans each, and stand then."""
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    until("the robot to stand", lambda: not frame(page)["playing"])
    for _ in range(0, seconds, 10):
        before = frame(page)["stamp"]
        page.evaluate("() => gridbloom.connection.store.send({ type: 'step', scans: 100 })")
        until("ten seconds of the walk", lambda before=before: frame(page)["stamp"] >= before + 9.9)  # type: ignore[misc]


def lab(page: Page, server: str) -> None:
    """The lab after two minutes of the robot's walk, with a cell under the pointer."""
    page.goto(f"{server}/lab.html")
    await_map(page)
    walk(page, 120)
    box = page.locator(".picture").nth(1).bounding_box()
    assert box is not None
    x, y = page.evaluate("(xy) => gridbloom.screen(xy)", frame(page)["pose"][:2])
    page.mouse.move(box["x"] + x - 40, box["y"] + y + 8)
    page.wait_for_timeout(1500)
    save(page, "lab")


def front(page: Page, server: str) -> None:
    """The front page after a minute of the robot's walk."""
    page.goto(server)
    await_map(page)
    walk(page, 60)
    page.wait_for_timeout(1500)
    save(page, "front")


def log(page: Page, server: str) -> None:
    """The Intel Research Lab at the end of its log, with the beams of one cell of a wall."""
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="intel-corrected").get_by_role("button", name="Open map").click()
    page.wait_for_function("() => window.gridbloom && gridbloom.connection.store.frame.peek()")
    page.get_by_role("slider", name="Scans in the map").focus()
    page.keyboard.press("End")
    until("the end of the log", lambda: frame(page)["index"] == frame(page)["count"])
    settled_digest(page)
    page.evaluate(_EXPLAIN_WALL)
    expect(page.get_by_role("tabpanel", name="Why")).to_contain_text(re.compile(r"\d+ of [1-9]\d*"))
    expect(page.locator(".viewer-map .working")).to_have_count(0)
    page.wait_for_timeout(1500)
    save(page, "log")


def healed(page: Page, server: str) -> None:
    """ACES, Austin: the map along its odometry under the swipe, beside the map along the poses of SLAM."""
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="aces").get_by_role("button", name="Open map").click()
    page.wait_for_function("() => window.gridbloom && gridbloom.connection.store.frame.peek()")
    panel = open_group(page, "Heal").get_by_role("region", name="Heal its poses")
    panel.get_by_role("button", name="Heal its poses").click()
    panel.get_by_role("button", name="Compare with before").click(timeout=900_000)
    expect(page.get_by_role("slider", name=re.compile("divider", re.IGNORECASE))).to_be_visible()
    settled_digest(page)
    page.wait_for_timeout(1500)
    save(page, "healed")


def lecture(page: Page, server: str) -> None:
    """A section of the lecture beside the list of all of them."""
    page.goto(f"{server}/lecture.html#mount")
    figure = page.locator("#mount figure")
    figure.scroll_into_view_if_needed()
    page.wait_for_timeout(800)
    save(page, "lecture")


def main() -> None:
    """Take them all."""
    data = os.environ.get("GRIDBLOOM_TEST_DATA")
    with tempfile.TemporaryDirectory() as folder:
        logs = Path(folder) / "logs"
        logs.mkdir()
        if data:
            for name in ("intel-corrected", "aces"):
                shutil.copy(Path(data) / "carmen" / f"{name}.log.gz", logs)
        with running_server(Path(folder) / "data", "--logs-dir", str(logs)) as server, running_chromium() as browser:
            page = browser.new_page(viewport=SIZE, color_scheme="light")
            page.set_default_timeout(120_000)  # of a loaded machine
            front(page, server)
            lab(page, server)
            lecture(page, server)
            if data:
                log(page, server)
                healed(page, server)


if __name__ == "__main__":
    main()
