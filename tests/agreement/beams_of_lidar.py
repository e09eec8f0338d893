"""Beams of a simulated lidar: by the kernel, and each against every edge."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.simulation import WORLDS, World
from mapper.simulation.kernels.lidar import cast_rays
from mapper.simulation.textbook_lidar import cast_beams

Case = tuple[World, tuple[float, float, float], float, float, int, float]


@st.composite
def lidars(draw: st.DrawFn) -> Case:
    """Draw poses in the open and in solids, and fans from a few degrees to a whole turn."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    world = WORLDS[draw(st.sampled_from(sorted(WORLDS)))]
    x, y = rng.uniform(world.bounds[:2], world.bounds[2:]).tolist()
    n_beams = draw(st.sampled_from([1, 2, 30, 360, 1080]))
    width = draw(st.sampled_from([0.1, 1.0, np.pi, 2.0 * np.pi]))
    pose = (x, y, float(rng.uniform(-4.0, 4.0)))
    return world, pose, float(rng.uniform(-4.0, 0.0)), width / n_beams, n_beams, draw(st.sampled_from([3.0, 30.0]))


def beams_cast_by_kernel(case: Case) -> tuple[Any, ...]:
    world, pose, angle_min, angle_increment, n_beams, range_max = case
    out = np.empty(n_beams)
    cast_rays(world.seen, *pose, angle_min, angle_increment, range_max, out)
    return (out,)


def beams_cast_by_textbook(case: Case) -> tuple[Any, ...]:
    world, (x, y, yaw), angle_min, angle_increment, n_beams, range_max = case
    bearings = yaw + angle_min + angle_increment * np.arange(n_beams)
    return (cast_beams(world.seen, x, y, bearings, range_max),)
