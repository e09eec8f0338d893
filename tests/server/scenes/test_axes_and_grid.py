"""The axes and the grid: where their lines lie, and that they are hidden until somebody switches them on."""

from __future__ import annotations

import httpx
import numpy as np
import pytest

from server.scenes.axes_and_grid import axes_and_grid, spacing_of
from server.sessions.drawings import Segments
from server.sessions.scene_controls import Bounds
from tests.server.begin import new_simulation
from tests.server.scenes.conftest import Service
from tests.server.scenes.viser_client import viser_client


@pytest.mark.parametrize(
    ("bounds", "spacing"),
    [
        ((0.0, 0.0, 10.0, 8.0), 1.0),
        ((0.0, 0.0, 8.0, 8.0), 1.0),
        ((-3.2, 0.4, 12.9, 7.0), 2.0),
        ((100.0, -50.0, 101.0, -49.5), 0.1),
        ((0.0, 0.0, 400.0, 10.0), 50.0),
    ],
)
def test_the_lines_cover_the_bounds_at_multiples_of_the_spacing(bounds: Bounds, spacing: float) -> None:
    assert spacing_of(bounds) == spacing
    _, grid = axes_and_grid(bounds, floor=-2.0)
    assert isinstance(grid, Segments)
    ends = grid.points.astype(float)
    along_y = np.ptp(ends[:, :, 0], axis=1) == 0.0
    for axis, lines in ((0, ends[along_y]), (1, ends[~along_y])):
        places = np.unique(lines[:, 0, axis])
        assert len(places) == len(lines)
        np.testing.assert_allclose(np.diff(places), spacing, rtol=1e-3)
        np.testing.assert_allclose(places / spacing, np.round(places / spacing), atol=1e-3)
        assert bounds[axis] - spacing < places[0] <= bounds[axis] + 1e-5
        assert bounds[axis + 2] - 1e-5 <= places[-1] < bounds[axis + 2] + spacing
    assert ((ends[:, :, 2] > -2.0) & (ends[:, :, 2] < -2.0 + 0.1 * spacing)).all()


def test_the_axes_point_along_x_y_and_z_in_red_green_and_blue() -> None:
    axes, _ = axes_and_grid((0.0, 0.0, 10.0, 8.0), floor=0.0)
    assert isinstance(axes, Segments)
    np.testing.assert_array_equal(axes.points[:, 0], 0.0)
    np.testing.assert_allclose(axes.points[:, 1], 2.0 * np.eye(3))
    np.testing.assert_array_equal(np.argmax(axes.colors, axis=2), [[0, 0], [1, 1], [2, 2]])


async def test_they_are_hidden_until_they_are_switched_on(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    address = f"http://127.0.0.1:{service.port}/scenes/{session.id}/settings"
    async with httpx.AsyncClient(cookies={"visitor": "ann"}) as ann, viser_client(service.port, session.id) as client:
        hidden = await client.until(lambda m: m["type"] == "SetSceneNodeVisibilityMessage" and m["name"] == "/grid")
        assert not hidden["visible"]
        before = (await ann.get(address)).json()
        assert (before["layers"]["Axes"], before["layers"]["Grid"], before["grid"]) == (False, False, 1.0)
        await ann.post(address, json={"layers": {"Grid": True}})
        await client.until(
            lambda m: m["type"] == "SetSceneNodeVisibilityMessage" and m["name"] == "/grid" and m["visible"]
        )
        axes = [m["visible"] for m in client.of_type("SetSceneNodeVisibilityMessage") if m["name"] == "/axes"]
        assert axes
        assert not any(axes)
