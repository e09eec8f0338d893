"""Odometry motions in the form that the compiled functions use."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.parallel import in_parallel
from mapper.core.se2 import between_one, wrap_angle
from mapper.localization.kernels.motion import draw_normal, draw_uniform, move_particles
from mapper.localization.kernels.types import Motion
from mapper.localization.map_model import MapModel
from mapper.localization.parameters import LocalizationConfig
from mapper.localization.weighing import parts

LEAST_DISTANCE = 0.01  #: metres: the direction of a shorter motion is noise, and the first turn is 0, as in AMCL
_MASK = (1 << 64) - 1


def key_of(seed: int, step: int, purpose: int) -> int:
    """Return the random number key of one purpose in one step, 62 bits (SplitMix64; Steele et al. 2014)."""
    word = (seed * 0x9E3779B97F4A7C15 + step * 0xD1B54A32D192ED03 + purpose * 0x8CB92BA72F3D8DD7) & _MASK
    word = ((word ^ (word >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    word = ((word ^ (word >> 27)) * 0x94D049BB133111EB) & _MASK
    return (word ^ (word >> 31)) & ((1 << 62) - 1)


def motion_between(before: Float64Array, after: Float64Array, config: LocalizationConfig) -> Motion:
    """Return the motion between two poses (3,) of the odometry, with the errors of ``alpha1`` … ``alpha5``."""
    alphas = config.alpha1, config.alpha2, config.alpha3, config.alpha4
    if config.robot_model_type == "omni":
        x, y, turn = between_one(tuple(before.tolist()), tuple(after.tolist()))
        distance = math.hypot(x, y)
        a1, a2, a3, a4 = alphas
        return Motion(
            math.atan2(y, x), distance, turn,
            math.sqrt(a4 * turn**2 + config.alpha5 * distance**2),
            math.sqrt(a3 * distance**2 + a4 * turn**2),
            math.sqrt(a1 * turn**2 + a2 * distance**2),
            1,
        )  # fmt: skip
    control = turn_drive_turn(before, after)
    return Motion(*control, *_deviations(control, alphas), 0)


def turn_drive_turn(before: Float64Array, after: Float64Array) -> tuple[float, float, float]:
    """Return turn, distance and turn (rad, m, rad) between two poses (3,). Probabilistic Robotics, table 5.6."""
    dx, dy = after[0] - before[0], after[1] - before[1]
    distance = math.hypot(dx, dy)
    turn_1 = 0.0 if distance < LEAST_DISTANCE else float(wrap_angle(math.atan2(dy, dx) - before[2]))
    return turn_1, distance, float(wrap_angle(after[2] - before[2] - turn_1))


def _deviations(
    control: tuple[float, float, float], alphas: tuple[float, float, float, float]
) -> tuple[float, float, float]:
    """Return the standard deviations of turn, distance and turn. Table 5.6, lines 5 to 7.

    A turn counts from straight forward or straight back, whichever is nearer, as in AMCL, so that driving backwards is
    not a half turn.
    """
    a1, a2, a3, a4 = alphas
    turn_1, distance, turn_2 = control
    r1, r2 = (min(abs(r), math.pi - abs(r)) for r in (turn_1, turn_2))
    return (
        math.sqrt(a1 * r1**2 + a2 * distance**2),
        math.sqrt(a3 * distance**2 + a4 * (r1**2 + r2**2)),
        math.sqrt(a1 * r2**2 + a2 * distance**2),
    )


def move(particles: Float64Array, motion: Motion, key: int) -> None:
    """Move ``particles`` (n, 3) in place."""
    in_parallel([partial(move_particles, particles, motion, key, a, b) for a, b in parts(len(particles))])


def anywhere(model: MapModel, count: int, key: int) -> Float64Array:
    """Return ``count`` poses (n, 3), uniform over the free cells of the map and all headings."""
    out = np.empty((count, 3))
    geometry = model.geometry
    in_parallel(
        [
            partial(draw_uniform, model.free_cells, geometry.cols, geometry.frame, key, out, a, b)
            for a, b in parts(count)
        ]
    )
    return out


def around(pose: Float64Array, covariance: Float64Array, count: int, key: int) -> Float64Array:
    """Return ``count`` poses (n, 3), normally distributed around ``pose`` (3,) with ``covariance`` (3, 3)."""
    values, vectors = np.linalg.eigh(covariance)
    root = np.ascontiguousarray(vectors * np.sqrt(np.maximum(values, 0.0)))
    out = np.empty((count, 3))
    draw_normal(pose, root, key, out, 0, count)
    return out
