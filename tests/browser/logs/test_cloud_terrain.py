"""The terrain of an uploaded cloud in Chromium: a patch is asked about, and one of its points is dragged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from playwright.sync_api import Page, expect

from tests.browser.looking import await_true, drag, open_group, until

_STORE = "gridbloom.connection.store"
_PATCH = f"() => {_STORE}.part('terrain').message.peek()?.patch ?? null"


def moments(points: np.ndarray) -> np.ndarray:
    """Return P (4, 4), the sum of v vᵀ with v = [1 x y z]."""
    rows = np.column_stack([np.ones(len(points)), points])
    return np.asarray(rows.T @ rows)


def test_a_point_of_a_patch_is_dragged_and_its_moments_follow(page: Page, server: str, tmp_path: Path) -> None:
    x, y = np.meshgrid(np.arange(0.1, 20.0, 0.2), np.arange(0.1, 20.0, 0.2))
    slope = np.column_stack([x.ravel(), y.ravel(), 0.1 * x.ravel()])
    path = tmp_path / "slope.xyz"
    np.savetxt(path, slope, fmt="%.3f")
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", str(path))
    await_true(page, f"() => window.gridbloom && {_STORE}.part('volume').message.peek()")
    group = open_group(page, "Terrain")
    await_true(page, f"() => {_STORE}.part('terrain').message.peek()?.safe > 0")
    page.locator(".volume-above-map .picture").click()  # in its middle
    asked = group.get_by_label("The patch that was clicked")
    await_true(page, f"() => (({_PATCH})()?.n ?? 0) > 3")
    patch = page.evaluate(_PATCH)
    points = np.array(patch["points"]).reshape(-1, 3)
    assert len(points) == patch["n"]

    def shown() -> np.ndarray:
        cells = asked.get_by_label("P, the sum of v vᵀ").get_by_role("cell").all_inner_texts()
        return np.array([float(text.replace("−", "-").replace(",", "")) for text in cells]).reshape(4, 4)

    expect(asked).to_contain_text("safe")
    np.testing.assert_allclose(shown(), moments(points), atol=0.006)
    handle = asked.get_by_role("slider", name="Point 1", exact=True)
    assert float(handle.get_attribute("aria-valuenow") or "nan") == round(points[0, 2], 3)
    drag(page, handle, 0, -60)
    until("the point is higher", lambda: float(handle.get_attribute("aria-valuenow") or 0.0) > points[0, 2] + 0.01)
    moved = points.copy()
    moved[0, 2] = float(handle.get_attribute("aria-valuenow") or "nan")
    np.testing.assert_allclose(shown(), moments(moved), atol=0.006)
    # The entries without z stay, and the map keeps its points.
    expect(asked.locator("td.changed")).not_to_have_count(0)
    np.testing.assert_array_equal(shown()[:3, :3], np.round(moments(points)[:3, :3], 2))
    assert page.evaluate(_PATCH)["points"] == patch["points"]
    asked.get_by_role("button", name="Put the points back").click()
    until("the first moments are back", lambda: np.allclose(shown(), moments(points), atol=0.006))
