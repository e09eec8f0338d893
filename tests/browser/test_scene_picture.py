"""What the buttons of a 3D view do to its picture: the axes and the grid, and its file."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Locator, Page

from tests.browser.looking import open_group, until

RED, GREEN, BLUE = (214, 60, 50), (58, 150, 60), (50, 100, 214)  # of the axes x, y and z


def pixels_of(picture: bytes) -> NDArray[np.int64]:
    with Image.open(io.BytesIO(picture)) as image:
        assert image.format == "PNG"
        return np.asarray(image.convert("RGB")).astype(np.int64)


def has_axes(pixels: NDArray[np.int64]) -> bool:
    """Whether each axis's colour is in a picture."""
    return all((np.abs(pixels - colour).max(axis=2) < 12).sum() > 10 for colour in (RED, GREEN, BLUE))


def saved(page: Page, button: Locator) -> bytes:
    with page.expect_download() as download:
        button.click()
    assert download.value.suggested_filename == "view.png"
    return Path(download.value.path()).read_bytes()


def test_the_axes_are_switched_on_and_saved_in_a_file(page: Page, open_lab: Callable[..., Page]) -> None:
    open_lab("room")
    panel = open_group(page, "3D view")
    view = panel.locator("iframe.scene")
    layers = panel.get_by_role("group", name="Layers")
    layers.get_by_role("button", name="Grid of 1 m").wait_for()
    assert not has_axes(pixels_of(view.screenshot()))
    for hiding in ("True world", "Map"):  # the origin is in the wall of a corner
        layers.get_by_role("button", name=hiding, exact=True).click()
    layers.get_by_role("button", name="Axes", exact=True).click()
    until("the axes are drawn", lambda: has_axes(pixels_of(view.screenshot())))
    picture = pixels_of(saved(page, panel.get_by_role("button", name="PNG")))
    assert has_axes(picture)
    # In its corner the file has the colour of the page's ground.
    assert tuple(picture[0, 0]) == (250, 248, 242)
