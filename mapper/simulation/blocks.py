"""Solids with heights: a convex outline, a flat bottom and a planar top, level or tilted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mapper.core.errors import ConfigError
from mapper.simulation.shapes import Point, Polygon, box, rect

CONVEX = 1e-9  #: tolerance of the cross product of two edges: collinear corners are allowed


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A solid over ``outline`` (n, 2), n ≥ 3, convex and counter-clockwise, metres in the map frame.

    It extends from z = ``bottom`` to the plane z = a + b·x + c·y of ``top`` (a, b, c), which is above the bottom at
    every corner. Raises :class:`ConfigError` for another outline or top.
    """

    outline: Polygon
    bottom: float
    top: tuple[float, float, float]

    def __post_init__(self) -> None:
        outline = np.array(self.outline, dtype=np.float64)
        if outline.ndim != 2 or outline.shape[0] < 3 or outline.shape[1] != 2 or not np.isfinite(outline).all():
            raise ConfigError("block.outline", "A block’s outline must be at least three finite points (x, y).")
        edges = np.roll(outline, -1, axis=0) - outline
        after = np.roll(edges, -1, axis=0)
        turns = edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]
        if not (turns > -CONVEX).all() or not (turns > CONVEX).any():
            raise ConfigError("block.outline", "A block’s outline must be convex and run counter-clockwise.")
        if not np.isfinite((self.bottom, *self.top)).all():
            raise ConfigError("block.heights", "A block’s bottom and top must be finite numbers.")
        outline.setflags(write=False)
        object.__setattr__(self, "outline", outline)
        if not (self.heights >= self.bottom).all() or not (self.heights > self.bottom).any():
            raise ConfigError("block.heights", f"A block’s top must lie above its bottom, {self.bottom:g} m.")

    @property
    def heights(self) -> Polygon:
        """Heights (n,) of the top at the corners, metres."""
        a, b, c = self.top
        return np.asarray(a + self.outline @ (b, c))

    def section(self, height: float) -> Polygon | None:
        """Return the outline (m, 2) of the cross-section of the block at a height in metres, None if there is none.

        Source: clipping to the half plane in which the top is at least this high, Sutherland & Hodgman 1974.
        """
        above = self.heights - height
        if height < self.bottom or not (above > 0.0).any():
            return None
        corners: list[Polygon] = []
        for k in range(len(above)):
            here, there = above[k - 1], above[k]
            if (here >= 0.0) != (there >= 0.0):
                share = here / (here - there)
                corners.append(self.outline[k - 1] + share * (self.outline[k] - self.outline[k - 1]))
            if there >= 0.0:
                corners.append(self.outline[k])
        return np.array(corners) if len(corners) >= 3 else None


def slab(outline: Polygon, bottom: float, top: float) -> Block:
    """Return a block with a level top."""
    return Block(outline, bottom, (top, 0.0, 0.0))


def ramp(x0: float, y0: float, x1: float, y1: float, top: float) -> Block:
    """Return a ramp over a rectangle, rising from 0 at x = ``x0`` to ``top`` at ``x1``, in either direction."""
    rise = top / (x1 - x0)
    return Block(rect(min(x0, x1), y0, max(x0, x1), y1), 0.0, (-rise * x0, rise, 0.0))


def stairs(x0: float, y0: float, x1: float, y1: float, top: float, steps: int) -> list[Block]:
    """Return steps over a rectangle, rising from x = ``x0`` to ``top`` at ``x1``, in either direction."""
    depth = (x1 - x0) / steps
    return [
        slab(rect(*sorted_x(x0 + k * depth, x1, y0, y1)), k * top / steps, (k + 1) * top / steps) for k in range(steps)
    ]


def sorted_x(a: float, b: float, y0: float, y1: float) -> tuple[float, float, float, float]:
    """Return the corners x0, y0, x1, y1 of a rectangle between x = ``a`` and ``b``, in either order."""
    return min(a, b), y0, max(a, b), y1


def table_top(x: float, y: float, width: float, depth: float, yaw: float, top: float, thickness: float = 0.04) -> Block:
    """Return a table top centred on (x, y), with its upper side at ``top`` metres."""
    return slab(box(x, y, width, depth, yaw), top - thickness, top)


def lintels(
    a: Point, b: Point, thickness: float, doors: Sequence[tuple[float, float]], low: float = 2.0, high: float = 2.2
) -> list[Block]:
    """Return the pieces of a wall above its doors; arguments as in :func:`mapper.simulation.shapes.wall`, plus
    heights.
    """
    (ax, ay), (bx, by) = a, b
    length, yaw = float(np.hypot(bx - ax, by - ay)), float(np.arctan2(by - ay, bx - ax))
    along = np.array([(bx - ax) / length, (by - ay) / length])
    blocks = []
    for start, stop in doors:
        x, y = np.array(a) + 0.5 * (start + stop) * along
        blocks.append(slab(box(float(x), float(y), stop - start, thickness, yaw), low, high))
    return blocks
