"""Wheel odometry of a true path, with drift."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mapper.core.se2 import compose, inverse, wrap_angle
from mapper.simulation.robot import PoseTuple
from mapper.simulation.worlds import Float64Array

Alphas = tuple[float, float, float, float]

ALPHAS: Alphas = (0.004, 0.002, 0.02, 0.001)  #: rad/rad, rad/m, m/m, m/rad: a good indoor robot on smooth floor
TURN_BIAS = 0.002  #: rad/m: one wheel a little larger than the other
WORN_ALPHAS: Alphas = (0.02, 0.01, 0.04, 0.005)  #: the same of worn wheels on carpet
WORN_TURN_BIAS = 0.02  #: rad/m


def drifting_odometry(
    poses: ArrayLike, rng: np.random.Generator, alphas: Alphas = ALPHAS, turn_bias: float = TURN_BIAS
) -> Float64Array:
    """Return poses (n, 3) as odometry would report them along the true ``poses`` (n, 3): the first is right.

    Each motion is a turn, a straight line and a turn, with Gaussian noise on each. Source: Probabilistic Robotics,
    table 5.6 (``sample_motion_model_odometry``), but with variances α² times the motion instead of α times its square:
    then the drift of a path does not depend on how finely it is cut.
    ``turn_bias`` is added to every metre.
    """
    true = np.asarray(poses, dtype=np.float64)
    if len(true) < 2:
        return true.copy()
    noise = rng.standard_normal((3, len(true) - 1))
    turn_1, length, turn_2 = _noisy(compose(inverse(true[:-1]), true[1:]), noise, alphas, turn_bias)
    out = np.empty_like(true)
    out[0] = true[0]
    for i in range(len(true) - 1):
        out[i + 1] = _moved(out[i], turn_1[i], length[i], turn_2[i])
    out[:, 2] = wrap_angle(out[:, 2])
    return out


class Odometer:
    """Odometry of worn wheels: the same motion model as :func:`drifting_odometry`, one motion at a time.

    ``pose`` is their estimate since :meth:`place`, T_map_base (x, y, yaw), m and rad.
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
        """Set the estimate to the true ``pose``: drift begins anew."""
        self.pose = self._true = pose

    def carry(self, pose: PoseTuple) -> None:
        """Carry the robot to the true ``pose``: the wheels do not turn, and the estimate stays."""
        self._true = pose

    def move(self, pose: PoseTuple) -> PoseTuple:
        """Move to the true ``pose``; return the pose that the wheels report."""
        motion = np.asarray(compose(inverse(np.array(self._true)), np.array(pose)))
        noise = self._rng.standard_normal((3, 1))
        turn_1, length, turn_2 = _noisy(motion[np.newaxis], noise, self._alphas, self._turn_bias)
        x, y, yaw = _moved(np.array(self.pose), turn_1[0], length[0], turn_2[0])
        self._true = pose
        self.pose = (float(x), float(y), float(wrap_angle(yaw)))
        return self.pose


def _noisy(
    motion: Float64Array, noise: Float64Array, alphas: Alphas, turn_bias: float
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Return motions (n, 3) as turn, signed length and turn (n,) each, with noise made of ``noise`` (3, n) on each."""
    length = np.hypot(motion[:, 0], motion[:, 1])
    turn_1 = np.where(length > 1e-6, np.arctan2(motion[:, 1], motion[:, 0]), 0.0)
    # Driving backwards is no half turn.
    backwards = np.abs(turn_1) > np.pi / 2
    turn_1 = np.where(backwards, wrap_angle(turn_1 + np.pi), turn_1)
    signed = np.where(backwards, -length, length)
    turn_2 = wrap_angle(motion[:, 2] - turn_1)
    a1, a2, a3, a4 = alphas
    variance_1 = a1**2 * np.abs(turn_1) + a2**2 * length
    variance_2 = a1**2 * np.abs(turn_2) + a2**2 * length
    variance_length = a3**2 * length + a4**2 * (np.abs(turn_1) + np.abs(turn_2))
    return (
        turn_1 + np.sqrt(variance_1) * noise[0],
        signed + np.sqrt(variance_length) * noise[1],
        turn_2 + np.sqrt(variance_2) * noise[2] + turn_bias * length,
    )


def _moved(pose: Float64Array, turn_1: float, length: float, turn_2: float) -> tuple[float, float, float]:
    x, y, yaw = pose
    heading = yaw + turn_1
    return (x + length * np.cos(heading), y + length * np.sin(heading), heading + turn_2)
