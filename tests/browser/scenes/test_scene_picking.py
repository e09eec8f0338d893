"""What a press in the 3D view of a log selects, against the map, the poses and the loops of the same session."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Page, WebSocket, expect

from tests.browser.drifting import drifting_ring
from tests.browser.looking import SECONDS, await_true, frame, map_bytes, settled_digest, until
from tests.marks import also_long_rows

Press = Callable[[float, float], object]
Places = NDArray[np.float64]  # (n, 3), metres in the map

OCCUPIED = 120  # byte of p = 0.64: a cell is drawn as a column from 0.65
COLUMN_M = 0.5  # height of the column of a cell that is surely occupied
PICKED = "() => gridbloom.connection.store.part('picked').message.peek()"


@dataclass(frozen=True)
class Camera:
    """The camera of the browser: a pinhole, as viser's client tells it to the service.

    ``turn`` (3, 3) takes its axes, x to the right, y down and z ahead, to those of the map.
    """

    turn: NDArray[np.float64]
    position: NDArray[np.float64]
    fov: float  # vertical

    def has_ahead(self, places: Places) -> bool:
        """Return whether places are ahead of it."""
        return bool((((places - self.position) @ self.turn)[:, 2] > 0.0).all())

    def seen(self, places: Places, width: float, height: float) -> NDArray[np.float64]:
        """Return where places are in a picture (n, 2), in pixels from its upper left corner."""
        x, y, z = ((places - self.position) @ self.turn).T
        focal = 0.5 * height / math.tan(0.5 * self.fov)
        return np.column_stack([0.5 * width + focal * x / z, 0.5 * height + focal * y / z])


class View:
    """The 3D view of a page beside its map, and what is picked in it."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.cameras: list[Camera] = []
        page.on("websocket", self._follow)

    def _follow(self, socket: WebSocket) -> None:
        if "/scenes/" in socket.url:
            socket.on("framesent", self._sent)

    def _sent(self, data: bytes | str) -> None:
        message: Any = msgspec.msgpack.decode(data) if isinstance(data, bytes) else {}
        if isinstance(message, dict) and message.get("type") == "ViewerCameraMessage":
            w, x, y, z = message["wxyz"]
            turn = [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
                [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
                [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
            ]
            self.cameras.append(Camera(np.array(turn), np.array(message["position"]), message["fov"]))

    def open(self) -> None:
        """Show it, and wait until the map fills it: its cells have the colour of columns where the camera sees them."""
        self.page.get_by_label("Layout", exact=True).select_option("Map and 3D")
        places, _ = self.occupied()

        def is_drawn() -> bool:
            with Image.open(io.BytesIO(self.page.locator("iframe.scene").screenshot(scale="css"))) as picture:
                pixels = np.asarray(picture.convert("RGB")).astype(int)
            if not self.cameras or not self.cameras[-1].has_ahead(places):
                return False
            height, width, _ = pixels.shape
            cols, rows = np.floor(self.cameras[-1].seen(places, width, height)).astype(int).T
            if min(cols.min(), rows.min()) < 0 or cols.max() >= width or rows.max() >= height:
                return False
            if np.ptp(cols) < 0.4 * width and np.ptp(rows) < 0.4 * height:
                return False
            red, _, blue = pixels[rows, cols].T
            return bool((red - blue > 60).mean() > 0.3)

        until("the whole map in 3D", is_drawn)

    def occupied(self, least: int = 255) -> tuple[Places, float]:
        """Return the middles of cells that are occupied, by their bytes, and the size of a cell, metres.

        The columns of the surest, 255, are all as high; the middles are those of their tops.
        """
        held = map_bytes(self.page)
        rows, cols = np.nonzero(np.frombuffer(held["bytes"], dtype=np.uint8).reshape(held["rows"], -1) >= least)
        (x, y, _), cell = held["origin"], held["resolution"]
        return np.column_stack([x + (cols + 0.5) * cell, y + (rows + 0.5) * cell, np.full(len(rows), COLUMN_M)]), cell

    def press(self, place: Places, press: Press) -> float:
        """Press where a place (3,) is seen; return how many metres a pixel is there."""
        box = self.page.frame_locator("iframe.scene").locator("canvas[data-engine]").bounding_box()
        assert box is not None
        camera = self.cameras[-1]
        there, beside = camera.seen(np.array([place, place + np.array([1.0, 0.0, 0.0])]), box["width"], box["height"])
        press(box["x"] + there[0] - 0.5, box["y"] + there[1] - 0.5)  # a press means the middle of its pixel
        return float(1.0 / np.linalg.norm(beside - there))

    def pick(self, place: Places, press: Press) -> tuple[dict[str, Any], float]:
        """Press where a place (3,) is seen; return what is picked there, and how many metres a pixel is there."""
        self.page.evaluate(f"() => {{ window.pickedBefore = ({PICKED})(); }}")
        pixel = self.press(place, press)
        await_true(self.page, f"() => ({PICKED})() !== window.pickedBefore")
        return self.page.evaluate(PICKED), pixel

    def says(self, words: str) -> None:
        """Wait until the view says what is selected."""
        words = words.replace("-", "\N{MINUS SIGN}")
        expect(self.page.locator(".view-pane [role=status]").filter(has_text=words)).to_be_visible()


def opened(page: Page, server: str) -> None:
    """Upload a log, and map all of it."""
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files(
        {"name": "ring.log", "mimeType": "text/plain", "buffer": drifting_ring()}
    )
    expect(page.get_by_role("tab", name="Heal")).to_be_visible()
    count = frame(page)["count"]
    page.evaluate("count => gridbloom.connection.store.send({ type: 'step', scans: count })", count)
    await_true(page, "() => (f => f.index === f.count && !f.playing)(gridbloom.connection.store.frame.peek())")
    settled_digest(page)


def cells_are_picked(view: View, press: Press) -> None:
    """Press columns all over the map: each time an occupied cell is picked, the one that was aimed at to a pixel."""
    places, cell = view.occupied()
    all_occupied, _ = view.occupied(least=OCCUPIED)
    for place in places[:: len(places) // 4]:
        picked, pixel = view.pick(place, press)
        assert picked["what"] == "cell"
        at = np.array([picked["x"], picked["y"]])
        assert np.abs(all_occupied[:, :2] - at).max(axis=1).min() <= 0.5 * cell + 1e-6
        assert np.abs(place[:2] - at).max() <= 0.5 * cell + pixel
        view.says(f"Cell at x {at[0]:.2f} m, y {at[1]:.2f} m")


def test_a_cell_a_pose_and_a_loop_are_picked_with_the_mouse(page: Page, server: str) -> None:
    view = View(page)
    opened(page, server)
    page.locator(".correction-offer").get_by_role("button", name="Heal its poses").click()
    heal = page.get_by_role("region", name="Heal its poses")
    expect(heal).to_contain_text("Healed", timeout=5 * SECONDS * 1000)
    settled_digest(page)
    view.open()
    cells_are_picked(view, page.mouse.click)

    session = page.evaluate("() => gridbloom.connection.store.hello.peek().session")
    graph = f"{server}/api/sessions/{session}/graph"
    edges = [loop["edge"] for loop in page.request.get(graph).json()["graph"]["loops"]]
    ends = np.array([page.request.get(f"{graph}/edges/{edge}").json()["poses"] for edge in edges])[:, :, :2]
    loops = ends.mean(axis=1)

    # The pose that is farthest from all loops: where both are near, a loop is meant.
    path = page.evaluate("() => gridbloom.connection.store.trajectory.peek()")
    poses = np.array(path["poses"])
    scan = int(np.linalg.norm(poses[:, None, :2] - loops, axis=2).min(axis=1).argmax())
    picked, pixel = view.pick(np.array([*poses[scan, :2], 0.0]), page.mouse.click)
    assert (picked["what"], picked["index"]) == ("pose", scan * path["every"] + 1)
    np.testing.assert_allclose((picked["x"], picked["y"]), poses[scan, :2], atol=1e-3)
    until("the map of the scans up to it", lambda: frame(page)["index"] == picked["index"])
    view.says(f"Pose of scan {picked['index']}: x {picked['x']:.2f} m")

    # The loop whose middle is farthest from those of the others.
    apart = np.linalg.norm(loops[:, None] - loops, axis=2) + np.diag(np.full(len(loops), np.inf))
    alone = int(apart.min(axis=1).argmax())
    assert apart[alone].min() > 2.0 * pixel
    picked, _ = view.pick(np.array([*loops[alone], 0.1]), page.mouse.click)
    assert (picked["what"], picked["edge"]) == ("loop", edges[alone])
    np.testing.assert_allclose((picked["x"], picked["y"]), loops[alone], atol=1e-3)
    expect(page.get_by_role("region", name="Selected loop")).to_contain_text("Residual")


RULER = np.array([110, 40, 200])


@pytest.mark.parametrize(
    ("context", "press"),
    [("tablet", "touchscreen.tap"), *also_long_rows(("desktop", "mouse.click"))],
    indirect=["context"],
)
def test_a_distance_is_measured_in_3d(page: Page, server: str, press: str) -> None:
    """Measure from one column to another in the 3D view, against where they are on the map."""
    view = View(page)
    opened(page, server)
    view.open()
    pane = page.get_by_role("region", name="3D", exact=True)
    hand = attrgetter(press)(page)
    pane.get_by_role("button", name="Measure a distance").click()
    said = pane.get_by_role("region", name="Measured")
    said.get_by_role("switch", name="Snap to walls").click()  # off
    places, cell = view.occupied()
    ends = places[[0, -1]]
    undo = said.get_by_role("button", name="Remove the last point")
    view.press(ends[0], hand)
    expect(undo).to_be_enabled()
    view.press(ends[1], hand)
    expect(said).to_contain_text("direction")
    length = float(np.linalg.norm(ends[0] - ends[1]))
    said_m = float(re.findall(r"(\d+\.\d\d) m ± 0\.\d\d m, direction", said.inner_text())[0])
    assert said_m == pytest.approx(length, abs=2.0 * cell)
    assert page.evaluate("() => gridbloom.connection.store.explainedPoint.peek()") is None

    def is_drawn() -> bool:
        with Image.open(io.BytesIO(page.locator("iframe.scene").screenshot(scale="css"))) as picture:
            pixels = np.asarray(picture.convert("RGB")).astype(int)
        return int((np.abs(pixels - RULER).max(axis=2) < 30).sum()) > 50

    until("the line in the view", is_drawn)
    pane.get_by_role("button", name="Close the ruler").click()
    until("the line is gone", lambda: not is_drawn())


@pytest.mark.parametrize("context", ["tablet"], indirect=True)
def test_a_cell_is_picked_with_a_finger(page: Page, server: str) -> None:
    view = View(page)
    opened(page, server)
    view.open()
    cells_are_picked(view, page.touchscreen.tap)
