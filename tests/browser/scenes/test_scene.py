"""The 3D view in a browser: a gizmo that is dragged with the mouse reaches the session."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Browser, expect

from server.scenes.cameras import FOV, camera_at
from server.sessions.drawings import COLUMN_M, Drawing, Gizmo, Point, Quaternion
from server.sources.simulation import SimulationModel
from tests.browser.looking import drag_along, until
from tests.browser.visits import visiting
from tests.server.service import running, settings_for

SCALE = 3.0  #: of the gizmo: the length of its arrows, metres


def centre_of(model: SimulationModel) -> Point:
    x0, y0, x1, y1 = model.world.bounds
    return ((x0 + x1) / 2, (y0 + y1) / 2, 0.0)


def seen(model: SimulationModel, place: NDArray[np.float64], aspect: float) -> tuple[float, float]:
    """Where a place is in the picture of the first camera: from -1 at the left to 1, and from -1 at the lower edge."""
    camera, look_at = camera_at("overview", model.world.bounds, aspect, (0.0, COLUMN_M))
    ahead = np.subtract(look_at, camera)
    ahead /= np.linalg.norm(ahead)
    right = np.array([1.0, 0.0, 0.0])
    half = (place - camera) @ ahead * np.tan(FOV / 2)  # of the height that the picture shows at that depth
    return float((place - camera) @ right / (aspect * half)), float((place - camera) @ np.cross(right, ahead) / half)


def test_a_dragged_gizmo_reaches_the_session(browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    positions: list[Point] = []

    def drawings(model: SimulationModel) -> list[Drawing]:
        return [Gizmo(name="goal", label="Goal", position=centre_of(model), scale=SCALE, turns=False)]

    def moved(_model: SimulationModel, name: str, position: Point, _wxyz: Quaternion) -> None:
        assert name == "goal"
        positions.append(position)

    monkeypatch.setattr(SimulationModel, "drawings", drawings)
    monkeypatch.setattr(SimulationModel, "on_gizmo_moved", moved)
    with running(settings_for(tmp_path)) as service, visiting(browser, f"http://127.0.0.1:{service.port}") as context:
        session_id = service.begin()
        page = context.new_page()
        page.goto(f"http://127.0.0.1:{service.port}/scenes/{session_id}/")
        expect(page.get_by_text("Goal").first).to_be_attached()
        canvas = page.locator("canvas").first
        expect(canvas).to_be_visible()

        model = service.state.sessions.get(session_id).model
        assert isinstance(model, SimulationModel)

        def dragged() -> bool:
            # The camera looks to the north: the arrow along x points to the right.
            box = canvas.bounding_box()
            assert box is not None
            across, up = seen(model, centre_of(model) + np.array([0.9 * SCALE, 0.0, 0.0]), box["width"] / box["height"])
            x = box["x"] + 0.5 * (1.0 + across) * box["width"]
            y = box["y"] + 0.5 * (1.0 - up) * box["height"]
            drag_along(page, (x, y), (x + 30, y), steps=5)
            return bool(positions)

        until("the session to be told of the move", dragged)
        x, y, z = centre_of(model)
        assert positions[-1][0] > x
        assert positions[-1][1:] == pytest.approx((y, z), abs=1e-6)
