"""Ray casting and clearance against closed forms and dense sampling."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from mapper.simulation import WORLDS, SensorConfig, World
from mapper.simulation.kernels.raycast import (
    arc_clearance,
    chord_clearance,
    clearances,
    farthest_in_sight,
    nearest_edge,
)
from mapper.simulation.lidar import TURN, true_ranges
from mapper.simulation.shapes import disc, outer_walls, rect, star
from mapper.simulation.worlds import clearance_lattice

SQUARE = World("square", "Square", (-3.2, -3.2, 3.2, 3.2), tuple(outer_walls(-3.2, -3.2, 3.2, 3.2, 0.2)), (0, 0, 0))


def bearings(sensor: SensorConfig, yaw: float) -> np.ndarray:
    return yaw + sensor.angle_min + sensor.angle_increment * np.arange(sensor.n_beams)


@given(
    st.floats(-2.9, 2.9), st.floats(-2.9, 2.9), st.floats(-7.0, 7.0), st.integers(30, 1080), st.floats(TURN / 12, TURN)
)
def test_a_square_room_has_the_distances_of_geometry(x, y, yaw, n_beams, field_of_view):
    sensor = SensorConfig(n_beams=n_beams, field_of_view=field_of_view, range_max=30.0)
    angle = bearings(sensor, yaw)
    with np.errstate(divide="ignore"):
        to_x = np.where(np.cos(angle) > 0, 3.0 - x, 3.0 + x) / np.abs(np.cos(angle))
        to_y = np.where(np.sin(angle) > 0, 3.0 - y, 3.0 + y) / np.abs(np.sin(angle))
    np.testing.assert_allclose(true_ranges(SQUARE, sensor, (x, y, yaw)), np.minimum(to_x, to_y), rtol=1e-9)


@given(st.floats(1.0, 4.0), st.floats(-np.pi, np.pi), st.floats(0.2, 0.8))
def test_a_disc_looks_as_wide_and_as_near_as_a_circle(distance, bearing, radius):
    sensor = SensorConfig(n_beams=720, range_max=10.0)
    world = World("disc", "Disc", (-9, -9, 9, 9), (disc(0.0, 0.0, radius, 720),), (5, 5, 0))
    x, y = -distance * np.cos(bearing), -distance * np.sin(bearing)
    if distance <= radius * 1.05:
        return
    got = true_ranges(world, sensor, (x, y, 0.0))
    off = np.mod(bearings(sensor, 0.0) - bearing + np.pi, TURN) - np.pi
    half_angle = np.arcsin(radius / distance)
    seen = np.isfinite(got)
    assert np.all(seen[np.abs(off) < half_angle - 0.01])
    assert not np.any(seen[np.abs(off) > half_angle + 1e-6])
    # The near root of |d·t − c|² = r², away from the rim where the polygon's chord shows.
    inner = np.abs(off) < 0.8 * half_angle
    expected = distance * np.cos(off[inner]) - np.sqrt(radius**2 - (distance * np.sin(off[inner])) ** 2)
    np.testing.assert_allclose(got[inner], expected, atol=1e-4)


def test_a_star_looks_the_same_from_each_of_its_axes():
    world = World("star", "Star", (-9, -9, 9, 9), (star(0.0, 0.0, 1.5, 0.7, 8),), (5, 5, 0))
    sensor = SensorConfig(n_beams=360, range_max=10.0)
    views = []
    for k in range(8):
        angle = k * np.pi / 4
        views.append(true_ranges(world, sensor, (4.0 * np.cos(angle), 4.0 * np.sin(angle), angle + np.pi)))
    for view in views:
        hit = np.isfinite(views[0]) & np.isfinite(view)
        assert hit.sum() >= np.isfinite(views[0]).sum() - 2  # a beam along a spike's edge may fall either way
        np.testing.assert_allclose(view[hit], views[0][hit], atol=1e-6)
    np.testing.assert_allclose(views[0][180], 2.5)


@pytest.mark.parametrize("name", WORLDS)
def test_no_beam_passes_a_wall_and_none_ends_in_the_air(name):
    """Points every 5 mm along each beam, tested by even-odd crossings of each polygon, find the first solid."""
    world = WORLDS[name]
    sensor = SensorConfig(n_beams=30, range_max=12.0)
    rng = np.random.default_rng(3)
    x0, y0, x1, y1 = world.bounds
    for _ in range(6):
        place = world.nearest_free(rng.uniform((x0, y0), (x1, y1)), 0.2)
        yaw = rng.uniform(-4.0, 4.0)
        got = true_ranges(world, sensor, (*place, yaw))
        along = np.arange(0.0, 12.0, 0.005)
        angle = bearings(sensor, yaw)[:, None]
        points = place + along[None, :, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        solid = np.zeros(points.shape[:2], dtype=bool)
        for polygon in world.in_laser_plane().solids:
            solid |= inside(polygon, points)
        first = np.where(solid.any(axis=1), along[solid.argmax(axis=1)], np.inf)
        before = np.minimum(got, 12.0)
        # The first solid sample lies within one step behind the hit; a sliver thinner than a step may be missed.
        missed = ~np.isclose(np.minimum(first, 12.0), before, atol=0.0051)
        assert missed.sum() <= 1
        assert np.all(before <= np.minimum(first, 12.0) + 1e-9)


def inside(polygon: np.ndarray, points: np.ndarray) -> np.ndarray:
    odd = np.zeros(points.shape[:-1], dtype=bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if ay == by:
            continue
        spans = (ay > points[..., 1]) != (by > points[..., 1])
        odd ^= spans & (points[..., 0] < ax + (points[..., 1] - ay) * (bx - ax) / (by - ay))
    return odd


def test_no_beam_slips_between_two_solids_that_touch_or_through_a_vertex():
    row = tuple(rect(2.0, -3.0 + k, 2.5, -2.0 + k) for k in range(6))
    world = World("row", "Row", (-9, -9, 9, 9), row, (0, 0, 0))
    sensor = SensorConfig(n_beams=1080, field_of_view=TURN / 12, range_max=30.0)
    for y in (-1.0, 0.0, 1.0):  # straight at the seams
        got = true_ranges(world, sensor, (0.0, y, 0.0))
        np.testing.assert_allclose(got * np.cos(bearings(sensor, 0.0)), 2.0, rtol=1e-9)


def test_beyond_its_range_the_sensor_sees_nothing():
    assert np.all(np.isinf(true_ranges(SQUARE, SensorConfig(range_max=2.9), (0.0, 0.0, 0.0))))
    assert np.all(np.isfinite(true_ranges(SQUARE, SensorConfig(range_max=4.3), (0.0, 0.0, 0.0))))


def test_clearance_of_a_box_is_its_closed_form():
    solid = rect(-1.0, -0.5, 1.0, 0.5)
    points = np.random.default_rng(0).uniform(-3, 3, (500, 2))
    got = np.empty(500)
    clearances(np.hstack([solid, np.roll(solid, -1, axis=0)]), points, got)
    beyond = np.abs(points) - (1.0, 0.5)
    outside = np.hypot(*np.maximum(beyond, 0.0).T)
    np.testing.assert_allclose(got, np.where(outside > 0.0, outside, beyond.max(axis=1)), atol=1e-12)


def test_the_nearest_edge_is_where_the_clearance_says():
    world = WORLDS["hall"]
    for point in np.random.default_rng(1).uniform((1, 1), (21, 15), (200, 2)):
        nearest = np.zeros(2)
        clearance = nearest_edge(world.segments, point[0], point[1], nearest)
        np.testing.assert_allclose(np.hypot(*(point - nearest)), abs(clearance), atol=1e-12)


def clearances_one_by_one(segments: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Clearance of each point by itself by the kernel: every edge is tried."""
    nearest = np.zeros(2)
    return np.array([nearest_edge(segments, x, y, nearest) for x, y in points])


@pytest.mark.parametrize("name", WORLDS)
def test_points_that_share_a_search_get_the_bits_that_each_gets_alone(name):
    world = WORLDS[name]
    lattice = clearance_lattice(world)
    cells = np.argwhere(np.isfinite(lattice.clearance))
    single_threaded = clearances_one_by_one(world.segments, lattice.geometry.cell_to_world(cells))
    np.testing.assert_array_equal(lattice.clearance[tuple(cells.T)], single_threaded)
    # Vertices and edges' middles, where several edges are equally near; scattered places; places that are none.
    a, b = world.segments[:, :2], world.segments[:, 2:]
    far = [(np.inf, 0.0), (np.nan, 1.0), (1e300, -1e300), (1e9, 2.0), (3.0, -np.inf)]
    points = np.vstack([a, 0.5 * (a + b), np.random.default_rng(2).uniform(-5, 30, (500, 2)), far])
    got = np.empty(len(points))
    clearances(world.segments, points, got)
    np.testing.assert_array_equal(got, clearances_one_by_one(world.segments, points))


def test_a_lattice_costs_less_than_half_of_its_points_one_by_one():
    world = WORLDS["office"]
    points = clearance_lattice(world).geometry.cell_to_world(np.argwhere(clearance_lattice(world).clearance > -np.inf))

    @njit(nogil=True)
    def one_by_one(segments, points, out):
        nearest = np.zeros(2)
        for i in range(len(points)):
            out[i] = nearest_edge(segments, points[i, 0], points[i, 1], nearest)

    def cpu(job: Callable[[], object]) -> float:
        job()
        times = []
        for _ in range(3):
            began = time.thread_time()
            job()
            times.append(time.thread_time() - began)
        return min(times)

    out = np.empty(len(points))
    single_threaded = cpu(lambda: one_by_one(world.segments, points, out))
    assert cpu(lambda: clearance_lattice.__wrapped__(world)) < 0.5 * single_threaded


@given(st.floats(-2.5, 2.5), st.floats(-2.5, 2.5), st.floats(-2.5, 2.5), st.floats(-2.5, 2.5))
def test_clearance_along_a_chord_is_the_least_of_its_points(x0, y0, x1, y1):
    solids = (rect(-1.0, -0.5, 1.0, 0.5), star(1.5, 1.5, 0.6, 0.3, 5))
    world = World("two", "Two", (-9, -9, 9, 9), solids, (5, 5, 0))
    points = np.linspace((x0, y0), (x1, y1), 400)
    sampled = world.clearance(points)
    got = chord_clearance(world.segments, x0, y0, x1, y1)
    spacing = np.hypot(x1 - x0, y1 - y0) / 399
    if np.all(sampled > 0.0):
        assert got <= sampled.min() + 1e-9
        assert got >= sampled.min() - spacing
    elif not np.all(sampled < 0.0):
        assert got <= spacing


def test_the_farthest_point_in_sight_is_the_last_with_a_wide_way():
    solids = (rect(-1.0, -0.5, 1.0, 0.5),)
    world = World("one", "One", (-9, -9, 9, 9), solids, (5, 5, 0))
    angles = np.linspace(0.0, 2.0 * np.pi, 40)
    path = np.stack([3.0 * np.cos(angles), 2.0 * np.sin(angles)], axis=-1)  # around the solid
    for room in (0.1, 0.5, 5.0):
        wide = [k for k in range(1, 30) if chord_clearance(world.segments, *path[0], *path[k]) >= room]
        assert farthest_in_sight(world.segments, path[0, 0], path[0, 1], path, 29, room) == max(wide, default=0)


def test_clearance_along_an_arc_follows_the_circle():
    # A unicycle at 1 m/s and 1 rad/s circles the point to its left, 1 m away; a wall touches that circle's top.
    wall = rect(-3.0, 2.5, 3.0, 2.7)
    edges = np.hstack([wall, np.roll(wall, -1, axis=0)])
    assert arc_clearance(edges, 0.0, 0.0, 0.0, 1.0, 1.0, np.pi, 64) == pytest.approx(0.5)
    # And straight on towards its left end: 1 m away at first, 0.25 m after 0.75 s.
    assert arc_clearance(edges, -4.0, 2.6, 0.0, 1.0, 0.0, 0.75, 8) == pytest.approx(0.25)
