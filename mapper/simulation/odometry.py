"""Wheel odometry with drift along a true path."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.array_types import Float64Array
from mapper.core.se2 import between_one, compose, inverse, wrap_angle
from mapper.simulation.robot import PoseTuple

Alphas = tuple[float, float, float, float]

ALPHAS: Alphas = (0.004, 0.002, 0.02, 0.001)  #: rad/rad, rad/m, m/m, m/rad: a good indoor robot on a smooth floor
TURN_BIAS = 0.002  #: rad/m: one wheel is slightly larger than the other
WORN_ALPHAS: Alphas = (0.02, 0.01, 0.04, 0.005)  #: the same for worn wheels on carpet
WORN_TURN_BIAS = 0.02  #: rad/m


def drifting_odometry(
    poses: ArrayLike, rng: np.random.Generator, alphas: Alphas = ALPHAS, turn_bias: float = TURN_BIAS
) -> Float64Array:
    """Return poses (n, 3) as reported by odometry along the true ``poses`` (n, 3); the first is exact.

    Each motion is a turn, a straight line and a turn, with Gaussian noise on each. Source: Probabilistic Robotics,
    table 5.6 (``sample_motion_model_odometry``), but with variances α² times the motion instead of α times its square,
    so that the drift of a path does not depend on its subdivision. ``turn_bias`` is added per metre.
    """
    true = np.asarray(poses, dtype=np.float64)
    if len(true) < 2:
        return true.copy()
    noise = rng.standard_normal((3, len(true) - 1))
    motions = compose(inverse(true[:-1]), true[1:])
    reported: list[PoseTuple] = [tuple(true[0].tolist())]
    for motion, drawn in zip(motions.tolist(), noise.T.tolist(), strict=True):
        reported.append(_moved(reported[-1], *_noisy(motion, drawn, alphas, turn_bias)))
    out = np.array(reported)
    out[:, 2] = wrap_angle(out[:, 2])
    return out


class Odometer:
    """Odometry of worn wheels: the motion model of :func:`drifting_odometry`, one motion at a time.

    ``pose`` is the estimate since :meth:`place`, T_map_base (x, y, yaw), m and rad.
    """

    def __init__(
        self,
        pose: PoseTuple,
        rng: np.random.Generator,
        alphas: Alphas = WORN_ALPHAS,
        turn_bias: float = WORN_TURN_BIAS,
    ) -> None:
        self._rng, self._alphas, self._turn_bias = rng, alphas, turn_bias
        self.place(pose)

    def place(self, pose: PoseTuple) -> None:
        """Set the estimate to the true ``pose``; drift starts again."""
        self.pose = self._true = pose

    def carry(self, pose: PoseTuple) -> None:
        """Carry the robot to the true ``pose``: the wheels do not turn, and the estimate is unchanged."""
        self._true = pose

    def move(self, pose: PoseTuple) -> PoseTuple:
        """Move to the true ``pose``; return the pose reported by the wheels."""
        noise = self._rng.standard_normal(3).tolist()
        motion = _noisy(between_one(self._true, pose), noise, self._alphas, self._turn_bias)
        x, y, yaw = _moved(self.pose, *motion)
        self._true = pose
        self.pose = (x, y, _wrapped(yaw))
        return self.pose


def _noisy(motion: PoseTuple, noise: Sequence[float], alphas: Alphas, turn_bias: float) -> tuple[float, float, float]:
    """Return a motion (x, y, yaw) as turn, signed length and turn, each with noise from ``noise`` (3,)."""
    x, y, yaw = motion
    length = math.hypot(x, y)
    turn_1 = math.atan2(y, x) if length > 1e-6 else 0.0
    backwards = abs(turn_1) > math.pi / 2  # driving backwards is not a half turn
    if backwards:
        turn_1 = _wrapped(turn_1 + math.pi)
    turn_2 = _wrapped(yaw - turn_1)
    a1, a2, a3, a4 = alphas
    deviation_1 = math.sqrt(a1**2 * abs(turn_1) + a2**2 * length)
    deviation_2 = math.sqrt(a1**2 * abs(turn_2) + a2**2 * length)
    deviation_length = math.sqrt(a3**2 * length + a4**2 * (abs(turn_1) + abs(turn_2)))
    return (
        turn_1 + deviation_1 * noise[0],
        (-length if backwards else length) + deviation_length * noise[1],
        turn_2 + deviation_2 * noise[2] + turn_bias * length,
    )


def _moved(pose: PoseTuple, turn_1: float, length: float, turn_2: float) -> PoseTuple:
    x, y, yaw = pose
    heading = yaw + turn_1
    return (x + length * math.cos(heading), y + length * math.sin(heading), heading + turn_2)


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
