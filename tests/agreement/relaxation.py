"""Relaxed paths of the explorer: by the kernel, and in plain NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.simulation import WORLDS, World
from mapper.simulation.kernels.shortest_paths import relax
from mapper.simulation.textbook import relaxed

ROUNDS = 40
Case = tuple[World, np.ndarray, float]


@st.composite
def rough_paths(draw: st.DrawFn) -> Case:
    """Draw paths with corners in the open, along walls, through walls and out of the world."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    world = WORLDS[draw(st.sampled_from(["office", "maze", "loop"]))]
    x, y = rng.uniform(world.bounds[:2], world.bounds[2:])
    if draw(st.booleans()):
        x, y = world.nearest_free((x, y), 0.25)
    heading = np.cumsum(rng.choice([0.0, 0.0, 0.0, np.pi / 4, -np.pi / 4, 1.5], draw(st.integers(1, 90))))
    steps = draw(st.sampled_from([0.1, 0.1, 0.5])) * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    return world, np.array([x, y]) + np.cumsum(steps, axis=0), draw(st.sampled_from([0.35, 1.0]))


def relaxed_by_kernel(case: Case) -> tuple[Any, ...]:
    world, path, least = case
    path = path.copy()
    relax(world.segments, world.bounds, path, least, ROUNDS)
    return (path,)


def relaxed_by_textbook(case: Case) -> tuple[Any, ...]:
    world, path, least = case
    return (relaxed(world, path, least, ROUNDS),)
