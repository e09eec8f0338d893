"""``python -m tests.bench feel``: latencies of the pages in Chromium on loopback, with their targets."""

from __future__ import annotations

import gzip
import os
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Browser, Page, Response

from tests.bench.hand import Hand
from tests.bench.stopwatch import Laps, dragged, floor, laps, moved, p95
from tests.browser.looking import await_map, centre, frame, open_group, settled_digest, until
from tests.browser.running import free_port, running_chromium, running_server
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded

MOVED = 120  # of each handle, one move after the other
TIMES = 40  # of each other hand movement
MOVES = 200  # of each drag
OPENED = 8  # of the page
FOUR_VIEWS = "?views=four:world,map,3d,second:50:50"
PLOTTED = "?views=four:world,map,plots,frames:50:50"
RUNNING_S = 4.0
PLAYED_S = 20  #: of a log in four views
PARTICLES = 10_000  # as many as the lab draws at most
ASLEEP_S = 3.0
LOG = "intel-corrected.log.gz"

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


def new_page(browser: Browser) -> Page:
    """Return a page of a fresh visitor at the size that the figures are wanted for."""
    return browser.new_context(viewport={"width": 1440, "height": 900}).new_page()


def paused(browser: Browser, server: str, query: str = "") -> Page:
    """Return the lab, standing still."""
    page = new_page(browser)
    page.goto(f"{server}/lab.html{query}")
    await_map(page)
    page.get_by_role("button", name="Pause").click()
    until("the robot to stand", lambda: not frame(page)["playing"])
    settled_digest(page)
    return page


def nothing(browser: Browser, hand: Hand) -> tuple[Laps, Laps]:
    """Return the laps of a page with nothing in it, move by move and dragged."""
    page = new_page(browser)
    took = floor(page, hand, MOVED, MOVES)
    page.context.close()
    return took


def handle(browser: Browser, server: str, hand: Hand, query: str = "") -> tuple[Laps, Laps]:
    """Return the laps from a handle's move to the repainted profile, while the map follows: move by move, and dragged.

    It is dragged while the lab runs. ``query`` of the lab's address names its views.
    """
    page = paused(browser, server, query)
    grip = page.locator("figure.profile").get_by_role("slider", name="Hit increment", exact=True)
    single = moved(page, grip.locator(".handle-mark"), MOVED, dy=-24.0)
    page.get_by_role("button", name="Play").click()
    until("the robot to go", lambda: frame(page)["playing"])
    drag = dragged(page, grip.locator(".handle-mark"), hand, MOVES, dy=-60.0)
    page.context.close()
    return single, drag


def teleport(browser: Browser, server: str) -> Laps:
    """Return the laps from a click to the first new cells on the canvas."""
    page = paused(browser, server)
    box = page.locator(".picture").first.bounding_box()
    assert box is not None
    places = [[1.5 + 17.0 * ((7 * i) % TIMES) / TIMES, 7.0 - 0.4 * (i % 3)] for i in range(TIMES)]

    def click(i: int) -> None:
        px, py = page.evaluate("(xy) => gridbloom.screen(xy)", places[i])
        page.mouse.click(box["x"] + px, box["y"] + py)

    took = laps(page, ["pointerup"], "map", click, TIMES)
    page.context.close()
    return took


def goal(browser: Browser, server: str) -> Laps:
    """Return the laps from a move of the dragged goal to the path that is painted for it, in the office's plan."""
    page = paused(browser, server)
    open_group(page, "Path")
    page.get_by_role("button", name="Make the robot 1 m wide").click()
    page.get_by_role("button", name="Make it narrow again").click()
    path = "gridbloom.connection.store.part('path').message.peek()"
    page.wait_for_function(f"() => {path}?.reaches_goal")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    box = page.locator(".lab .picture").last.bounding_box()
    assert box is not None
    at = [[7.2 + 0.3 * ((7 * i) % TIMES) / TIMES, 9.2 + 0.1 * (i % 5)] for i in range(TIMES)]

    def move(i: int) -> None:
        px, py = page.evaluate("(xy) => gridbloom.screen(xy)", at[i])
        page.mouse.move(box["x"] + px, box["y"] + py)

    px, py = page.evaluate(f"() => gridbloom.screen({path}.goal)")
    page.mouse.move(box["x"] + px, box["y"] + py)
    page.mouse.down()
    took = laps(page, ["pointermove"], "path", move, TIMES)
    page.context.close()
    return took


def lecture(browser: Browser, server: str, hand: Hand) -> dict[str, tuple[Laps, Laps]]:
    """Return the laps of the handles of five figures of the lecture, move by move and dragged."""
    page = new_page(browser)
    page.goto(f"{server}/lecture.html")
    page.locator("#model").get_by_label("Model", exact=True).select_option("fixed_increments")
    grips = {
        "profile": ("#model", "figure.profile", "Hit increment", ".handle-mark", 0.0, -24.0),
        "rays": ("#rays", "figure.rays", "Last cell of the line", ".drag-handle-dot", -40.0, 30.0),
        "matching": ("#matching", "figure.matching", "Position of the moving scan", ".robot-shape", 40.0, 24.0),
        "graph": ("#graph", "figure.springs", "Pose 9", ".robot-shape", 30.0, 30.0),
        "thresholds": ("#file", "figure.thresholds", "Occupied above", ".pill", 30.0, 0.0),
    }
    took = {}
    for name, (section, figure, label, part, dx, dy) in grips.items():
        page.locator(section).scroll_into_view_if_needed()
        grip = page.locator(figure).get_by_role("slider", name=label, exact=True)
        grip.scroll_into_view_if_needed()
        held = grip.locator(part)
        single = moved(page, held, MOVED, dx=dx, dy=dy)
        took[name] = single, dragged(page, held, hand, MOVES, dx=2.5 * dx, dy=2.5 * dy)
    page.context.close()
    return took


def _whole_log(browser: Browser, server: str) -> Page:
    """Return a page with the real log at its end."""
    page = new_page(browser)
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text=LOG).get_by_role("button", name="Open map").click()
    page.wait_for_function("() => window.gridbloom && gridbloom.connection.store.frame.peek()")
    page.get_by_role("slider", name="Scans in the map").focus()
    page.keyboard.press("End")
    until("the end of the log", lambda: frame(page)["index"] == frame(page)["count"])
    settled_digest(page)
    return page


def goal_on_log(browser: Browser, server: str) -> Laps:
    """Return the laps as :func:`goal`, on the whole map of the real log, with goals all over the robot's path."""
    page = _whole_log(browser, server)
    open_group(page, "Path")
    path = "gridbloom.connection.store.part('path').message.peek()"
    page.wait_for_function("() => gridbloom.connection.store.part('costmap').message.peek()?.is_on")
    poses = page.evaluate("() => gridbloom.connection.store.trajectory.peek().poses")
    box = page.locator(".viewer .picture").bounding_box()
    assert box is not None
    at = [poses[(37 * i) % len(poses)] for i in range(TIMES + 1)]

    def place(point: list[float]) -> tuple[float, float]:
        px, py = page.evaluate("(xy) => gridbloom.screen(xy)", point)
        return box["x"] + px, box["y"] + py

    page.mouse.click(*place(at[TIMES]))
    page.wait_for_function(f"() => {path}?.reaches_goal")
    page.mouse.move(*place(page.evaluate(f"() => {path}.goal")))
    page.mouse.down()
    took = laps(page, ["pointermove"], "path", lambda i: page.mouse.move(*place(at[i])), TIMES)
    page.context.close()
    return took


def retuned(browser: Browser, server: str) -> tuple[Laps, Laps]:
    """Return the laps from a slider's move to the whole map of the real log, made again and repainted.

    First those of the map alone, then those of its difference from the map of before, which stands beside it.
    """
    page = _whole_log(browser, server)
    single_threaded = _slid(page)
    open_group(page, "Compare")
    page.get_by_role("button", name="Save as A").click()
    page.locator(".compare-mode .choice-option", has_text="Difference").click()
    until(
        "the numbers",
        lambda: page.evaluate("() => gridbloom.connection.store.part('comparison').message.peek()?.numbers"),
    )
    settled_digest(page)
    compared = _slid(page)
    page.context.close()
    return single_threaded, compared


def _slid(page: Page) -> Laps:
    """Return the laps of a slider of the settings that moves to and fro over a log's page."""
    open_group(page, "Settings")
    slider = page.get_by_role("slider", name="Max range", exact=True).and_(page.locator("input[type=range]"))
    slider.scroll_into_view_if_needed()
    x, y = centre(slider)
    box = slider.bounding_box()
    assert box is not None
    x = box["x"] + 0.5 * box["width"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.wait_for_timeout(1000)
    settled_digest(page)
    took = laps(page, ["input"], "whole map", lambda i: page.mouse.move(x - 20 - 40 * (i % 2), y), TIMES)
    page.mouse.up()
    return took


def running(browser: Browser, server: str, query: str = "") -> float:
    """Return frames per second while the lab runs."""
    page = new_page(browser)
    page.goto(f"{server}/lab.html{query}")
    await_map(page)
    rate = float(page.evaluate(_FRAMES, RUNNING_S))
    page.context.close()
    return rate


def running_with_particles(browser: Browser, server: str) -> tuple[float, float]:
    """Return frames per second, and the share of the main thread, while the lab draws 10,000 particles at each frame.

    The filter keeps as many, and the lab runs: the robot moves in each frame, and the whole picture is painted.
    """
    page = new_page(browser)
    page.goto(f"{server}/lab.html")
    await_map(page)
    page.evaluate(
        """(n) => gridbloom.connection.store.send({ type: 'localize', value: true,
          values: { min_particles: n, max_particles: n, global_particles: n } })""",
        PARTICLES,
    )
    drawn = "gridbloom.connection.store.layers.content('particles').peek()?.columns[0].length"
    open_group(page, "Localize")
    page.wait_for_function(f"(n) => {drawn} === n", arg=PARTICLES)
    rate = float(page.evaluate(_FRAMES, RUNNING_S))
    busy = busy_share(page)
    assert page.evaluate(f"() => {drawn}") == PARTICLES
    page.context.close()
    return rate, busy


def beside_views(browser: Browser, server: str, folder: Path) -> tuple[Laps, float]:
    """Return the laps from a handle's move to the repainted profile on the page of a log with four views.

    And frames per second while the log plays: map, picture, plots and log lines follow its time.
    """
    said = list(robot(PLAYED_S))
    for n in range(10 * PLAYED_S):
        at = T0 + n * recorded.SECOND // 10
        said.append(image(np.full((480, 640), n % 250, dtype=np.uint8), "mono8", at))
        said.append(recorded.log_line(at, 20, f"Line {n}"))
    (folder / "robot.mcap").write_bytes(recorded.mcap_bytes(said))
    page = new_page(browser)
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(folder / "robot.mcap")
    await_map(page)
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    until("the log to stand", lambda: not frame(page)["playing"])
    page.get_by_label("Layout", exact=True).select_option(label="Moment")
    page.get_by_role("region", name="Pictures").get_by_role("img").wait_for()
    page.get_by_role("region", name="Plots", exact=True).locator("canvas").first.wait_for()
    open_group(page, "Settings")
    grip = page.locator("figure.profile").get_by_role("slider", name="Hit increment", exact=True)
    grip.scroll_into_view_if_needed()
    settled_digest(page)
    single = moved(page, grip.locator(".handle-mark"), MOVED, dy=-24.0)
    page.evaluate("() => gridbloom.connection.store.send({ type: 'seek', index: 1 })")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'play' })")
    until("the log to play", lambda: frame(page)["playing"])
    rate = float(page.evaluate(_FRAMES, RUNNING_S))
    assert frame(page)["playing"]
    page.context.close()
    return single, rate


def opening(browser: Browser, server: str) -> tuple[float, float]:
    """Return the p95 of seconds from opening the page to its first cells, and kB of JavaScript, gzipped."""
    took = []
    scripts: dict[str, int] = {}

    def keep(response: Response) -> None:
        if response.request.resource_type == "script":
            scripts[response.url] = len(gzip.compress(response.body(), 9))

    for i in range(OPENED):
        page = new_page(browser)
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
    """Print how the pages feel: what was measured, what is wanted at least, what is aimed at, and where time goes."""
    rows: list[tuple[str, ...]] = []

    def row(what: str, took: Laps, least: str, aim: str) -> None:
        rows.append((what, took.told(), least, aim, took.parts()))

    with tempfile.TemporaryDirectory() as folder:
        logs = Path(folder) / "logs"
        logs.mkdir()
        real = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data")) / "carmen" / LOG
        if real.is_file():
            shutil.copy(real, logs)
        else:
            print(f"{LOG}: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
        port = free_port()
        with (
            running_server(Path(folder), "--logs-dir", str(logs)) as server,
            running_chromium(f"--remote-debugging-port={port}") as browser,
        ):
            hand = Hand(port)
            single, drag = nothing(browser, hand)
            row("an empty page's rectangle: the floor", single, "", "")
            row("the same dragged", drag, "", "")
            single, drag = handle(browser, server, hand)
            row("handle moved → profile repainted", single, "16 ms", "8 ms")
            row("the same dragged, while the lab runs", drag, "", "")
            single, drag = handle(browser, server, hand, FOUR_VIEWS)
            row("handle moved → profile repainted, with four views", single, "16 ms", "")
            row("the same dragged, while the lab runs", drag, "", "")
            for figure, (single, drag) in lecture(browser, server, hand).items():
                row(f"the lecture's {figure}: handle moved → repainted", single, "16 ms", "8 ms")
                row("the same dragged", drag, "", "")
            row("teleport click → first new cells", teleport(browser, server), "100 ms", "50 ms")
            row("goal dragged → path repainted", goal(browser, server), "50 ms", "")
            if real.is_file():
                row("goal dragged → path repainted on the whole Intel map", goal_on_log(browser, server), "50 ms", "")
                single_threaded, compared = retuned(browser, server)
                row("slider moved → the whole Intel map", single_threaded, "150 ms", "50 ms")
                row("the same while comparing → its difference", compared, "", "")
            single, beside_rate = beside_views(browser, server, Path(folder))
            row("handle moved → profile repainted, beside a log in four views", single, "16 ms", "8 ms")
            seconds, kilobytes = opening(browser, server)
            still, hidden = asleep(browser, server)
            particle_rate, busy = running_with_particles(browser, server)
            rows += [
                ("lab running at 1440 × 900", f"{running(browser, server):.0f} frames/s", "30", "60", ""),
                ("the same with four views", f"{running(browser, server, FOUR_VIEWS):.0f} frames/s", "60", "60", ""),
                ("the same with plots and frames", f"{running(browser, server, PLOTTED):.0f} frames/s", "60", "60", ""),
                (f"the same with {PARTICLES:,} particles", f"{particle_rate:.0f} frames/s", "60", "60", ""),
                ("main thread of that page", f"{100 * busy:.0f} %", "below 100 %", "", ""),
                ("a log playing in four views", f"{beside_rate:.0f} frames/s", "30", "60", ""),
                ("page opened → first cells", f"{seconds:.2f} s", "1.5 s", "0.7 s", ""),
                ("JavaScript of the lab, gzipped", f"{kilobytes:.1f} kB", "120 kB", "60 kB", ""),
                ("main thread of a paused page", f"{100 * still:.1f} %", "about none", "", ""),
                ("main thread of a hidden page", f"{100 * hidden:.1f} %", "about none", "", ""),
            ]
    load = os.getloadavg()[0]
    print(f"\n| in Chromium, p95 (load of the machine {load:.1f}) | measured | at least | aim | p95 of the parts, ms |")
    print("|---|---|---|---|---|")
    for cells in rows:
        print(f"| {' | '.join(cells)} |")
