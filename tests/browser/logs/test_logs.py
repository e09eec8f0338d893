"""The logs page in Chromium: choose and upload a log, watch it fill in, seek, change parameters, download."""

from __future__ import annotations

import io
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from PIL import Image
from playwright.sync_api import BrowserContext, Page, expect

from tests.browser.looking import (
    SECONDS,
    await_map,
    await_true,
    drag,
    drag_along,
    frame,
    map_bytes,
    map_digest,
    open_group,
    open_sample,
    painted,
    settled_digest,
    until,
)
from tests.browser.pages.test_axe import violations
from tests.hostile.corpus import SONAR_POSES, SONAR_READINGS
from tests.mapper.io.logs.containers.test_split import split
from tests.server.frayed_line import FrayedLine
from tests.server.library.small_logs import carmen

pytestmark = pytest.mark.moving


@pytest.fixture(scope="module")
def intel_file(logs_dir: Path, data_file: Callable[[str], Path]) -> Path:
    """The corrected Intel log, in the folder that the service lists."""
    return Path(shutil.copy(data_file("carmen/intel-corrected.log.gz"), logs_dir))


@pytest.fixture
def intel(page: Page, server: str, intel_file: Path) -> Page:
    """The viewer with the corrected Intel log, standing at its end."""
    page.goto(f"{server}/logs.html")
    card = page.locator(".log-card", has_text=intel_file.name)
    card.get_by_role("button", name="Open map").click()
    await_true(page, "() => window.gridbloom && gridbloom.connection.store.frame.peek()")
    return page


def seek_to_end(page: Page) -> None:
    """Press End on the timeline and wait for the map."""
    timeline = page.get_by_role("slider", name="Scans in the map")
    timeline.focus()
    page.keyboard.press("End")
    until("the end of the log", lambda: frame(page)["index"] == frame(page)["count"])
    settled_digest(page)


def map_file(page: Page, server: str) -> tuple[np.ndarray[Any, Any], dict[str, Any]]:
    """Return the downloaded map as image rows turned upside down (row 0 at the smallest y), and its yaml."""
    session = page.evaluate("() => new URLSearchParams(location.search).get('session')")
    pgm = page.request.get(f"{server}/api/sessions/{session}/map.pgm").body()
    text = page.request.get(f"{server}/api/sessions/{session}/map.yaml").text()
    return np.asarray(Image.open(io.BytesIO(pgm)))[::-1], yaml.safe_load(text)


def test_a_log_fills_in_by_itself(intel: Page) -> None:
    at = frame(intel)["index"]
    until("scans to come in", lambda: frame(intel)["index"] > at + 20)
    assert frame(intel)["count"] == 910


def test_the_canvas_at_the_end_of_the_log_shows_the_map_file(intel: Page, server: str) -> None:
    seek_to_end(intel)
    image, description = map_file(intel, server)
    assert set(np.unique(image)) == {0, 205, 254}  # occupied, unknown, free as map_server writes them

    # Everything that the browser holds, against the file.
    held = map_bytes(intel)
    assert image.shape == (held["rows"], held["cols"])
    assert description["resolution"] == pytest.approx(held["resolution"])
    assert description["origin"] == pytest.approx(held["origin"])
    byte = np.frombuffer(held["bytes"], dtype=np.uint8).astype(float).reshape(image.shape)
    low, high = held["low"], held["high"]
    p = 1.0 - 1.0 / (1.0 + np.exp(low + (byte - 1.0) / 254.0 * (high - low)))
    shown = np.where(byte == 0, 205, np.where(p > 0.65, 0, np.where(p < 0.25, 254, 205)))
    np.testing.assert_array_equal(shown, image)

    # And what a person sees: zoom in until a cell is several pixels wide, then look at the pixels of a screenshot.
    walls = np.argwhere(image == 0)
    row, col = (int(v) for v in walls[len(walls) // 3])

    def place(r: int, c: int) -> list[float]:
        x0, y0 = held["origin"][:2]
        return [x0 + (c + 0.5) * held["resolution"], y0 + (r + 0.5) * held["resolution"]]

    intel.mouse.move(5, 5)
    intel.evaluate("([x, y]) => gridbloom.connection.store.setView({ x, y, scale: 0.01 })", place(row, col))
    painted(intel)
    picture = intel.locator(".picture").first
    seen = np.asarray(Image.open(io.BytesIO(picture.screenshot())).convert("RGB")).astype(int)

    def colours(value: int) -> np.ndarray[Any, Any]:
        near = np.argwhere(image == value)
        near = near[np.abs(near - (row, col)).max(axis=1) < 25]
        pixels = [intel.evaluate("(xy) => gridbloom.screen(xy)", place(int(r), int(c))) for r, c in near[::7]]
        return np.array([seen[int(y), int(x)] for x, y in pixels if 0 <= x < seen.shape[1] and 0 <= y < seen.shape[0]])

    # Occupied is warm, free is cold, and both are stronger the surer the map is. The path and the beams may be drawn
    # over a few of the cells.
    occupied, free = colours(0), colours(254)
    assert len(occupied) >= 10
    assert len(free) >= 10
    assert np.mean(occupied[:, 0] > occupied[:, 2]) >= 0.9
    assert np.mean(free[:, 2] >= free[:, 0]) >= 0.9
    assert np.median(occupied.sum(axis=1)) < np.median(free.sum(axis=1)) - 200
    the_overview_moves_the_view(intel)


def the_overview_moves_the_view(intel: Page) -> None:
    """Of a zoomed map: a click shows that place, a drag of the frame moves it, and with the whole map it is gone."""
    overview = intel.locator(".overview")
    box = overview.bounding_box()
    assert box is not None

    def share() -> list[float]:
        """Where the middle of the view is in the whole map, from its left and its lower edge."""
        middle: list[float] = intel.evaluate("""() => {
          const { view, bounds } = gridbloom.connection.store;
          const [{ x, y }, [x0, y0, x1, y1]] = [view.peek(), bounds.peek()];
          return [(x - x0) / (x1 - x0), (y - y0) / (y1 - y0)];
        }""")
        return middle

    intel.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + 0.25 * box["height"])
    assert share() == pytest.approx([0.25, 0.75], abs=0.03)
    drag_along(
        intel,
        (box["x"] + 0.25 * box["width"], box["y"] + 0.25 * box["height"]),
        (box["x"] + 0.5 * box["width"], box["y"] + 0.75 * box["height"]),
        steps=4,
    )
    assert share() == pytest.approx([0.5, 0.25], abs=0.03)
    intel.locator(".picture").first.press("0")
    expect(overview).to_have_count(0)


@pytest.mark.long
def test_going_back_makes_the_earlier_map_again(intel: Page) -> None:
    intel.get_by_role("button", name="Pause").click()
    timeline = intel.get_by_role("slider", name="Scans in the map")
    box = timeline.bounding_box()
    assert box is not None
    intel.mouse.click(box["x"] + box["width"] * 0.3, box["y"] + box["height"] / 2)
    until("the place on the timeline", lambda: abs(frame(intel)["index"] - 0.3 * 910) < 15)
    there, at = settled_digest(intel), frame(intel)["index"]
    seek_to_end(intel)
    assert map_digest(intel) != there
    timeline.focus()
    intel.evaluate("(index) => gridbloom.connection.store.send({ type: 'seek', index })", at)
    until("the earlier map, cell for cell", lambda: frame(intel)["index"] == at and map_digest(intel) == there)


def test_the_map_is_recomputed_while_a_handle_moves(intel: Page) -> None:
    seek_to_end(intel)
    before = map_digest(intel)
    open_group(intel, "Settings")
    handle = intel.locator("figure.profile").get_by_role("slider", name="Max range", exact=True)
    drag(intel, handle.locator(".handle-grab"), -200, 0)
    until("the map to follow", lambda: map_digest(intel) != before)
    assert frame(intel)["index"] == 910
    expect(intel.locator("[data-remade]")).to_contain_text("910 scans re-mapped in")


def test_an_uploaded_log_becomes_a_map_and_can_be_deleted(
    page: Page, server: str, data_file: Callable[[str], Path]
) -> None:
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(data_file("carmen/aces-corrected.log.gz"))
    # Once it was read it opens by itself, and its map fills in.
    await_true(page, "() => window.gridbloom && gridbloom.cells().occupied > 100")
    page.get_by_role("button", name="All logs").click()
    card = page.locator(".log-card", has_text="aces-corrected.log.gz")
    picture = card.locator(".card-picture img")
    expect(picture).to_be_visible()
    until("its picture", lambda: picture.evaluate("(img) => img.naturalWidth") > 100)
    card.get_by_role("button", name="Add a tag to aces-corrected.log.gz").click()
    page.keyboard.type("Austin, corridor")
    page.keyboard.press("Enter")
    expect(card.locator(".tag")).to_have_text(["austin", "corridor", "Change"])
    finder = page.get_by_role("search")
    finder.get_by_role("button", name="corridor").click()
    expect(page.locator(".log-card")).to_have_count(1)
    finder.get_by_role("button", name="corridor").click()
    finder.get_by_role("searchbox").fill("sample")
    expect(card).to_have_count(0)
    finder.get_by_role("searchbox").fill("aces")
    card.get_by_role("button", name="Delete aces-corrected.log.gz").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(card).to_have_count(0)


def test_the_reading_of_a_log_is_in_view_on_a_small_screen(page: Page, server: str) -> None:
    facts: dict[str, Any] = dict.fromkeys(("error", "scans", "beams", "duration_s", "format", "time", "mount"))
    record = facts | {
        "id": "a", "name": "is-read.bag", "source": "upload", "state": "reading", "bytes": 4_200_000, "progress": 0.4,
        "has_picture": False, "upside_down": False, "tags": [], "topics": [], "trajectories": [], "notes": [],
    }  # fmt: skip
    page.set_viewport_size({"width": 1280, "height": 720})
    page.route("**/api/logs?*", lambda route: route.fulfill(json={"logs": [record], "total": 1, "tags": {}}))
    page.goto(f"{server}/logs.html")
    bar = page.get_by_role("progressbar", name="Reading is-read.bag")
    expect(bar).to_have_attribute("aria-valuenow", "40")
    expect(bar).to_be_in_viewport(ratio=1)
    expect(page.get_by_role("heading", name="is-read.bag")).to_be_in_viewport(ratio=1)
    page.unroute("**/api/logs?*")


def test_an_interrupted_upload_resumes(context: BrowserContext, server: str) -> None:
    page = context.new_page()  # unwatched: the console rightly tells of the cut
    line = FrayedLine(int(server.rsplit(":", 1)[1]), 300_000)
    try:
        page.goto(f"{line.url}/logs.html")
        log = carmen(12_000)
        assert len(log) > 2 * line.most
        page.locator("input[type=file]").set_input_files({"name": "cut.log", "mimeType": "text/plain", "buffer": log})
        page.get_by_role("button", name="All logs").click(timeout=2 * SECONDS * 1000)
        card = page.locator(".log-card", has_text="cut.log")
        expect(card).to_contain_text("12,000 scans", timeout=2 * SECONDS * 1000)
        expect(page.locator(".upload")).to_have_count(0)
    finally:
        line.close()


def test_the_cards_show_the_contents_of_the_logs(
    page: Page, server: str, logs_dir: Path, data_dir: Path, intel_file: Path
) -> None:
    page.goto(f"{server}/logs.html")
    card = page.locator(".log-card", has_text=intel_file.name)
    expect(card.locator(".log-run")).to_have_text("44:10 · 500 m driven · 910 scans")
    expect(page.locator(".log-card", has_text="sample")).to_contain_text("600 scans")
    # What is dropped into the folder is there at the next look; what is no log never is.
    (logs_dir / "loop5.log.gz").write_bytes((data_dir / "carmen" / "loop5.log.gz").read_bytes())
    (logs_dir / "intel.ref.tum").write_bytes((data_dir / "carmen" / "intel.ref.tum").read_bytes())
    page.reload()
    expect(page.locator(".log-card", has_text="loop5")).to_contain_text("551 scans")
    expect(page.locator(".log-card", has_text="intel.ref.tum")).to_have_count(0)
    (logs_dir / "loop5.log.gz").unlink()
    (logs_dir / "intel.ref.tum").unlink()


def test_a_visitor_without_logs_opens_an_example_with_one_click(page: Page, server: str) -> None:
    page.goto(f"{server}/logs.html")
    expect(page.locator(".example-card")).to_have_count(3)
    assert violations(page, "main") == []
    page.get_by_role("button", name="Open: a wrong mount").click()
    await_map(page)
    finding = page.get_by_role("region", name="Log doctor").locator('[data-check="mount.offset"]')
    expect(finding).to_contain_text("-6.0° turned")
    page.get_by_role("button", name="All logs").click()
    expect(page.locator(".log-card", has_text="simulated-wrong-mount.mcap")).to_be_visible()
    expect(page.locator(".example-card")).to_have_count(0)


def test_a_file_that_is_no_log_is_refused_with_one_sentence(page: Page, server: str) -> None:
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(
        {"name": "holiday.jpg", "mimeType": "image/jpeg", "buffer": bytes(range(256)) * 40}
    )
    card = page.locator(".log-card.failed", has_text="holiday.jpg")
    error = card.locator(".card-error", has_text=".")
    expect(error).to_be_visible()
    assert "Traceback" not in error.inner_text()
    expect(card).to_contain_text("CARMEN, CMU, ROS 1 bag")
    # Nothing else stopped working: the sample opens beside it.
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    await_true(page, "() => window.gridbloom && gridbloom.cells().free > 50")


def test_a_folder_that_is_dropped_is_one_log(page: Page, server: str, tmp_path: Path) -> None:
    """A recording that ROS 2 split, as it lies on the disk; and a ring of sonars' two files, chosen together."""
    folder, _ = split(tmp_path, "mcap", 3)
    page.goto(f"{server}/logs.html")
    box = page.locator(".dropzone").bounding_box()
    assert box is not None
    place = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    hand = page.context.new_cdp_session(page)
    for kind in ("dragEnter", "dragOver", "drop"):
        data = {"items": [], "files": [str(folder)], "dragOperationsMask": 1}
        hand.send("Input.dispatchDragEvent", {"type": kind, **place, "data": data})
    page.get_by_role("button", name="All logs").click()  # it has opened
    card = page.locator(".log-card", has=page.get_by_role("heading", name="run", exact=True))
    expect(card).to_contain_text("24 scans")
    expect(card).to_contain_text("3 files")
    (tmp_path / "measurement.txt").write_text(SONAR_READINGS)
    (tmp_path / "poses.txt").write_text(SONAR_POSES)
    page.locator("input[type=file]").set_input_files([tmp_path / "poses.txt", tmp_path / "measurement.txt"])
    page.get_by_role("button", name="All logs").click()
    ring = page.locator(".log-card", has=page.get_by_role("heading", name="sonars", exact=True))
    expect(ring).to_contain_text("5 scans")
    for one in (card, ring):
        one.get_by_role("button", name="Delete").click()
        page.get_by_role("dialog").get_by_role("button", name="Delete").click()
        expect(one).to_have_count(0)


def test_the_opening_of_a_log_shows_its_progress_and_can_be_cancelled(page: Page, server: str) -> None:
    asked: list[str] = []

    def held(route: Any) -> None:  # the session is never made
        asked.append(route.request.post_data_json["name"])

    progress = {"what": "Reading the log", "fraction": 0.437, "elapsed_s": 75.2}
    page.route("**/api/sessions", held)
    page.route("**/api/sessions/making/*", lambda route: route.fulfill(json=progress))
    open_sample(page, server)
    opening = page.locator(".viewer-message")
    expect(opening).to_contain_text("Reading the log … 43 %, 1:15")
    assert len(asked) == 1
    opening.get_by_role("button", name="Cancel").click()
    expect(page.locator(".library")).to_be_visible()
    page.unroute("**/api/sessions")
    page.unroute("**/api/sessions/making/*")


def test_progress_is_shown_on_the_map_and_can_be_cancelled(page: Page, server: str) -> None:
    sent: list[str] = []
    page.on("websocket", lambda socket: socket.on("framesent", lambda data: sent.append(str(data))))
    open_sample(page, server)
    await_true(page, "() => window.gridbloom && gridbloom.connection.store.frame.peek()")
    # Again and again: the server ends what it shows itself.
    page.evaluate(
        "() => setInterval(() => { gridbloom.connection.store.working.value = { fraction: 0.25, elapsed_s: 3 }; }, 20)"
    )
    working = page.locator(".viewer-map .working")
    expect(working).to_contain_text("Computing the map …")
    expect(working).to_contain_text("25 %, 3 s")
    # At once: the server may end it between two questions.
    inside = """() => {
      const map = document.querySelector(".viewer-map").getBoundingClientRect();
      const shown = document.querySelector(".viewer-map .working")?.getBoundingClientRect();
      return shown && shown.height > 0 && map.left < shown.left && shown.bottom < map.bottom;
    }"""
    await_true(page, inside)
    working.get_by_role("button", name="Cancel").click()
    # Playwright tells of what was sent only while it is asked for something.
    until("the command", lambda: page.title() and any('"cancel"' in data for data in sent))
