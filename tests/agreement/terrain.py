"""Terrain, for the table: small random clouds on slopes with bumps and gaps, by the kernels and by the textbook."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.terrain import GroundConfig, Patches, agreeing, assess, find_ground, textbook, textbook_ground
from mapper.terrain.parameters import PatchConfig
from mapper.terrain.patches import TRIALS


@dataclass(frozen=True)
class TerrainCase:
    points: np.ndarray
    ground: GroundConfig
    patches: PatchConfig
    reach: int


@st.composite
def terrain_cases(draw: st.DrawFn) -> TerrainCase:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    n, wide, high = draw(st.sampled_from([1, 2, 40, 120])), draw(st.floats(0.5, 9.0)), draw(st.floats(0.5, 9.0))
    points = rng.uniform([0.0, 0.0, -0.1], [wide, high, 0.1], (n, 3))
    points[:, 2] += points[:, :2] @ rng.normal(0.0, 0.4, 2)
    points[rng.random(n) < 0.3, 2] += draw(st.sampled_from([0.0, 2.0, -8.0]))
    cell = draw(st.sampled_from([0.7, 1.0]))
    ground = GroundConfig(cell=cell, window=draw(st.sampled_from([1.0, 3.0])), passes=draw(st.sampled_from([1.0, 2.0])))
    rule = draw(st.sampled_from(["weighted_sum", "thresholds"]))
    return TerrainCase(
        points, ground, PatchConfig(patch=1.5 * cell, min_points=6, rule=rule), draw(st.sampled_from([0, 1, 3]))
    )


def ground_by_kernel(case: TerrainCase) -> tuple[Any, ...]:
    found = find_ground(case.points, case.ground)
    return found.is_ground, found.surface, found.is_unsure


def ground_by_textbook(case: TerrainCase) -> tuple[Any, ...]:
    config, corner = case.ground, case.points.min(axis=0)
    cols, rows = (int(side) + 1 for side in (np.ptp(case.points, axis=0)[:2] / config.cell))
    radius = min(math.ceil(config.window / config.cell), max(rows, cols))
    return textbook_ground.ground_points(case.points, corner, (rows, cols), radius, config)


def patches_by_kernel(case: TerrainCase) -> tuple[Any, ...]:
    """The planes of windows, those of the parents, and the steps and scores of patches."""
    patches = Patches.of(case.points, case.patches.patch)
    terrain = assess(patches, case.patches)
    planes, parents = patches.planes(case.reach), patches.parents().planes()
    for some in (planes, parents):
        some[..., 4] **= 2  # its root has half of the digits
    return planes, parents, terrain.steps, terrain.score


def patches_by_textbook(case: TerrainCase) -> tuple[Any, ...]:
    config, size = case.patches, case.patches.patch
    local = case.points - case.points.min(axis=0)
    rows, cols = Patches.of(case.points, size).moments.shape[:2]
    grid = np.zeros((rows, cols, 4, 4))
    for x, y, z in local:
        row, col = int(y * (1.0 / size)), int(x * (1.0 / size))
        grid[row, col] = textbook.add_point(grid[row, col], x - (col + 0.5) * size, y - (row + 0.5) * size, z)
    windows = np.array(
        [
            [_numbers(textbook.plane_of(textbook.window_moments(grid, r, c, case.reach, size))) for c in range(cols)]
            for r in range(rows)
        ]
    )
    above = textbook.parents(grid, size)
    parents = np.array([[_numbers(textbook.plane_of(moments)) for moments in line] for line in above])
    enough = [
        [moments if moments[0, 0] >= config.min_points else textbook.NOTHING for moments in line] for line in grid
    ]
    planes = [[textbook.plane_of(moments) for moments in line] for line in enough]
    steps, scores = np.full((rows, cols), math.nan), np.full((rows, cols), math.nan)
    most = (math.radians(config.max_slope), config.max_roughness, config.max_step)
    weights = (config.slope_weight, config.roughness_weight, config.step_weight)
    for r, c in np.ndindex(rows, cols):
        plane = planes[r][c]
        if not math.isnan(plane.a):
            gap = steps[r, c] = textbook.step(planes, r, c, size)
            rule = textbook.greatest if config.rule == "thresholds" else textbook.score
            scores[r, c] = rule(plane.slope, plane.roughness, gap, most, weights)
    return windows, parents, steps, scores


def _numbers(plane: textbook.Plane) -> list[float]:
    return [plane.a, plane.b, plane.c, plane.mean_height, plane.roughness**2, plane.slope]


def consensus_by_kernel(case: TerrainCase) -> tuple[Any, ...]:
    patches = Patches.of(case.points, 2.0 * case.patches.patch)
    return (agreeing(case.points, patches, 0.07),)


def consensus_by_textbook(case: TerrainCase) -> tuple[Any, ...]:
    size = 2.0 * case.patches.patch
    local = case.points - case.points.min(axis=0)
    places = np.floor(local[:, :2] * (1.0 / size))
    out = np.zeros(len(local), dtype=np.bool_)
    for place in np.unique(places, axis=0):
        mine = np.flatnonzero((places == place).all(axis=1))
        points = local[mine] - (*((place + 0.5) * size), 0.0)
        out[mine] = textbook.ransac_plane(points, textbook.triples_of(len(mine), TRIALS), 0.07)[1]
    return (out,)
