"""Point clouds as stated by a sensor or a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError

ROTATION_TOLERANCE = 1e-3  #: tolerance of R Rᵀ against the identity: files have as few as four digits


@dataclass(frozen=True, slots=True)
class PointCloud:
    """Points (n, 3) float32 or float64, metres in the frame ``frame_id``, at ``stamp_ns``.

    ``shape`` (height, width) is that of an organised cloud, whose points are in the row-major order of an image, or (1,
    n). Points without a reading are NaN. ``fields`` has the other fields of the points by name: (n,), or (n, k) for k
    numbers per point. File readers use these names for all formats: ``intensity`` (n,), ``normals`` (n, 3), ``rgb`` (n,
    3) uint8, ``class`` (n,) and ``ring`` (n,) integers. ``times`` (n,) float64 is the time of each point, in seconds
    after the stamp, or None. ``sensor_pose`` (4, 4) is ``T_frame_sensor``, or None if not stated. ``notes`` are the
    reader's remarks, one sentence each. Raises :class:`ConfigError` for arrays of different lengths and for an invalid
    pose.
    """

    points: NDArray[np.floating[Any]]
    stamp_ns: int = 0
    frame_id: str = ""
    shape: tuple[int, int] | None = None
    fields: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    times: NDArray[np.float64] | None = None
    sensor_pose: NDArray[np.float64] | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.points)
        if self.points.shape != (n, 3):
            raise ConfigError("cloud.shape", f"Points must have shape (n, 3), not {self.points.shape}.")
        if self.shape is None:
            object.__setattr__(self, "shape", (1, n))
        elif self.shape[0] * self.shape[1] != n:
            raise ConfigError("cloud.shape", f"A cloud of {self.shape[0]} × {self.shape[1]} points cannot have {n}.")
        others = [*self.fields.values(), *(() if self.times is None else (self.times,))]
        if any(len(other) != n for other in others):
            raise ConfigError("cloud.fields", f"Each field of a cloud of {n} points must have {n} rows.")
        if self.sensor_pose is not None:
            check_pose(self.sensor_pose, "The sensor’s pose")

    def __len__(self) -> int:
        return len(self.points)

    @property
    def is_organised(self) -> bool:
        """Whether the points have the row and column structure of an image."""
        return self.shape is not None and self.shape[0] > 1

    @property
    def finite(self) -> NDArray[np.bool_]:
        """Mask (n,) of the points with finite coordinates; NaN is a point without a reading."""
        return np.asarray(np.isfinite(self.points).all(axis=1))


@dataclass(frozen=True, slots=True)
class PosedCloud:
    """A cloud in its sensor's frame, and ``pose`` (4, 4), ``T_map_sensor`` at the time of measurement."""

    cloud: PointCloud
    pose: NDArray[np.float64]

    def __post_init__(self) -> None:
        check_pose(self.pose, "The cloud’s pose")

    @property
    def origin(self) -> NDArray[np.float64]:
        """Origin of the rays (3,), metres in the map's frame."""
        return self.pose[:3, 3]

    def points_in_map(self) -> NDArray[np.float64]:
        """Return the points (n, 3) float64, metres in the map frame."""
        return np.asarray(self.cloud.points.astype(np.float64) @ self.pose[:3, :3].T + self.pose[:3, 3])


def check_pose(pose: NDArray[np.float64], whose: str) -> None:
    """Raise :class:`ConfigError` unless ``pose`` (4, 4) is a rigid motion: a rotation and a finite translation.

    ``whose`` is the beginning of the error message.
    """
    if pose.shape != (4, 4):
        raise ConfigError("cloud.pose", f"{whose} must have shape (4, 4), not {pose.shape}.")
    if not np.isfinite(pose).all():
        raise ConfigError("cloud.pose", f"{whose} is not finite.")
    if np.abs(pose[3] - (0.0, 0.0, 0.0, 1.0)).max() > ROTATION_TOLERANCE:
        raise ConfigError("cloud.pose", f"{whose} is not a rigid motion: its last row must be 0 0 0 1.")
    rotation = pose[:3, :3]
    off = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if off > ROTATION_TOLERANCE:
        raise ConfigError("cloud.pose", f"{whose} is not a rotation: R Rᵀ is off the identity by {off:.2g}.")
    if np.linalg.det(rotation) < 0.0:
        raise ConfigError("cloud.pose", f"{whose} is a reflection, not a rotation: its determinant is −1.")
