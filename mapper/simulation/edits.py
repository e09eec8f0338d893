"""Edits of a world: added walls and boxes, erased solids. The world itself is not modified."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, cast, get_args

import numpy as np

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.simulation.shapes import Polygon, rect, wall
from mapper.simulation.worlds import World

WALL_THICKNESS = 0.12  #: metres
LEAST_SIDE = 0.05  #: metres: beams might miss anything thinner

Kind = Literal["wall", "box"]


@dataclass(frozen=True, slots=True)
class Drawn:
    """A wall from (x0, y0) to (x1, y1), or the axis-aligned box between these corners; whole centimetres, map frame.

    Raises :class:`ConfigError` for a shape that is too small or degenerate.
    """

    kind: Kind
    x0: int
    y0: int
    x1: int
    y1: int

    def __post_init__(self) -> None:
        if self.kind not in get_args(Kind):
            raise ConfigError("edit.kind", f"Only a wall or a box can be drawn, not {self.kind!r:.80}.")
        for value in (self.x0, self.y0, self.x1, self.y1):
            if type(value) is not int or abs(value) > 1_000_000:
                raise ConfigError("edit.place", f"Corners must be whole centimetres within 10 km, not {value!r:.80}.")
        dx, dy = abs(self.x1 - self.x0) / 100.0, abs(self.y1 - self.y0) / 100.0
        if (math.hypot(dx, dy) if self.kind == "wall" else min(dx, dy)) < LEAST_SIDE:
            raise ConfigError("edit.small", f"A {self.kind} needs sides of at least {100 * LEAST_SIDE:g} cm.")

    def polygon(self) -> Polygon:
        """Return the shape's outline (4, 2), metres."""
        x0, y0, x1, y1 = (v / 100.0 for v in (self.x0, self.y0, self.x1, self.y1))
        if self.kind == "wall":
            return wall((x0, y0), (x1, y1), WALL_THICKNESS)[0]
        return rect(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))


@dataclass(frozen=True, slots=True)
class Edits:
    """Solids ``added`` to a world, and indices into its ``solids`` of those ``erased``."""

    added: tuple[Drawn, ...] = ()
    erased: frozenset[int] = frozenset()

    @classmethod
    def of(cls, added: object, erased: object) -> Edits:
        """Return the edits described by plain lists: ``[kind, x0, y0, x1, y1]`` each, and indices.

        Raises :class:`ConfigError` for anything else.
        """
        if not isinstance(added, list) or not all(isinstance(row, list | tuple) and len(row) == 5 for row in added):
            raise ConfigError("edit.added", "The added solids must be a list of [kind, x0, y0, x1, y1].")
        if not isinstance(erased, list) or not all(isinstance(i, int) and not isinstance(i, bool) for i in erased):
            raise ConfigError("edit.erased", "The erased solids must be a list of whole numbers.")
        return cls(tuple(Drawn(cast("Kind", kind), *corners) for kind, *corners in added), frozenset(erased))

    def as_lists(self) -> tuple[list[list[str | int]], list[int]]:
        """Return the arguments of :meth:`of`."""
        return [[d.kind, d.x0, d.y0, d.x1, d.y1] for d in self.added], sorted(self.erased)


def edited(world: World, edits: Edits, limits: Limits = DEFAULT_LIMITS) -> World:
    """Return ``world`` with the erased solids removed and then the added ones appended.

    Raises :class:`LimitError` for too many edits and :class:`ConfigError` for a shape that exceeds the world's bounds,
    an unknown solid, and a piece of the outer wall, which keeps the robot inside the world.
    """
    if len(edits.added) > limits.max_added_solids:
        raise LimitError("edit.many", f"At most {limits.max_added_solids} walls and boxes can be drawn into a world.")
    outer = _outer_solids(world)
    for index in sorted(edits.erased):
        if not 0 <= index < len(world.solids):
            raise ConfigError("edit.unknown", f"The world has no solid {index} to erase.")
        if index in outer:
            raise ConfigError("edit.outer", "The outer wall cannot be erased: it bounds the world.")
    added = [drawn.polygon() for drawn in edits.added]
    x0, y0, x1, y1 = world.bounds
    for polygon in added:
        if np.any(polygon < (x0, y0)) or np.any(polygon > (x1, y1)):
            raise ConfigError("edit.outside", "Walls and boxes must lie within the world.")
    if not added and not edits.erased:
        return world
    solids = [solid for i, solid in enumerate(world.solids) if i not in edits.erased]
    return replace(world, solids=tuple(solids + added))


def solid_ids(world: World, edits: Edits) -> list[int]:
    """Return an id for each solid of ``edited(world, edits)``: its index in ``world``, or −1 − its index in
    ``added``.
    """
    ids = [i for i in range(len(world.solids)) if i not in edits.erased]
    return ids + [-1 - i for i in range(len(edits.added))]


def is_outer(world: World, solid: Polygon) -> bool:
    """Return whether a solid is a piece of the outer wall: it touches the world's bounds."""
    low, high = np.array(world.bounds[:2]), np.array(world.bounds[2:])
    return bool(np.any(np.isclose(solid, low, atol=1e-9) | np.isclose(solid, high, atol=1e-9)))


@lru_cache(maxsize=16)
def _outer_solids(world: World) -> frozenset[int]:
    """Return the indices of the solids of the outer wall, computed once per world."""
    return frozenset(i for i, solid in enumerate(world.solids) if is_outer(world, solid))


def gone(before: World, after: World) -> Sequence[Polygon]:
    """Return the solids of ``before`` that ``after`` lacks."""
    stay = {solid.tobytes() for solid in after.solids}
    return [solid for solid in before.solids if solid.tobytes() not in stay]
