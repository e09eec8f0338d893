"""World: the solids of one floor, with clearance and nearest free positions."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.grid import GridGeometry
from mapper.simulation.blocks import Block
from mapper.simulation.kernels.raycast import clearances

LATTICE_STEP = 0.1  #: metres between the points of a world's clearance lattice
BLOCK = 8  # cells per side of the blocks in which the lattice is computed
CANDIDATES = 16  # positions that nearest_free() refines
FINER = 60  # points of its finer lattice between the target and the first result
TOUCH = 1e-3  # metres: a point nearer to a wall than this is not free
LASER_HEIGHT = 0.3  #: metres: the plane of the lidar and the sonars
ROBOT_HEIGHT = 0.5  #: metres: higher solids do not stop the robot,
STEP_HEIGHT = 0.03  #: nor do solids lower than this


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Solid polygons inside a closed outer wall.

    ``bounds`` is (x_min, y_min, x_max, y_max) in metres, map frame, the outer face of the outer wall. ``solids`` are
    polygons (n, 2), n ≥ 3, simple but not necessarily convex, which may overlap; they are stored counter-clockwise, and
    are obstacles for the lidar and the robot. ``blocks`` are solids with individual heights, such as a low table or a
    lintel. ``start`` is the initial pose (x, y, yaw) of a robot. ``segments`` (n, 4) are the edges ``(ax, ay, bx, by)``
    of everything that stops the robot, ``seen`` (n, 4) those in the plane of the lidar, at :data:`LASER_HEIGHT`. Raises
    :class:`ConfigError` for an invalid polygon or empty bounds.
    """

    name: str
    title: str
    bounds: tuple[float, float, float, float]
    solids: tuple[Float64Array, ...]
    start: tuple[float, float, float]
    blocks: tuple[Block, ...] = ()
    segments: Float64Array = field(init=False, repr=False)
    seen: Float64Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        x0, y0, x1, y1 = self.bounds
        if not (np.isfinite(self.bounds).all() and x0 < x1 and y0 < y1):
            raise ConfigError("world.bounds", f"The world’s bounds must be a box, not {self.bounds!r}.")
        solids = tuple(_counter_clockwise(solid, i) for i, solid in enumerate(self.solids))
        object.__setattr__(self, "solids", solids)
        footprints = [
            block.outline
            for block in self.blocks
            if block.bottom < ROBOT_HEIGHT and float(block.heights.max()) > STEP_HEIGHT
        ]
        for name, polygons in (("segments", footprints), ("seen", self.sections)):
            edges = np.vstack([_edges(polygon) for polygon in (*solids, *polygons)] or [np.empty((0, 4))])
            edges.setflags(write=False)
            object.__setattr__(self, name, np.ascontiguousarray(edges))

    @property
    def sections(self) -> tuple[Float64Array, ...]:
        """The cross-sections of the blocks in the plane of the lidar, polygons (n, 2)."""
        polygons = [block.section(LASER_HEIGHT) for block in self.blocks]
        return tuple(section for section in polygons if section is not None)

    def in_laser_plane(self) -> World:
        """Return the world as seen by the lidar, with cross-sections of the blocks as solids."""
        return replace(self, solids=(*self.solids, *self.sections), blocks=()) if self.blocks else self

    def clearance(self, points_xy: ArrayLike) -> Float64Array:
        """Return the distance of each point (..., 2), metres, from the nearest solid (...), negative inside one.

        Outside the bounds it is −inf, because no position there is free.
        """
        points = np.asarray(points_xy, dtype=np.float64)
        flat = np.ascontiguousarray(points.reshape(-1, 2))
        out = np.empty(len(flat))
        clearances(self.segments, flat, out)
        x0, y0, x1, y1 = self.bounds
        inside = (flat[:, 0] > x0) & (flat[:, 0] < x1) & (flat[:, 1] > y0) & (flat[:, 1] < y1)
        return np.where(inside, out, -np.inf).reshape(points.shape[:-1])

    def is_free(self, xy: ArrayLike, radius: float = 0.0) -> bool:
        """Return whether a disc of ``radius`` metres at ``xy`` (2,) touches no solid and is within the bounds."""
        return bool(self.clearance(xy) >= radius) if radius > 0.0 else bool(self.clearance(xy) > 0.0)

    def nearest_free(self, xy: ArrayLike, radius: float = 0.0) -> Float64Array:
        """Return the position (2,) nearest to ``xy`` (2,) at which a disc of ``radius`` metres is free: ``xy`` if it
        is.

        The distance is exact to about a fiftieth, or 2 mm. Raises :class:`ConfigError` for a point that is not finite,
        and for a world without such a position.
        """
        target = np.asarray(xy, dtype=np.float64)
        if target.shape != (2,) or not np.isfinite(target).all():
            raise ConfigError(
                "world.point", f"A place must be two finite numbers, not {np.asarray(xy).tolist()!r:.80}."
            )
        if self.is_free(target, radius):
            return target
        # From far outside all free points are about equally far, so the nearest position within the bounds decides.
        target = np.clip(target, self.bounds[:2], self.bounds[2:])
        lattice = clearance_lattice(self)
        free = np.argwhere(lattice.clearance >= max(radius, TOUCH))
        if not len(free):
            raise ConfigError("world.full", f"A robot of radius {radius:g} m fits nowhere in the world {self.name!r}.")
        points = lattice.geometry.cell_to_world(free)
        nearest = self._improved(points, target, radius)
        gap = float(np.hypot(*(nearest - target)))
        # Clearance is 1-Lipschitz, so no free position is nearer than the clearance missing here.
        lacking = max(radius, TOUCH) - float(self.clearance(target))
        if np.isfinite(lacking) and gap - lacking <= max(gap / FINER, 2.0 * TOUCH):
            return nearest
        # The lattice may have missed a nearer narrow position, which a finer lattice over the nearer area finds.
        offsets = np.linspace(-gap, gap, 2 * FINER + 1)
        nearer = target + np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
        nearer = nearer[np.hypot(*(nearer - target).T) < gap]
        nearer = nearer[self.clearance(nearer) >= max(radius, TOUCH)]
        return self._improved(np.vstack([nearer, nearest]), target, radius)

    def _improved(self, free: Float64Array, target: Float64Array, radius: float) -> Float64Array:
        """Return the position nearest to ``target`` on the straight free segments to it from ``free`` positions (n,
        2).
        """
        gaps = np.hypot(*(free - target).T)
        nearest = free[np.argsort(gaps, kind="stable")[:CANDIDATES]]
        steps = np.linspace(0.0, 1.0, 65)[:, None, None]
        points = nearest + steps * (target - nearest)
        free_so_far = np.logical_and.accumulate(self.clearance(points) >= max(radius, TOUCH), axis=0)
        ends = points[np.maximum(free_so_far.sum(axis=0), 1) - 1, np.arange(len(nearest))]
        return np.asarray(ends[np.argmin(np.hypot(*(ends - target).T))], dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class ClearanceLattice:
    """A world's clearance at the centres of square cells: ``clearance`` (rows, cols), metres."""

    geometry: GridGeometry
    clearance: Float64Array


@lru_cache(maxsize=16)
def clearance_lattice(world: World) -> ClearanceLattice:
    """Return the clearance at every :data:`LATTICE_STEP` of the world, computed once per world."""
    x0, y0, x1, y1 = world.bounds
    rows, cols = (int(np.ceil((high - low) / LATTICE_STEP)) for low, high in ((y0, y1), (x0, x1)))
    geometry = GridGeometry(LATTICE_STEP, rows, cols, (x0, y0, 0.0))
    # In blocks, some extending beyond the border, because neighbours share their search for the nearest edge.
    across, up = -(-cols // BLOCK), -(-rows // BLOCK)
    cells = np.stack(np.meshgrid(np.arange(up * BLOCK), np.arange(across * BLOCK), indexing="ij"), axis=-1)
    blocks = cells.reshape(up, BLOCK, across, BLOCK, 2).transpose(0, 2, 1, 3, 4)
    free = world.clearance(geometry.cell_to_world(blocks))
    clearance = np.ascontiguousarray(free.transpose(0, 2, 1, 3).reshape(up * BLOCK, across * BLOCK)[:rows, :cols])
    clearance.setflags(write=False)
    return ClearanceLattice(geometry, clearance)


def _edges(vertices: Float64Array) -> Float64Array:
    """Return the edges (n, 4), ``(ax, ay, bx, by)``, of a polygon (n, 2)."""
    edges = np.empty((len(vertices), 4))
    edges[:, :2] = vertices
    edges[:-1, 2:], edges[-1, 2:] = vertices[1:], vertices[0]
    return edges


def _counter_clockwise(polygon: ArrayLike, index: int) -> Float64Array:
    vertices = np.array(polygon, dtype=np.float64)
    if vertices.ndim != 2 or vertices.shape[0] < 3 or vertices.shape[1] != 2 or not np.isfinite(vertices).all():
        raise ConfigError("world.solid", f"Solid {index} must be at least three finite points (x, y).")
    ax, ay, bx, by = _edges(vertices).T
    area = 0.5 * float(np.sum(ax * by - ay * bx))  # the shoelace formula
    if area == 0.0:
        raise ConfigError("world.solid", f"Solid {index} has no area.")
    vertices = np.ascontiguousarray(vertices if area > 0.0 else vertices[::-1])
    vertices.setflags(write=False)
    return vertices
