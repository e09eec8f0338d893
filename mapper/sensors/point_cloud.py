"""A point cloud as a sensor reported it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError


@dataclass(frozen=True, slots=True)
class PointCloud:
    """Points (n, 3) float32 or float64, metres in the frame ``frame_id``, at ``stamp_ns``.

    ``shape`` (height, width) is that of an organised cloud, whose points are those of an image row after row, and
    (1, n) of any other. Points of it without a reading are NaN. ``fields`` has all else that was stated of the points,
    by name: (n,), or (n, k) where a point has k numbers. ``times`` (n,) float64 is when each point was measured,
    seconds after the stamp; None where that is not stated. Raises :class:`ConfigError` for arrays of other lengths.
    """

    points: NDArray[np.floating[Any]]
    stamp_ns: int = 0
    frame_id: str = ""
    shape: tuple[int, int] | None = None
    fields: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    times: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        n = len(self.points)
        if self.points.shape != (n, 3):
            raise ConfigError("cloud.shape", f"Points must have shape (n, 3), not {self.points.shape}.")
        if self.shape is None:
            object.__setattr__(self, "shape", (1, n))
        elif self.shape[0] * self.shape[1] != n:
            raise ConfigError("cloud.shape", f"A cloud of {self.shape[0]} × {self.shape[1]} points cannot have {n}.")
        others = [*self.fields.values(), *(() if self.times is None else (self.times,))]
        if any(len(one) != n for one in others):
            raise ConfigError("cloud.fields", f"Each field of a cloud of {n} points must have {n} rows.")

    def __len__(self) -> int:
        return len(self.points)

    @property
    def is_organised(self) -> bool:
        """Whether the points are those of an image, with neighbours above and below."""
        return self.shape is not None and self.shape[0] > 1
