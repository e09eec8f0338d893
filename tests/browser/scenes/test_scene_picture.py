"""What the buttons of a 3D view do to its picture: the axes and the grid, and its file."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Locator, Page, expect

from tests.browser.looking import await_true, frames, open_group, until


def pixels_of(picture: bytes) -> NDArray[np.int64]:
    with Image.open(io.BytesIO(picture)) as image:
        assert image.format == "PNG"
        return np.asarray(image.convert("RGB")).astype(np.int64)


def shows_x(pixels: NDArray[np.int64]) -> bool:
    """Whether the red of the axis x is in a picture: nothing else is as red, but beams over the walls of the map."""
    red, green, blue = pixels.transpose(2, 0, 1)
    return bool(((red - np.maximum(green, blue) > 50) & (np.abs(green - blue) < 20)).sum() > 20)


def shows_grid(pixels: NDArray[np.int64]) -> bool:
    """Whether the grey of the grid's lines is in a picture, which a slow machine draws coarsely, and so paler."""
    return bool(((np.ptp(pixels, axis=2) < 10) & (np.abs(pixels[:, :, 0] - 180) < 45)).sum() > 800)


def saved(page: Page, button: Locator) -> bytes:
    with page.expect_download() as download:
        button.click()
    assert download.value.suggested_filename == "view.png"
    return Path(download.value.path()).read_bytes()


def shows_walls(pixels: NDArray[np.int64]) -> bool:
    """Whether full colours are in a picture: walls of the map, or of the 3D map where that has begun."""
    return bool((np.ptp(pixels, axis=2) > 60).sum() > 1000)


def shows_both(pixels: NDArray[np.int64]) -> bool:
    return shows_x(pixels) and shows_grid(pixels)


@pytest.mark.long
def test_the_axes_and_the_grid_are_switched_on_and_saved_in_a_file(page: Page, open_lab: Callable[..., Page]) -> None:
    open_lab("room")
    panel = open_group(page, "3D view")
    view = panel.locator("iframe.scene")
    layers = panel.get_by_role("group", name="Layers")
    layers.get_by_role("button", name="True world").click()  # the origin is in the wall of a corner
    layers.get_by_role("button", name="Beams").click()
    until("the map is drawn", lambda: shows_walls(pixels_of(view.screenshot())))
    until("the world is hidden", lambda: not shows_grid(pixels_of(view.screenshot())))
    until("the beams are hidden", lambda: not shows_x(pixels_of(view.screenshot())))
    panel.get_by_role("combobox", name="Camera").select_option("Overview")
    layers.get_by_role("button", name="Axes", exact=True).click()
    until("the axes are drawn", lambda: shows_x(pixels_of(view.screenshot())))
    layers.get_by_role("button", name="Grid of 1 m").click()
    until("the grid is drawn", lambda: shows_grid(pixels_of(view.screenshot())))
    button = panel.get_by_role("button", name="PNG")
    # Of the frame that is drawn next, which a slow machine draws coarsely.
    until("both are in the file", lambda: shows_both(pixels_of(saved(page, button))))
    # In its corner the file has the colour of the page's ground.
    assert tuple(pixels_of(saved(page, button))[0, 0]) == (250, 248, 242)


#: Has the 3D views of a page connect once it is told to.
HOLD = """if (window === top) window.held = [];
window.Worker = class extends Worker {
  postMessage(message, ...more) {
    const post = () => super.postMessage(message, ...more);
    if (message?.type === "set_server") top.held.push(post);
    else post();
  }
};"""


def test_nothing_is_shown_before_the_scene_is_known(page: Page, open_lab: Callable[..., Page]) -> None:
    """Viser's client draws axes of its own until it has a connection."""
    page.add_init_script(HOLD)
    open_lab()
    panel = open_group(page, "3D view")
    canvas = page.frame_locator("iframe.scene").locator("canvas[data-engine]")
    canvas.wait_for(state="attached")
    await_true(page, "() => held.length === 1")
    frames(page, 3)
    expect(canvas).to_be_hidden()
    expect(panel.get_by_text("Loading the 3D view")).to_be_visible()
    page.evaluate("() => held[0]()")
    expect(canvas).to_be_visible()
    expect(panel.get_by_text("Loading the 3D view")).to_have_count(0)
