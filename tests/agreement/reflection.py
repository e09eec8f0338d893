"""Beams that polished walls reflect away: the kernel, and the same in NumPy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.simulation.faults import ON_WALL, SPECULAR_ANGLE
from mapper.simulation.kernels.lidar import cast_rays
from mapper.simulation.kernels.reflection import reflect


@st.composite
def reflection_cases(draw: st.DrawFn) -> tuple[Any, ...]:
    """Draw faces (m, 4), ranges (n,) and bearings (n,) of beams from (0, 0) that end on them or not."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    faces = random.uniform(-5.0, 5.0, (draw(st.integers(0, 6)), 4))
    n = draw(st.integers(1, 40))
    ranges = np.empty(n)
    cast_rays(faces, 0.0, 0.0, 0.0, -math.pi, 2.0 * math.pi / n, draw(st.sampled_from([2.0, 10.0])), ranges)
    off = random.random(n) < 0.2
    ranges[off] += random.uniform(-1.0, 1.0, int(off.sum()))
    return faces, ranges, -math.pi + 2.0 * math.pi / n * np.arange(n)


def reflected_by_kernel(case: Any) -> tuple[Any, ...]:
    faces, ranges, bearings = case
    out = np.empty(len(ranges), dtype=np.bool_)
    turned = 0.3  # the sensor's heading
    beams = np.stack([np.cos(bearings - turned), np.sin(bearings - turned)], axis=-1)
    sensor = (0.0, 0.0, math.cos(turned), math.sin(turned))
    reflect(faces, ranges, beams, sensor, math.sin(SPECULAR_ANGLE), ON_WALL, out)
    return (out,)


def reflected_by_textbook(case: Any) -> tuple[Any, ...]:
    faces, ranges, bearings = case
    out = np.zeros(len(ranges), dtype=np.bool_)
    returned = np.flatnonzero(np.isfinite(ranges))
    direction = np.stack([np.cos(bearings[returned]), np.sin(bearings[returned])], axis=-1)
    ends = ranges[returned, np.newaxis] * direction
    edge = faces[:, 2:] - faces[:, :2]
    length = np.hypot(*edge.T)
    along = edge / length[:, np.newaxis]
    offset = ends[:, np.newaxis] - faces[np.newaxis, :, :2]  # (beams, faces, 2)
    off_face = np.abs(offset[..., 0] * along[:, 1] - offset[..., 1] * along[:, 0])
    where = offset[..., 0] * along[:, 0] + offset[..., 1] * along[:, 1]
    on_face = (off_face <= ON_WALL) & (where >= -ON_WALL) & (where <= length + ON_WALL)
    slant = np.abs(direction @ along.T) > math.sin(SPECULAR_ANGLE)
    out[returned] = np.any(on_face & slant, axis=1)
    return (out,)
