"""Meshes: areas and volumes against closed forms, all faces oriented outwards."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.simulation import WORLDS
from server.scenes.shapes import arrow, boxes, extruded, triangles


def area_of(polygon: np.ndarray) -> float:
    x, y = polygon.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def volume_of(vertices: np.ndarray, faces: np.ndarray) -> float:
    """The divergence theorem; a missing bottom at z = 0 adds nothing."""
    a, b, c = (vertices[faces[:, i]].astype(np.float64) for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


L_SHAPE = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)], dtype=float)
COMB = np.array([(0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (4, 1), (4, 3), (3, 3), (3, 1), (1, 1), (1, 3), (0, 3)], float)


@pytest.mark.parametrize("polygon", [L_SHAPE, COMB, L_SHAPE[[3, 4, 5, 0, 1, 2]]], ids=["L", "comb", "L turned"])
def test_triangles_cover_the_polygon_once(polygon: np.ndarray) -> None:
    found = triangles(polygon)
    assert found.shape == (len(polygon) - 2, 3)
    areas = [area_of(polygon[list(triangle)]) for triangle in found]
    assert min(areas) > 0.0
    assert sum(areas) == pytest.approx(area_of(polygon))


def test_a_polygon_with_three_corners_on_a_line_ends() -> None:
    polygon = np.array([(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)], dtype=float)
    areas = [area_of(polygon[list(triangle)]) for triangle in triangles(polygon)]
    assert sum(areas) == pytest.approx(4.0)


@pytest.mark.parametrize("name", list(WORLDS))
def test_every_world_has_the_volume_of_its_solids(name: str) -> None:
    solids = WORLDS[name].solids
    vertices, faces = extruded(solids, 0.5)
    assert vertices.dtype == np.float32
    assert faces.dtype == np.uint32
    assert faces.max() < len(vertices)
    assert volume_of(vertices, faces) == pytest.approx(0.5 * sum(area_of(solid) for solid in solids), rel=1e-4)


def test_boxes_have_their_volumes() -> None:
    low = np.array([(0.0, 0.0, 0.0), (5.0, 5.0, 0.0)])
    high = np.array([(1.0, 2.0, 3.0), (6.0, 6.0, 0.5)])
    vertices, faces = boxes(low, high)
    assert volume_of(vertices, faces) == pytest.approx(6.0 + 0.5)
    np.testing.assert_allclose(vertices.reshape(2, 8, 3).min(axis=1), low)
    np.testing.assert_allclose(vertices.reshape(2, 8, 3).max(axis=1), high)


def test_nothing_makes_an_empty_mesh() -> None:
    vertices, faces = extruded([], 1.0)
    assert vertices.shape == (0, 3)
    assert faces.shape == (0, 3)
    vertices, faces = boxes(np.zeros((0, 3)), np.zeros((0, 3)))
    assert len(vertices) == len(faces) == 0


def test_the_arrow_points_forward() -> None:
    vertices, faces = arrow(0.4, 0.2, 0.02)
    tip = vertices[vertices[:, 0].argmax()]
    assert tip[:2] == pytest.approx((0.2, 0.0))
    assert volume_of(vertices, faces) > 0.0
