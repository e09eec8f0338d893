"""Costmaps, for the table: random costs and observations, by the kernels and by the textbook."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.costmap import textbook
from mapper.costmap.costs import cells_of
from mapper.costmap.denoise_layer import DenoiseLayer
from mapper.costmap.inflation import inflate, radius_in_cells
from mapper.costmap.kernels.marking import Marking
from mapper.costmap.kernels.observation import clear_lines, lay_over, mark_cells
from mapper.costmap.kernels.voxels import Heights, clear_columns, mark_columns
from mapper.costmap.layers import static_costs
from mapper.costmap.parameters import CostmapConfig, DenoiseConfig, InflationConfig, StaticConfig
from mapper.grid import GridGeometry
from mapper.grid.cell_box import CellBox

VALUES = np.array([0, 0, 0, 0, 0, 0, 120, 253, 254, 255], dtype=np.uint8)
GROUP = 4  #: cells that a group of obstacles has at least, to stay
METHODS = ("overwrite", "max", "max_known", "true_overwrite")


@dataclass(frozen=True)
class CostmapCase:
    """Costs, the parameters of inflation, and an observation."""

    geometry: GridGeometry
    costs: np.ndarray
    over: np.ndarray
    inflation: InflationConfig
    inscribed_radius: float
    sensor: np.ndarray
    points: np.ndarray
    ranges: tuple[float, float]
    marking: Marking
    static: StaticConfig
    tracks_unknown: bool


@st.composite
def costmap_cases(draw: st.DrawFn) -> CostmapCase:
    """Maps of up to 90 × 300 cells, so that some have several tiles; points inside and outside of them."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    shape = draw(st.sampled_from([(1, 1), (1, 40), (30, 25), (90, 20), (20, 300)]))
    resolution = draw(st.sampled_from([0.05, 0.1, 0.25]))
    yaw = draw(st.sampled_from([0.0, 0.7]))
    geometry = GridGeometry(resolution, *shape, (-1.0, 0.5, yaw))
    share = draw(st.sampled_from([0.0, 0.01, 0.2]))
    costs = np.where(rng.random(shape) < share, rng.choice(VALUES, shape), 0).astype(np.uint8)
    middle = geometry.cell_to_world(((shape[0] - 1) / 2, (shape[1] - 1) / 2))
    sensor = np.append(middle + rng.normal(0.0, resolution, 2), 0.3)
    points = np.column_stack([sensor[:2] + rng.normal(0.0, 3.0, (20, 2)), rng.uniform(-0.5, 2.5, 20)])
    return CostmapCase(
        geometry,
        costs,
        rng.choice(VALUES, shape),
        InflationConfig(
            inflation_radius=draw(st.sampled_from([0.0, 0.05, 0.55, 1.3])),
            cost_scaling_factor=draw(st.sampled_from([0.0, 3.0, 10.0])),
            inflate_unknown=draw(st.booleans()),
            inflate_around_unknown=draw(st.booleans()),
        ),
        draw(st.sampled_from([0.0, 0.1, 0.3])),
        sensor,
        points,
        draw(st.sampled_from([(0.0, 3.0), (0.5, 2.0), (0.0, 100.0)])),
        Marking(0.2, draw(st.sampled_from([1.0, 4.0])), 0.0, 2.0),
        StaticConfig(
            trinary_costmap=draw(st.booleans()),
            lethal_cost_threshold=draw(st.sampled_from([1, 65, 100])),
            inscribed_obstacle_cost_value=draw(st.sampled_from([50, 99, 255])),
        ),
        draw(st.booleans()),
    )


def inflated_by_kernel(case: CostmapCase) -> tuple[Any, ...]:
    """Inflate the left half and then the right one, so that boxes are tested too."""
    out = np.zeros_like(case.costs)
    rows, cols = case.costs.shape
    for box in (CellBox(0, rows, 0, cols // 2), CellBox(0, rows, cols // 2, cols)):
        inflate(case.costs, case.inflation, case.geometry.resolution, case.inscribed_radius, out, box)
    return (out,)


def inflated_by_textbook(case: CostmapCase) -> tuple[Any, ...]:
    config, resolution = case.inflation, case.geometry.resolution
    radius = radius_in_cells(config, resolution)
    if radius == 0:
        return (case.costs,)
    return (
        textbook.inflate(
            case.costs, resolution, radius, case.inscribed_radius, config.cost_scaling_factor, config.inflate_unknown,
            config.inflate_around_unknown,
        ),
    )  # fmt: skip


def denoised_by_layer(case: CostmapCase) -> tuple[Any, ...]:
    """Denoise the whole, then a box of it in which costs changed, as an update does."""
    outs = []
    rows, cols = case.costs.shape
    for connectivity in (4, 8):
        general = CostmapConfig(track_unknown_space=case.tracks_unknown)
        config = DenoiseConfig(minimal_group_size=GROUP, group_connectivity_type=connectivity)
        layer = DenoiseLayer(case.geometry, config, general)
        master = case.over.copy()
        layer.lay(master, CellBox(0, rows, 0, cols))
        half = case.over.copy()
        half[:, : cols // 2] = case.costs[:, : cols // 2]
        box = CellBox(0, rows, 0, cols // 2).padded(layer.reach, rows, cols)
        master[:, : box.col1] = half[:, : box.col1]
        layer.lay(master, box)
        outs.append(master)
    return tuple(outs)


def denoised_by_textbook(case: CostmapCase) -> tuple[Any, ...]:
    half = case.over.copy()
    half[:, : half.shape[1] // 2] = case.costs[:, : half.shape[1] // 2]
    return tuple(textbook.denoise(half, GROUP, connectivity, not case.tracks_unknown) for connectivity in (4, 8))


def observed_by_kernel(case: CostmapCase) -> tuple[Any, ...]:
    out, box = case.costs.copy(), np.array([1 << 40, 0, 1 << 40, 0])
    least, most = (cells_of(one, case.geometry.resolution) for one in case.ranges)
    clear_lines(case.points, case.sensor, case.geometry.frame, least, most, np.uint8(0), out, box)
    mark_cells(case.points, case.sensor, case.geometry.frame, case.marking, np.uint8(254), out, box)
    changed = np.argwhere(out != case.costs)
    inside = all(box[0] <= r < box[1] and box[2] <= c < box[3] for r, c in changed)
    return out, inside


def observed_by_textbook(case: CostmapCase) -> tuple[Any, ...]:
    m = case.marking
    marking = (m.obstacle_min_range, m.obstacle_max_range, m.min_obstacle_height, m.max_obstacle_height)
    out = textbook.mark_and_clear(case.costs, case.geometry, case.sensor, case.points, marking, case.ranges)
    return out, True


def laid_by_kernel(case: CostmapCase) -> tuple[Any, ...]:
    outs = []
    for k in range(4):
        master = case.costs.copy()
        lay_over(case.over, k, master)
        outs.append(master)
    return tuple(outs)


def laid_by_textbook(case: CostmapCase) -> tuple[Any, ...]:
    return tuple(textbook.combine(case.costs, case.over, method) for method in METHODS)


def interpreted_by_table(case: CostmapCase) -> tuple[Any, ...]:
    return (static_costs(case.static, case.tracks_unknown),)


def interpreted_by_textbook(case: CostmapCase) -> tuple[Any, ...]:
    config = case.static
    return (
        np.array(
            [
                textbook.interpret_value(
                    value, case.tracks_unknown, int(config.lethal_cost_threshold), config.trinary_costmap,
                    int(config.unknown_cost_value), int(config.inscribed_obstacle_cost_value),
                )
                for value in range(256)
            ],
            dtype=np.uint8,
        ),
    )  # fmt: skip


@dataclass(frozen=True)
class VoxelCase:
    """Observations of a sensor and the columns that they mark and clear."""

    geometry: GridGeometry
    scans: tuple[tuple[np.ndarray, np.ndarray], ...]
    ranges: tuple[float, float]
    marking: Marking
    levels: int
    heights: tuple[float, float]
    mark_threshold: int
    unknown_threshold: int


@st.composite
def voxel_cases(draw: st.DrawFn) -> VoxelCase:
    """Grids of up to 30 × 40 columns; sensors and points inside and outside of them and of their heights."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    shape = draw(st.sampled_from([(1, 1), (1, 40), (30, 25)]))
    resolution = draw(st.sampled_from([0.05, 0.1, 0.25]))
    geometry = GridGeometry(resolution, *shape, (-1.0, 0.5, draw(st.sampled_from([0.0, 0.7]))))
    middle = np.append(geometry.cell_to_world(((shape[0] - 1) / 2, (shape[1] - 1) / 2)), 0.0)
    spread = draw(st.sampled_from([0.3, 2.0]))
    scans = []
    for _ in range(3):
        sensor = middle + np.append(rng.normal(0.0, resolution, 2), rng.uniform(-0.1, 1.0))
        points = sensor + np.column_stack([rng.normal(0.0, spread, (12, 2)), rng.uniform(-2.0, 2.0, 12)])
        points[0] = sensor
        scans.append((sensor, points))
    return VoxelCase(
        geometry,
        tuple(scans),
        draw(st.sampled_from([(0.0, 3.0), (0.25, 1.0)])),
        Marking(0.1, draw(st.sampled_from([1.0, 4.0])), draw(st.sampled_from([-1.0, 0.1])), 2.0),
        draw(st.sampled_from([1, 10, 16])),
        (draw(st.sampled_from([-0.2, 0.0])), draw(st.sampled_from([0.05, 0.2]))),
        draw(st.sampled_from([0, 2])),
        draw(st.sampled_from([0, 5, 15])),
    )


def voxels_by_kernel(case: VoxelCase) -> tuple[Any, ...]:
    costs = np.full(case.geometry.shape, 255, dtype=np.uint8)
    columns = np.full(case.geometry.shape, 0xFFFF, dtype=np.uint32)
    box = np.array([1 << 40, 0, 1 << 40, 0])
    heights = Heights(*case.heights, case.levels, case.mark_threshold, case.unknown_threshold + 16 - case.levels)
    least, most = (cells_of(one, case.geometry.resolution) for one in case.ranges)
    frame = case.geometry.frame
    for sensor, points in case.scans:
        clear_columns(points, sensor, frame, least, most, heights, columns, costs, box)
        mark_columns(points, sensor, frame, case.marking, heights, columns, costs, box)
    bits = columns[:, :, None] >> np.arange(case.levels, dtype=np.uint32)
    # Two bits of a marked voxel are set, one of an unknown one, none of a free one.
    voxels = ((bits & 1) + (bits >> np.uint32(16) & 1)).astype(np.uint8)
    inside = all(box[0] <= r < box[1] and box[2] <= c < box[3] for r, c in np.argwhere(costs != 255))
    return costs, voxels, inside


def voxels_by_textbook(case: VoxelCase) -> tuple[Any, ...]:
    costs = np.full(case.geometry.shape, 255, dtype=np.uint8)
    voxels = np.full((*case.geometry.shape, case.levels), textbook.VOXEL_UNKNOWN, dtype=np.uint8)
    m = case.marking
    marking = (m.obstacle_min_range, m.obstacle_max_range, m.min_obstacle_height, m.max_obstacle_height)
    thresholds = (case.mark_threshold, case.unknown_threshold)
    for sensor, points in case.scans:
        textbook.clear_voxels(voxels, costs, case.geometry, sensor, points, case.ranges, case.heights, thresholds)
        textbook.mark_voxels(voxels, costs, case.geometry, sensor, points, marking, case.heights, case.mark_threshold)
    return costs, voxels, True
