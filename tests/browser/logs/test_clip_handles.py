"""The clip box of a map in 3D by the handles on its faces: with the mouse, with a finger, and without a question."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from playwright.sync_api import Page

from mapper.io.clouds.ply import points_ply
from tests.browser.fingers import Fingers, Place
from tests.browser.logs.test_volume import VOLUME, opened
from tests.browser.looking import await_true, open_group, until
from tests.marks import also_long_rows

pytestmark = pytest.mark.moving
CUT = f"() => ({VOLUME})().look.values.cut_high"


def room(folder: Path) -> Path:
    """Return the file of a cloud: points on the walls of a room of 6 × 5 × 3 m."""
    away = np.random.default_rng(0).normal(size=(20_000, 3))
    away /= np.linalg.norm(away, axis=1)[:, None]
    points = away * np.min(np.array([3.0, 2.5, 1.5]) / np.abs(away), axis=1)[:, None]
    path = folder / "room.ply"
    path.write_bytes(points_ply(points.astype(np.float32), {}, np.zeros(3)))
    return path


def ceiling_handle(page: Page, view: str = "iframe.volume-scene") -> Place | None:
    """Return where the middle of the upper blue arrow is on the page, pixels; None while there is none."""
    frame = page.locator(view)
    box = frame.bounding_box()
    assert box is not None
    with Image.open(io.BytesIO(frame.screenshot(scale="css"))) as picture:
        red, green, blue = np.asarray(picture.convert("RGB")).astype(int).transpose(2, 0, 1)
    rows, cols = np.nonzero((blue > 205) & (red < 110) & (green > 95) & (green < 190))
    if not len(rows):
        return None
    upper = rows < rows.min() + 60
    return box["x"] + float(cols[upper].mean()), box["y"] + float(rows[upper].mean())


def by_mouse(page: Page, start: Place, down: float, held: Callable[[], object]) -> None:
    x, y = start
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + down, steps=10)
    held()
    page.mouse.up()


def by_finger(page: Page, start: Place, down: float, held: Callable[[], object]) -> None:
    x, y = start
    Fingers(page).drag((start, (x, y + down)), before_lifting=held)


# The mouse drags the handle of the lab in `make test`.
@pytest.mark.parametrize(
    ("context", "drag"),
    [("phone", by_finger), *also_long_rows(("desktop", by_mouse))],
    indirect=["context"],
    ids=["finger", "mouse"],
)
def test_the_ceiling_is_clipped_by_its_handle(
    drag: Callable[[Page, Place, float, Callable[[], object]], None], page: Page, server: str, tmp_path: Path
) -> None:
    opened(page, server, room(tmp_path))
    page.get_by_role("button", name="Clip", exact=True).click()
    until("the handles are drawn", lambda: ceiling_handle(page) is not None)
    start = ceiling_handle(page)
    assert start is not None
    whole = page.evaluate(CUT)

    def dragged() -> None:
        """The cut follows while the handle is held."""
        await_true(page, f"() => ({CUT})() < {whole} - 0.3 && ({VOLUME})().pending === 0")

    drag(page, start, 40.0, dragged)
    slider = page.get_by_role("slider", name="Cut above")
    session = page.evaluate("() => gridbloom.connection.store.hello.peek().session")

    def agree() -> bool:
        """Whether slider and saved points have the height of the handle, whose last move may still be on its way."""
        cut = page.evaluate(CUT)
        file = page.request.get(f"{server}/api/sessions/{session}/selection.ply").body()
        saved = trimesh.load(io.BytesIO(file), file_type="ply")
        assert isinstance(saved, trimesh.PointCloud)
        shown = slider.get_attribute("aria-valuetext") == f"{cut:.2f} m".replace("-", "−")
        return shown and -1.5 < cut < 1.5 and cut - 0.1 < np.asarray(saved.vertices)[:, 2].max() <= cut

    until("the slider is where the handle is, and what is saved lies below it", agree)
    # The handle is where it was let go, and a drag asks about no voxel.
    until("the handle is drawn again", lambda: (ceiling_handle(page) or start)[1] > start[1] + 30.0)
    assert page.evaluate("() => gridbloom.connection.store.part('voxel').message.peek().centre") is None
    page.get_by_role("button", name="Draw the whole map").click()
    until("the handle is at the ceiling", lambda: abs((ceiling_handle(page) or (0.0, 0.0))[1] - start[1]) < 3.0)


def test_the_lab_has_the_same_handles(page: Page, open_lab: Callable[..., Page]) -> None:
    open_lab("levels")
    panel = open_group(page, "3D map")
    scans = "() => gridbloom.connection.store.part('map3d').message.peek()?.scans"
    page.evaluate("() => gridbloom.connection.store.send({ type: 'play' })")
    await_true(page, f"() => ({scans})() >= 3")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    panel.get_by_role("button", name="Clip", exact=True).click()
    until("the handles are drawn", lambda: ceiling_handle(page, "iframe.scene") is not None)
    start = ceiling_handle(page, "iframe.scene")
    assert start is not None
    cut = "() => gridbloom.connection.store.part('map3d').message.peek().values.cut_high"
    whole = page.evaluate(cut)
    by_mouse(page, start, 20.0, lambda: await_true(page, f"() => ({cut})() < {whole} - 0.2"))
    slider = panel.get_by_role("slider", name="Cut above")

    def agree() -> bool:
        return slider.get_attribute("aria-valuetext") == f"{page.evaluate(cut):.2f} m".replace("-", "−")

    until("the slider is where the handle is", agree)
    assert page.evaluate("() => gridbloom.connection.store.part('voxel').message.peek()?.centre ?? null") is None
    panel.get_by_role("button", name="Draw the whole map").click()
    await_true(page, f"() => ({cut})() > 2.3")
    page.keyboard.press("Control+z")
    await_true(page, f"() => ({cut})() < {whole} - 0.2")


def test_points_outside_of_the_box_are_left_out_by_the_browser(page: Page, server: str, tmp_path: Path) -> None:
    opened(page, server, room(tmp_path))
    look = "values => gridbloom.connection.store.send({ type: 'volume_look', values })"
    page.evaluate(look, {"show": "points"})
    frame = page.locator("iframe.volume-scene")

    def upper() -> int:
        """The pixels in the upper third, within the frame's border, that are not the background: ceiling and walls."""
        with Image.open(io.BytesIO(frame.screenshot(scale="css"))) as picture:
            pixels = np.asarray(picture.convert("RGB")).astype(int)
        return int((np.abs(pixels[4 : len(pixels) // 3, 4:-4] - (250, 248, 242)).max(axis=2) > 40).sum())

    until("the ceiling's points are drawn", lambda: upper() > 1000)
    page.evaluate(look, {"cut_high": -1.3})
    until("only the lowest points are drawn", lambda: upper() < 20)
    page.evaluate(look, {"cut_high": 2.0})
    until("all points are drawn again", lambda: upper() > 1000)
