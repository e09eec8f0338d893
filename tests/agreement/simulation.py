"""Rays in worlds of three dimensions, for the table: random prisms, by the kernel and face by face."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.simulation import World, textbook
from mapper.simulation.blocks import Block, ramp, slab
from mapper.simulation.sensors_3d import cast, prisms
from mapper.simulation.shapes import box, disc, star


@dataclass(frozen=True)
class SpaceCase:
    """A world, and rays from one place."""

    world: World
    origin: np.ndarray
    directions: np.ndarray
    range_max: float


@st.composite
def space_cases(draw: st.DrawFn) -> SpaceCase:
    """Slabs, ramps that rise both ways, and solids that are not convex, around a place that may be inside one."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    blocks: list[Block] = []
    for _ in range(draw(st.integers(0, 4))):
        x, y, bottom = rng.uniform((-3.0, -3.0, -0.2), (3.0, 3.0, 1.0))
        kind = draw(st.sampled_from(["slab", "ramp", "disc"]))
        if kind == "slab":
            width, depth = rng.uniform(0.1, 2.0, 2)
            blocks.append(slab(box(x, y, width, depth, rng.uniform(-3, 3)), bottom, bottom + 0.4))
        elif kind == "ramp":
            along = draw(st.sampled_from([-1.5, 1.5]))
            blocks.append(ramp(x, y, x + along, y + 1.0, rng.uniform(0.1, 1.5)))
        else:
            blocks.append(slab(disc(x, y, 0.4, 7), bottom, bottom + 0.3))
    solids = (star(2.5, -2.5, 1.0, 0.4, 5),) if draw(st.booleans()) else ()
    world = World("w", "W", (-9.0, -9.0, 9.0, 9.0), solids, (0.0, 0.0, 0.0), tuple(blocks))
    directions = rng.normal(size=(24, 3))
    directions[0] = (0.0, 0.0, -1.0)
    directions[1] = (1.0, 0.0, 0.0)
    return SpaceCase(
        world,
        rng.uniform((-1.0, -1.0, 0.1), (1.0, 1.0, 1.5)),
        directions / np.linalg.norm(directions, axis=1, keepdims=True),
        draw(st.sampled_from([1.0, 20.0])),
    )


def space_by_kernel(case: SpaceCase) -> tuple[Any, ...]:
    return (cast(case.world, case.origin, case.directions, case.range_max),)


def space_by_textbook(case: SpaceCase) -> tuple[Any, ...]:
    faces = [face for prism in prisms(case.world) for face in textbook.prism_faces(*prism)]
    return (np.array([textbook.cast_ray(faces, case.origin, away, case.range_max) for away in case.directions]),)
