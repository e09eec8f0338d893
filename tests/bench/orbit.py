"""``python -m tests.bench orbit``: frames/s of a 3D view of 5 million points in Chromium, while one turns it."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser

from tests.bench.feel import new_page
from tests.browser.looking import await_true, until
from tests.browser.running import running_chromium, running_server

POINTS = 5_000_000
TURNS_S = 6.0  #: of turning, of which the first half lets the number of points settle
RESTS_S = 60.0  #: at most, after the turning, until all points are in the picture
SIDE_M = 60.0

# Points are drawn by calls of drawArrays; the script of the view may draw fewer. Of each frame: its time, how many it
# draws, and the number of the first one of a cloud; a frame that begins with number 0 begins the picture again.
_COUNTING = """(draws_all) => {
  const native = WebGL2RenderingContext.prototype.drawArrays;
  const draw = function (mode, first, count) {
    if (mode === this.POINTS) {
      const now = document.timeline.currentTime;
      const last = window.drawn.at(-1);
      if (last && last[0] === now) last[1] += count;
      else window.drawn.push([now, count, first]);
    }
    native.call(this, mode, first, count);
  };
  window.drawn = [];
  if (draws_all) {
    Object.defineProperty(WebGL2RenderingContext.prototype, "drawArrays", { get: () => draw, set: () => {} });
  } else WebGL2RenderingContext.prototype.drawArrays = draw;
}"""


_PICTURE = """() => {
  let points = 0;
  for (let n = drawn.length - 1; n >= 0; n--) {
    points += drawn[n][1];
    if (drawn[n][2] === 0 && drawn[n][1] > 0) break;
  }
  return points;
}"""


def _cloud(path: Path) -> None:
    """Write hills with a wall as a binary PCD of :data:`POINTS` points."""
    random = np.random.default_rng(1)
    points = random.uniform(0.0, SIDE_M, (POINTS, 3))
    points[:, 2] = 2.0 * np.sin(points[:, 0] / 7.0) * np.cos(points[:, 1] / 9.0)
    points[::10, 1], points[::10, 2] = SIDE_M / 2, random.uniform(0.0, 8.0, POINTS // 10)
    head = (
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {POINTS}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {POINTS}\nDATA binary\n"
    )
    path.write_bytes(head.encode() + points.astype("<f4").tobytes())


def _turned(browser: Browser, server: str, *, draws_all: bool) -> tuple[float, float, int, int, float, float]:
    """Return what was seen of the frames.

    While turned: frames/s, the longest frame, ms, and the points in one. At rest: the points in the picture, after how
    many seconds, and the longest frame until then, ms.
    """
    page = new_page(browser)
    page.set_default_timeout(300_000)  # the file is read first
    page.add_init_script(f"if (location.pathname.startsWith('/scenes/')) ({_COUNTING})({str(draws_all).lower()})")
    page.goto(f"{server}/logs.html")
    page.locator(".log-card").get_by_role("button", name="Open in 3D").click()
    await_true(page, "() => window.gridbloom?.connection.store.part('volume').message.peek()?.pending === 0")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'volume_look', values: { show: 'points' } })")
    view = page.locator("iframe.volume-scene")
    frame = view.element_handle().content_frame()
    assert frame is not None
    until("the points are drawn", lambda: frame.evaluate(_PICTURE) > POINTS / 2)
    box = view.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 3
    page.mouse.move(x, y)
    page.mouse.down()
    began = frame.evaluate("() => document.timeline.currentTime")
    now, step = began, 0
    while now < began + 1000.0 * TURNS_S:
        step += 1
        page.mouse.move(x + 150 * np.sin(step / 20), y + 60 * np.sin(step / 33))
        now = frame.evaluate("() => document.timeline.currentTime")
    page.mouse.up()
    half = began + 500.0 * TURNS_S
    frames = [one for one in frame.evaluate("() => drawn") if half <= one[0] <= now]
    times = np.array([one[0] for one in frames])
    until("a frame at rest", lambda: frame.evaluate("() => drawn.at(-1)[0]") > now + 500.0)
    while (
        frame.evaluate(_PICTURE) < POINTS
        and frame.evaluate("() => document.timeline.currentTime") < now + 1000 * RESTS_S
    ):
        page.wait_for_timeout(100)
    rested = frame.evaluate(_PICTURE)
    at_rest = np.array([one[0] for one in frame.evaluate("() => drawn") if one[0] > now and one[1] > 0])
    page.context.close()
    rate = 1000.0 * (len(times) - 1) / float(times[-1] - times[0])
    points = int(np.median([one[1] for one in frames]))
    return (
        rate,
        float(np.diff(times).max()),
        points,
        rested,
        (at_rest[-1] - now) / 1000.0,
        float(np.diff(at_rest).max()),
    )


def orbit() -> None:
    """Print the frames/s while all points are drawn in each frame, and while the view decides how many."""
    with tempfile.TemporaryDirectory() as folder:
        logs = Path(folder) / "logs"
        logs.mkdir()
        _cloud(logs / "hills.pcd")
        with (
            running_server(Path(folder), "--logs-dir", str(logs)) as server,
            running_chromium() as browser,
        ):
            for draws_all, name in ((True, "all of them in each frame"), (False, "as many as are drawn quickly")):
                rate, longest, points, rested, after, longest_at_rest = _turned(browser, server, draws_all=draws_all)
                print(
                    f"{POINTS:,} points, {name}: {rate:.1f} frames/s, {points:,} points, longest frame "
                    f"{longest:.0f} ms; {rested:,} points {after:.1f} s later, longest frame {longest_at_rest:.0f} ms"
                )
