"""Places of the camera from which one looks at a world or a map."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

from server.sessions.scene_controls import Bounds

CameraName = Literal["overview", "above", "south", "west", "north", "east"]
Vector = tuple[float, float, float]

#: Name → direction from the centre of the bounds to the camera, in sizes of the bounds. From straight above, the
#: camera is a little to the south, so that north is up.
CAMERAS: Mapping[CameraName, Vector] = MappingProxyType(
    {
        "overview": (0.0, -0.75, 0.95),
        "above": (0.0, -0.001, 1.35),
        "south": (0.0, -1.25, 0.35),
        "west": (-1.25, 0.0, 0.35),
        "north": (0.0, 1.25, 0.35),
        "east": (1.25, 0.0, 0.35),
    }
)


def camera_at(
    name: CameraName, bounds: Bounds, aspect: float, heights: tuple[float, float] | None = None
) -> tuple[Vector, Vector]:
    """Return where the camera ``name`` is and what it looks at, metres; in a narrow picture it is farther away.

    It looks at the floor, or at the middle of ``heights``.
    """
    x0, y0, x1, y1 = bounds
    x, y, size = (x0 + x1) / 2, (y0 + y1) / 2, max(x1 - x0, y1 - y0, 2.0)
    z = 0.0
    if heights is not None:
        z0, z1 = heights
        z, size = (z0 + z1) / 2, max(x1 - x0, y1 - y0, 1.3 * (z1 - z0), 0.1)
    far = size * farther(aspect)
    dx, dy, dz = CAMERAS[name]
    return (x + dx * far, y + dy * far, z + dz * far), (x, y, z)


ASPECT = 1.3  #: aspect ratio from which a camera has all of its bounds in view


def farther(aspect: float) -> float:
    """Return how many times farther away the camera is in a picture of this aspect ratio."""
    return min(max(ASPECT / aspect, 1.0), 4.0)
