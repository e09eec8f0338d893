"""The world in three dimensions: what rays meet, and how high things are."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.errors import ConfigError
from mapper.simulation.kernels.space import Space, cast_in_space
from mapper.simulation.plan_map import is_furniture
from mapper.simulation.shapes import Polygon
from mapper.simulation.worlds import Float64Array, World

WALL_HEIGHT = 2.2  #: metres: of the walls of all worlds
FURNITURE_HEIGHT = 0.75  #: metres: of solids that are no walls


def prisms(world: World) -> Iterator[tuple[Polygon, float, tuple[float, float, float]]]:
    """Yield outline, bottom and top of everything solid: the solids from the ground up, then the blocks."""
    for solid in world.solids:
        yield solid, 0.0, (FURNITURE_HEIGHT if is_furniture(solid) else WALL_HEIGHT, 0.0, 0.0)
    for block in world.blocks:
        yield block.outline, block.bottom, block.top


@lru_cache(maxsize=16)
def space_of(world: World) -> Space:
    """Return the solids of a world as kernels take them; computed once for each world."""
    edges, boxes, tops, first = [], [], [], [0]
    for outline, bottom, (a, b, c) in prisms(world):
        edges.append(np.hstack([outline, np.roll(outline, -1, axis=0)]))
        first.append(first[-1] + len(outline))
        highest = float((a + outline @ (b, c)).max())
        boxes.append([*outline.min(axis=0), bottom, *outline.max(axis=0), highest])
        tops.append([a, b, c])
    return Space(
        np.ascontiguousarray(np.vstack([np.empty((0, 4)), *edges])),
        np.array(first, dtype=np.int64),
        np.array(boxes, dtype=np.float64).reshape(-1, 6),
        np.array(tops, dtype=np.float64).reshape(-1, 3),
    )


def cast(world: World, origin: ArrayLike, directions: ArrayLike, range_max: float) -> Float64Array:
    """Return the distance (n,), metres, from ``origin`` (3,) along ``directions`` (n, 3) of length 1 to a surface.

    Map frame; +inf where a ray meets nothing within ``range_max`` metres. Raises :class:`ConfigError` for other shapes
    and lengths.
    """
    start = np.ascontiguousarray(origin, dtype=np.float64)
    away = np.ascontiguousarray(directions, dtype=np.float64)
    if start.shape != (3,) or away.ndim != 2 or away.shape[1] != 3 or not np.isfinite(start).all():
        raise ConfigError("simulation.rays", f"Rays need an origin (3,) and directions (n, 3), not {away.shape}.")
    if not np.allclose(np.linalg.norm(away, axis=1), 1.0, atol=1e-6):
        raise ConfigError("simulation.rays", "The directions of rays must have the length 1.")
    out = np.empty(len(away))
    cast_in_space(space_of(world), start, away, range_max, out)
    return out
