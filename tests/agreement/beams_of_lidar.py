"""Beams of a simulated lidar: by the kernel, and each against every edge."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.simulation import WORLDS, World
from mapper.simulation.kernels.lidar import add_noise, cast_rays
from mapper.simulation.lidar import RANGE_MIN
from mapper.simulation.textbook import cast_beams, noisy

SIGMA = 0.3
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
    bearings = yaw + angle_min + angle_increment * np.arange(n_beams, dtype=np.float64)
    return (cast_beams(world.seen, x, y, bearings, range_max),)


def readings_by_kernel(case: Case) -> tuple[Any, ...]:
    ranges, range_max = beams_cast_by_textbook(case)[0], case[-1]
    out = np.empty(len(ranges), dtype=np.float32)
    add_noise(ranges, _noise(len(ranges)), SIGMA, RANGE_MIN, range_max, out)
    return (out,)


def readings_by_textbook(case: Case) -> tuple[Any, ...]:
    ranges, range_max = beams_cast_by_textbook(case)[0], case[-1]
    return (noisy(ranges, _noise(len(ranges)), SIGMA, range_max),)


def _noise(n: int) -> np.ndarray:
    return np.random.default_rng(n).standard_normal(n)
