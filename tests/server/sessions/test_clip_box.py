"""The clip box of a map in 3D: where its handles are, and what moving one of them does."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from mapper.core.array_types import Float64Array
from server.parts.volume.clip_box import LEAST_M, ClipBox
from server.parts.volume.look import Look
from server.sessions.drawings import Gizmo, Point, Segments

#: Of the map, and of the sliders: half a metre farther.
LOW, HIGH = np.array([-1.0, 0.0, 0.5]), np.array([3.0, 2.0, 2.5])
ENDS = [-1.5, -0.5, 0.0], [3.5, 2.5, 3.0]


def turned(arrow: Float64Array, gizmo: Gizmo) -> Float64Array:
    """Return ``arrow`` (3,) in the map: q v q* by Rodrigues' formula for a quaternion w, x, y, z."""
    w, axis = gizmo.wxyz[0], np.array(gizmo.wxyz[1:])
    return np.asarray(arrow + 2.0 * w * np.cross(axis, arrow) + 2.0 * np.cross(axis, np.cross(axis, arrow)))


def test_each_face_has_a_handle_in_its_middle_that_points_outwards() -> None:
    look = Look(cut_handles=True, cut_x_high=2.0, cut_low=1.0)
    drawings = ClipBox(LOW, HIGH).drawings(look)
    edges = [one for one in drawings if isinstance(one, Segments)]
    assert len(edges) == 1
    corners = edges[0].points.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    assert low.tolist() == [-1.0, 0.0, 1.0]
    assert high.tolist() == [2.0, 2.0, 2.5]
    handles = [one for one in drawings if isinstance(one, Gizmo)]
    seen = set()
    for handle in handles:
        (axis,) = np.flatnonzero(handle.axes)
        outwards = turned(np.eye(3)[axis], handle)
        face = (low + high) / 2 + outwards * (high - low) / 2
        np.testing.assert_allclose(handle.position, face, atol=1e-6)
        seen.add(tuple(outwards.round().astype(int).tolist()))
        assert not handle.turns
    assert len(handles) == len(seen) == 6


@pytest.mark.parametrize(
    ("handle", "position", "wanted"),
    [
        ("cut-high", (9.0, 9.0, 1.25), {"cut_high": 1.25}),
        ("cut-x-low", (0.12345, 0.0, 0.0), {"cut_x_low": 0.123}),
        ("cut-y-high", (0.0, 99.0, 0.0), {"cut_y_high": 2.5}),
        ("cut-y-low", (0.0, 99.0, 0.0), {"cut_y_low": 2.0 - LEAST_M}),
        ("cut-x-high", (-99.0, 0.0, 0.0), {"cut_x_high": -1.0 + LEAST_M}),
    ],
)
def test_a_moved_handle_moves_its_face_alone(handle: str, position: Point, wanted: dict[str, float]) -> None:
    look = Look(cut_handles=True)
    values = ClipBox(LOW, HIGH, ENDS).moved(look, handle, position)
    assert values == pytest.approx(wanted)
    # The model shows the handle where it was let go, so that it does not move.
    at = ClipBox(LOW, HIGH).drawings(replace(look, **wanted))  # type: ignore[arg-type]
    shown = next(one for one in at if isinstance(one, Gizmo) and one.name == handle)
    axis = int(np.flatnonzero(shown.axes)[0])
    value = next(iter(wanted.values()))
    assert shown.position[axis] == pytest.approx(min(max(value, LOW[axis]), HIGH[axis]))


def test_without_handles_the_edges_are_drawn_where_the_box_cuts() -> None:
    box = ClipBox(LOW, HIGH)
    assert box.drawings(Look()) == []
    assert [type(one) for one in box.drawings(Look(cut_high=2.0))] == [Segments]
    assert box.moved(Look(), "band-low", (0.0, 0.0, 1.0)) is None
    assert not asdict(Look())["cut_handles"]
