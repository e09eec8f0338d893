"""Planes of patches against NumPy's least squares, classes and costs of slopes that are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError
from mapper.costmap import LETHAL, NO_INFORMATION, CostmapConfig, Footprint, LayeredCostmap
from mapper.io.clouds import read_cloud
from mapper.terrain import SAFE, UNKNOWN, UNSAFE, PatchConfig, Patches, assess, find_ground, textbook

UTM = np.array([512_345.67, 5_403_210.98, 300.0])


def hillside(n: int, slope: float, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 8.0, (n, 3))
    points[:, 2] = slope * points[:, 0] + rng.normal(0.0, 0.02, n)
    return points


def test_planes_are_those_of_lstsq_in_utm_coordinates() -> None:
    points = hillside(2000, 0.3) + UTM
    patches = Patches.of(points, 2.0)
    for reach in (0, 1):
        planes = patches.planes(reach)
        local = points - patches.corner
        for row, col in ((0, 0), (1, 2), (3, 3)):
            middle = (np.array([col, row]) + 0.5) * 2.0
            inside = (np.abs(local[:, :2] - middle) <= (reach + 0.5) * 2.0).all(axis=1)
            x, y = (local[inside, :2] - middle).T
            wanted, rest, _, _ = np.linalg.lstsq(np.column_stack([np.ones_like(x), x, y]), local[inside, 2], rcond=None)
            np.testing.assert_allclose(planes[row, col, :3], wanted, rtol=0, atol=1e-9)
            assert planes[row, col, 4] == pytest.approx(np.sqrt(rest[0] / inside.sum()), rel=1e-9)
            assert planes[row, col, 5] == pytest.approx(np.arctan(np.hypot(*wanted[1:])))


def test_raw_utm_coordinates_lose_the_plane() -> None:
    """Reason for the centre: the sums of 10¹³ m² about the origin of UTM have few digits left for the slope."""
    points = hillside(200, 0.3)
    about_centre = textbook.plane_of(textbook.moments_of(points.tolist()))
    raw = textbook.moments_of((points + UTM).tolist())
    with np.errstate(all="ignore"):
        b = np.linalg.lstsq(raw[:3, :3], raw[:3, 3], rcond=None)[0][1]
    assert about_centre.b == pytest.approx(0.3, abs=1e-3)
    assert abs(b - about_centre.b) > 1e-4


def test_points_one_by_one_and_parents_are_the_points_at_once() -> None:
    points = hillside(300, 0.1)
    patches = Patches.of(points, 1.0)
    again = patches.emptied()
    for part in np.array_split(points, 7):
        again = again.with_points(part)
    np.testing.assert_array_equal(again.moments, patches.moments)
    np.testing.assert_allclose(patches.parents().moments, Patches.of(points, 2.0).moments, rtol=1e-12, atol=1e-12)


def test_ransac_leaves_out_what_is_not_on_the_plane() -> None:
    points = hillside(60, 0.2)
    points[:20, 2] += 3.0
    triples = np.random.default_rng(1).integers(0, 60, (40, 3))
    plane, inside = textbook.ransac_plane(points, triples, 0.1)
    np.testing.assert_array_equal(inside, np.arange(60) >= 20)
    assert plane.b == pytest.approx(0.2, abs=0.01)
    assert abs(textbook.plane_of(textbook.moments_of(points.tolist())).mean_height - plane.mean_height) > 0.5


def test_steep_rough_and_stepped_patches_are_unsafe_and_cost() -> None:
    flat, steep = hillside(4000, 0.05), hillside(4000, 0.6)
    kerb = hillside(4000, 0.0)
    kerb[kerb[:, 0] >= 4.0, 2] += 0.5
    config = PatchConfig(patch=2.0)
    assert (assess(Patches.of(flat, 2.0), config).classes == SAFE).all()
    assert (assess(Patches.of(steep, 2.0), config).classes == UNSAFE).all()
    points = kerb[(kerb[:, 0] < 6.0) | (kerb[:, 1] < 6.0)]
    every = Patches.of(points, 2.0)
    terrain = assess(every, config)
    safe_side, both_sides = terrain.classes[:, 0], terrain.classes[:, 1:3]
    assert (safe_side == SAFE).all()
    assert (both_sides == UNSAFE).all()
    assert terrain.classes[3, 3] == UNKNOWN

    costmap = LayeredCostmap(
        every.geometry, CostmapConfig(track_unknown_space=True), Footprint.circle(0.3), [terrain.layer()]
    )
    costmap.update()
    assert (costmap.costs[:, 1:3] == LETHAL).all()
    assert costmap.costs[3, 3] == NO_INFORMATION
    assert (costmap.costs[:, 0] < 100).all()
    assert "unsafe; slope" in terrain.why(0, 1)


@pytest.mark.data
def test_the_terrain_of_a_real_cloud_becomes_costs(data_dir: Path) -> None:
    """A hillside with houses: the roofs are lethal, most of the ground is not, and nothing is known outside."""
    points = read_cloud(data_dir / "pointclouds" / "samp24-utm.pcd").points
    ground = find_ground(points).is_ground
    config = PatchConfig(patch=3.0, max_slope=30.0, max_roughness=0.5, max_step=1.0)
    every = Patches.of(points, config.patch)
    terrain = assess(every.emptied().with_points(points[ground]), config, occupied=every)
    costmap = LayeredCostmap(
        every.geometry, CostmapConfig(track_unknown_space=True), Footprint.circle(0.3), [terrain.layer()]
    )
    costmap.update()
    cells = tuple(every.geometry.world_to_cell(points[:, :2]).T)
    lethal = costmap.costs[cells] == LETHAL
    assert lethal[~ground].mean() > 2.0 * lethal[ground].mean()
    empty = every.moments[..., 0] == 0.0
    assert (costmap.costs[empty] == NO_INFORMATION).all()
    assert empty.any()


def test_a_patch_with_points_but_no_ground_is_unsafe() -> None:
    points = hillside(1000, 0.0)
    every = Patches.of(points, 2.0)
    ground = every.emptied().with_points(points[points[:, 0] < 4.0])
    assert (assess(ground, PatchConfig(patch=2.0), occupied=every).classes[:, 2:] == UNSAFE).all()


def test_bad_clouds_are_named() -> None:
    with pytest.raises(ConfigError, match="no finite points"):
        Patches.of(np.full((3, 3), np.nan), 1.0)
    with pytest.raises(ConfigError, match=r"shape \(n, 3\)"):
        Patches.of(np.zeros((3, 2)), 1.0)
    with pytest.raises(LimitError, match="leave out points that are far"):
        Patches.of(np.array([[0.0, 0, 0], [1e7, 1e7, 0]]), 1.0)
