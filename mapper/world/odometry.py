"""What wheel odometry makes of a true path: drift."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mapper.geometry import compose, inverse, wrap_angle
from mapper.world.worlds import Float64Array

ALPHAS = (0.004, 0.002, 0.02, 0.001)  #: rad/rad, rad/m, m/m, m/rad: a good indoor robot on smooth floor
TURN_BIAS = 0.002  #: rad/m: one wheel a little larger than the other


def drifting_odometry(
    poses: ArrayLike,
    rng: np.random.Generator,
    alphas: tuple[float, float, float, float] = ALPHAS,
    turn_bias: float = TURN_BIAS,
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
    motion = compose(inverse(true[:-1]), true[1:])
    length = np.hypot(motion[:, 0], motion[:, 1])
    turn_1 = np.where(length > 1e-6, np.arctan2(motion[:, 1], motion[:, 0]), 0.0)
    # Driving backwards is no half turn.
    backwards = np.abs(turn_1) > np.pi / 2
    turn_1 = np.where(backwards, wrap_angle(turn_1 + np.pi), turn_1)
    signed = np.where(backwards, -length, length)
    turn_2 = wrap_angle(motion[:, 2] - turn_1)
    a1, a2, a3, a4 = alphas
    noise = rng.standard_normal((3, len(motion)))
    variance_1 = a1**2 * np.abs(turn_1) + a2**2 * length
    variance_2 = a1**2 * np.abs(turn_2) + a2**2 * length
    variance_length = a3**2 * length + a4**2 * (np.abs(turn_1) + np.abs(turn_2))
    turn_1 = turn_1 + np.sqrt(variance_1) * noise[0]
    signed = signed + np.sqrt(variance_length) * noise[1]
    turn_2 = turn_2 + np.sqrt(variance_2) * noise[2] + turn_bias * length
    out = np.empty_like(true)
    out[0] = true[0]
    for i in range(len(motion)):
        x, y, yaw = out[i]
        heading = yaw + turn_1[i]
        out[i + 1] = (
            x + signed[i] * np.cos(heading),
            y + signed[i] * np.sin(heading),
            heading + turn_2[i],
        )
    out[:, 2] = wrap_angle(out[:, 2])
    return out
