"""Pinhole model of a rectified camera, and lens model of an unrectified one.

The pixel (u, v) with the depth z is the point ((u − cx) z / fx, (v − cy) z / fy, z) in the camera's optical frame: x
right, y down, z forward (REP 103). Source: sensor_msgs/CameraInfo; Hartley & Zisserman, Multiple View Geometry, 6.1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from mapper.core.errors import ConfigError

STEPS = 257  #: points between the axis and a position at which the validity of a distortion model is checked


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Intrinsics of a rectified image of ``width`` × ``height`` pixels: focal lengths and optical centre, pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        finite = math.isfinite(self.fx + self.fy + self.cx + self.cy)
        if not (finite and self.fx > 0.0 and self.fy > 0.0):
            raise ConfigError(
                "camera.intrinsics",
                "A camera’s focal lengths must be positive and its centre finite, not "
                f"{self.fx}, {self.fy}, {self.cx}, {self.cy}.",
            )

    def beams(self) -> tuple[float, float]:
        """Return angle_min and angle_increment, radians, of a scan with one beam per image column."""
        last = math.atan2(self.cx, self.fx)
        first = -math.atan2(self.width - 1 - self.cx, self.fx)
        return first, (last - first) / max(1, self.width - 1)

    def shares(self, x: float, y: float) -> tuple[float, float]:
        """Return the image position of (x, y, 1) in the optical frame, as fractions of width and height from the upper
        left.

        The centre of the first pixel is (0, 0) in pixels, half a pixel from the corner.
        """
        return (self.fx * x + self.cx + 0.5) / self.width, (self.fy * y + self.cy + 0.5) / self.height

    def check_size(self, depth: NDArray[Any], what: str) -> None:
        """Raise :class:`ConfigError` for an image (height, width) of another size; ``what`` names the image."""
        if depth.shape != (self.height, self.width):
            raise ConfigError(
                "camera.size",
                f"an image of {depth.shape[1]} × {depth.shape[0]} pixels has {what} for {self.width} × {self.height}",
            )

    def points(self, depth: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the points (height × width, 3) of a depth image (height, width), metres, in the optical frame.

        Row-major order; NaN where the depth is NaN. Raises the errors of :meth:`check_size`.
        """
        self.check_size(depth, "intrinsics")
        z = depth.astype(np.float64)
        points = np.empty((*depth.shape, 3))
        points[..., 0] = (np.arange(self.width) - self.cx) / self.fx * z
        points[..., 1] = ((np.arange(self.height) - self.cy) / self.fy)[:, np.newaxis] * z
        points[..., 2] = z
        return points.reshape(-1, 3)


@dataclass(frozen=True, slots=True)
class Lens:
    """Lens model of an unrectified image: K, R, and D with its distortion model, as in CameraInfo.

    ``rectification`` (9,) is R, row by row, which rotates the camera's optical frame to the rectified one.
    """

    intrinsics: Intrinsics
    rectification: tuple[float, ...]
    model: str
    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        if not np.isfinite((*self.rectification, *self.coefficients)).all():
            raise ConfigError("camera.lens", "The numbers of a camera's lens must be finite.")

    def shares(self, place: NDArray[np.float64]) -> tuple[float, float] | None:
        """Return the image position of a point (3,) in the rectified optical frame, like :meth:`Intrinsics.shares`.

        None if the lens does not see the point: behind the camera, or so far from its axis that the model is not valid.
        Raises :class:`ConfigError` for a model not in :data:`DISTORTIONS`. Source: ``unrectifyPoint`` of ROS's
        image_geometry.
        """
        x, y, z = (np.reshape(self.rectification, (3, 3)).T @ place).tolist()
        if z <= 0.0:
            return None
        imaged = self._distorted(x / z, y / z)
        return None if imaged is None else self.intrinsics.shares(*imaged)

    def _distorted(self, x: float, y: float) -> tuple[float, float] | None:
        if not any(self.coefficients):
            return x, y
        known = DISTORTIONS.get(self.model)
        if known is None or any(self.coefficients[known.coefficients :]):
            raise ConfigError(
                "camera.lens",
                f"the lens has the distortion model {self.model!r:.80} of {len(self.coefficients)} coefficients, which "
                "is not read",
            )
        return known.distort(self.coefficients, x, y)


def _with_radius(coefficients: Sequence[float], x: float, y: float) -> tuple[float, float] | None:
    """Apply radial distortion in powers of the distance from the axis, and tangential distortion.

    k1, k2, p1, p2, k3 for "plumb_bob", and k4, k5, k6 of the denominator for "rational_polynomial". Source: OpenCV,
    Camera Calibration and 3D Reconstruction; Brown, Decentering distortion of lenses, 1966.
    """
    k1, k2, p1, p2, k3, k4, k5, k6 = (*coefficients, *(0.0,) * 8)[:8]
    numerator, denominator = Polynomial([1.0, k1, k2, k3]), Polynomial([1.0, k4, k5, k6])
    if not _ascends(lambda r: r * numerator(r * r) / denominator(r * r), math.hypot(x, y)):
        return None
    r2 = x * x + y * y
    radial = float(numerator(r2) / denominator(r2))
    return (
        radial * x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        radial * y + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    )


def _with_angle(coefficients: Sequence[float], x: float, y: float) -> tuple[float, float] | None:
    """Apply distortion in powers of the angle to the axis, k1 … k4: "equidistant". Source: OpenCV, Fisheye camera
    model.

    Kannala & Brandt, A generic camera model and calibration method, PAMI 28(8), 2006.
    """
    polynomial = Polynomial([1.0, *coefficients[:4]])
    r = math.hypot(x, y)
    angle = math.atan(r)
    if not _ascends(lambda at: at * polynomial(at * at), angle):
        return None
    scale = angle * float(polynomial(angle * angle)) / r if r > 0.0 else 1.0
    return scale * x, scale * y


def _ascends(distance: Callable[[NDArray[np.float64]], NDArray[np.float64]], end: float) -> bool:
    """Return whether the distance in the image increases with the distance from the axis, from 0 to ``end``.

    Beyond a maximum, the model maps points to image positions nearer to the axis again, because it was not fitted
    there.
    """
    if end == 0.0:
        return True
    with np.errstate(all="ignore"):
        return bool((np.diff(distance(np.linspace(0.0, end, STEPS))) > 0.0).all())


@dataclass(frozen=True, slots=True)
class Distortion:
    """A distortion model: its maximum number of coefficients, and the image position of (x, y, 1) at depth 1, or
    None.
    """

    coefficients: int
    distort: Callable[[Sequence[float], float, float], tuple[float, float] | None]


#: Keyed by the names of sensor_msgs/CameraInfo.
DISTORTIONS: Mapping[str, Distortion] = {
    "plumb_bob": Distortion(5, _with_radius),
    "rational_polynomial": Distortion(8, _with_radius),
    "equidistant": Distortion(4, _with_angle),
}
