"""Costmaps: inflation beside a wavefront as Nav2's and SciPy's distance transform; a changed box; a goal that moves."""

from __future__ import annotations

import contextlib
import math
import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numba import njit
from scipy.ndimage import distance_transform_edt

from mapper.core.array_types import Float64Array, Int64Array, UInt8Array
from mapper.core.errors import MapperError
from mapper.costmap import LETHAL, CostmapConfig, Footprint, InflationConfig, InflationLayer, KeepoutLayer
from mapper.costmap.build import build_costmap
from mapper.costmap.costs import cost_table
from mapper.costmap.inflation import inflate, radius_in_cells
from mapper.costmap.layered import LayeredCostmap
from mapper.grid import GridGeometry
from mapper.io.logs import open_log
from mapper.io.maps.pixels import occupancy_values
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.planning import GoalPlanner, PlannerConfig, plan_path
from server.stream.grid_layer import GridLayer
from tests.bench.limits import inflation_limit

SIDE, RESOLUTION, INSCRIBED = 2048, 0.05, 0.1


@njit(cache=True)
def wavefront(costs, levels, table, radius, heads, tails, after, cells, sources, seen, out):
    """Inflate as Nav2's inflation_layer.cpp does: cells wait in bins by their distance from the obstacle's cell.

    ``levels`` and ``table`` are of squared distances: the number of the bin, and the cost.
    """
    rows, cols = costs.shape
    flat, costs_of = out.reshape(-1), costs.reshape(-1)
    flat[:] = costs_of
    seen[:] = False
    heads[:] = -1
    n = 0
    for cell in range(costs_of.shape[0]):
        if costs_of[cell] == 254:
            cells[n], sources[n], after[n] = cell, cell, -1
            if heads[0] < 0:
                heads[0] = n
            else:
                after[tails[0]] = n
            tails[0] = n
            n += 1
    for level in range(heads.shape[0]):
        entry = heads[level]
        while entry >= 0:
            cell, source = cells[entry], sources[entry]
            if not seen[cell]:
                seen[cell] = True
                row, col = cell // cols, cell % cols
                at_row, at_col = source // cols, source % cols
                cost = table[(row - at_row) ** 2 + (col - at_col) ** 2]
                old = flat[cell]
                flat[cell] = cost if old == 255 and cost >= 253 else max(old, cost)
                for k in range(4):
                    to_row, to_col = row + (k == 0) - (k == 1), col + (k == 2) - (k == 3)
                    to = to_row * cols + to_col
                    if to_row < 0 or to_col < 0 or to_row >= rows or to_col >= cols or seen[to]:
                        continue
                    squared = (to_row - at_row) ** 2 + (to_col - at_col) ** 2
                    if squared > radius * radius:
                        continue
                    place = levels[squared]
                    cells[n], sources[n], after[n] = to, source, -1
                    if heads[place] < 0:
                        heads[place] = n
                    else:
                        after[tails[place]] = n
                    tails[place] = n
                    n += 1
            entry = after[entry]


def by_wavefront(costs: np.ndarray, radius: int) -> Callable[[], np.ndarray]:
    """Return a function that inflates ``costs``, with its memory made beforehand."""
    distances = sorted({a * a + b * b for a in range(radius + 1) for b in range(a + 1) if a * a + b * b <= radius**2})
    levels = np.zeros(radius * radius + 1, dtype=np.int64)
    levels[distances] = np.arange(len(distances))
    table = cost_table(radius, RESOLUTION, INSCRIBED, 10.0)
    heads, tails = np.empty(len(distances), dtype=np.int64), np.empty(len(distances), dtype=np.int64)
    lists = [np.empty(5 * costs.size, dtype=np.int32) for _ in range(3)]
    seen, out = np.empty(costs.size, dtype=np.bool_), np.empty_like(costs)

    def run() -> np.ndarray:
        wavefront(costs, levels, table, radius, heads, tails, lists[0], lists[1], lists[2], seen, out)
        return out

    return run


def maps() -> dict[str, np.ndarray]:
    """Ten walls of 200 cells, and 366,000 obstacles at random places."""
    rng = np.random.default_rng(1)
    sparse, dense = np.zeros((SIDE, SIDE), dtype=np.uint8), np.zeros((SIDE, SIDE), dtype=np.uint8)
    for row, col in rng.integers(0, SIDE - 200, (10, 2)):
        sparse[row, col : col + 200] = LETHAL
    dense.reshape(-1)[rng.choice(dense.size, 366_000, replace=False)] = LETHAL
    return {"sparse": sparse, "dense": dense}


def best_cpu_ms(works: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the least processor time of each, over all threads, in ms; they take turns.

    Each is called once just before it is measured, so that none finds the caches as another one left them.
    """
    best = dict.fromkeys(works, math.inf)
    for _ in range(rounds):
        for name, work in works.items():
            work()
            began = time.process_time()
            work()
            best[name] = min(best[name], 1e3 * (time.process_time() - began))
    return best


def inflation(rounds: int = 5) -> None:
    """Print the table of inflation, and how many cells the wavefront gets another cost for than the exact distance."""
    print(f"inflation of {SIDE}² cells of {RESOLUTION} m, ms of processor time, best of {rounds}")
    print("the limit: the cells of its passes read and written once each, without what the passes compute")
    columns = (
        "map", "radius", "ours", "limit", "ratio", "wavefront", "ratio", "SciPy's distances alone", "ratio",
        "costs that differ",
    )  # fmt: skip
    print(f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    for name, costs in maps().items():
        for metres in (0.55, 3.0):
            config = InflationConfig(inflation_radius=metres)
            out = np.empty_like(costs)
            radius = radius_in_cells(config, RESOLUTION)
            wave = by_wavefront(costs, radius)
            times = best_cpu_ms(
                {
                    "ours": partial(inflate, costs, config, RESOLUTION, INSCRIBED, out),
                    "limit": inflation_limit(costs, radius),
                    "wavefront": wave,
                    "scipy": partial(distance_transform_edt, costs != LETHAL),
                },
                rounds,
            )
            differ = int((wave() != out).sum())
            ours, limit, other, peer = times["ours"], times["limit"], times["wavefront"], times["scipy"]
            print(
                f"| {name} | {metres:g} m | {ours:.1f} | {limit:.1f} | {ours / limit:.2f} | "
                f"{other:.1f} | {other / ours:.1f} × | {peer:.0f} | "
                f"{peer / ours:.0f} × | {differ} |",
                flush=True,
            )


def changed_box(rounds: int = 50) -> None:
    """Print the processor time from a painted box of 100 × 100 cells to the costs, and to compressed tiles."""
    geometry = GridGeometry(RESOLUTION, SIDE, SIDE)
    keepout = KeepoutLayer(geometry)
    inflation = InflationLayer(geometry, InflationConfig(), INSCRIBED)
    costmap = LayeredCostmap(geometry, CostmapConfig(), Footprint.circle(INSCRIBED), [keepout], inflation)
    sheet = GridLayer("costmap", "Costmap", "costs")
    costmap.update()
    sheet.set(geometry, costmap.costs, 0.0, 254.0)
    sheet.publish()
    cursor = sheet.cursor()
    while cursor.is_behind():
        cursor.take(1 << 30, 1 << 30, (0.0, 0.0), always=True)
    to_costs, to_tiles = [], []
    for k in range(rounds):
        corner = np.array([20.0 + k % 7, 30.0])
        keepout.paint(corner + 5.0 * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), 100 if k % 2 else 0)
        began = time.process_time()
        box = costmap.update()
        to_costs.append(1e3 * (time.process_time() - began))
        sheet.set(geometry, costmap.costs, 0.0, 254.0, box=box)
        sheet.publish()
        cursor.take(1 << 30, 1 << 30, (0.0, 0.0), always=True)
        to_tiles.append(1e3 * (time.process_time() - began))
    for name, took in (("costs", to_costs), ("published, compressed tiles", to_tiles)):
        print(f"a changed box of 100 × 100 cells to {name}: median {np.median(took):.2f} ms, p95 {p95(took):.2f} ms")


def p95(values: list[float]) -> float:
    return float(np.percentile(values, 95))


def moving_goal(folder: Path, goals: int = 50) -> None:
    """Print the processor time of a path on Intel's map when the goal moves."""
    path = folder / "carmen" / "intel-corrected.log.gz"
    if not path.is_file():
        print("carmen: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
        return
    log, config = open_log(path), MappingConfig()
    grid = grid_for(log, config)
    integrate_log(grid, log, config)
    costmap = build_costmap(grid.geometry, occupancy_values(grid)).costmap
    costmap.update()
    start = log.trajectory().poses[0, :2]
    open_cells = np.argwhere(costmap.costs < 100)
    rng = np.random.default_rng(2)
    for name, planner in (("Dijkstra", PlannerConfig()), ("A*", PlannerConfig(use_astar=True))):
        took: list[float] = []
        lengths = []
        for k in rng.permutation(len(open_cells)):
            goal = grid.geometry.cell_to_world(open_cells[k])
            began = time.process_time()
            try:
                found = plan_path(costmap.costs, grid.geometry, start, goal, planner)
            except MapperError:
                continue  # an island of free cells behind a wall
            took.append(1e3 * (time.process_time() - began))
            lengths.append(found.length)
            if len(took) > goals:
                break
        print(
            f"{name} on Intel's map, {grid.geometry.size_text} cells, {goals} goals, paths of {min(lengths):.0f} … "
            f"{max(lengths):.0f} m: median {np.median(took[1:]):.1f} ms, p95 {p95(took[1:]):.1f} ms",
            flush=True,
        )
    dragged(costmap.costs, grid.geometry, start, rng.permutation(open_cells)[:200])


def dragged(costs: UInt8Array, geometry: GridGeometry, start: Float64Array, cells: Int64Array) -> None:
    """Print the processor time of a path to each of some cells while the costs and the start stay: a goal dragged."""
    planner = GoalPlanner(costs, geometry, start)
    took: list[float] = []
    for cell in cells:
        began = time.process_time()
        with contextlib.suppress(MapperError):
            planner.plan(start, geometry.cell_to_world(cell))
            took.append(1e3 * (time.process_time() - began))
    print(
        f"a dragged goal, {len(took)} places: median {np.median(took):.2f} ms, p95 {p95(took):.2f} ms, "
        f"the two searches {took[0]:.1f} and {max(took[1:]):.1f} ms",
        flush=True,
    )


def costmap() -> None:
    """Print all of the above."""
    inflation()
    changed_box()
    moving_goal(Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data")))
