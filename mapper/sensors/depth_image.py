"""A depth image with its camera and where that was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.sensors.camera import Intrinsics


@dataclass(frozen=True, slots=True, eq=False)
class DepthImage:
    """Depths (height, width) float32, metres along the optical axis, 0 for no depth, of ``camera``.

    ``pose`` (4, 4) is ``T_map_camera`` of the camera's optical frame: x to the right, y down, z ahead (REP 103).
    """

    depth: NDArray[np.float32]
    camera: Intrinsics
    pose: NDArray[np.float64]
