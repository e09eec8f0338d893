"""The 3D view in a browser: a gizmo that is dragged with the mouse reaches the session."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from server.sessions.drawings import Drawing, Gizmo, Point, Quaternion
from server.sources.simulation import SimulationModel
from tests.browser.looking import drag_along, until
from tests.browser.visits import visiting
from tests.server.service import running, settings_for


def centre_of(model: SimulationModel) -> Point:
    x0, y0, x1, y1 = model.world.bounds
    return ((x0 + x1) / 2, (y0 + y1) / 2, 0.0)


def test_a_dragged_gizmo_reaches_the_session(browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    positions: list[Point] = []

    def drawings(model: SimulationModel) -> list[Drawing]:
        return [Gizmo(name="goal", label="Goal", position=centre_of(model), scale=3.0, turns=False)]

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

        def dragged() -> bool:
            # The camera looks at the centre from the south: the arrow along x points to the right.
            box = canvas.bounding_box()
            assert box is not None
            x, y = box["x"] + 0.7 * box["width"], box["y"] + 0.5 * box["height"]
            drag_along(page, (x, y), (x + 30, y), steps=5)
            return bool(positions)

        until("the session to be told of the move", dragged)
        model = service.state.sessions.get(session_id).model
        assert isinstance(model, SimulationModel)
        x, y, z = centre_of(model)
        assert positions[-1][0] > x
        assert positions[-1][1:] == pytest.approx((y, z), abs=1e-6)
