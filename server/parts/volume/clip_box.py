"""The clip box of a map in 3D: its edges, and a handle on each face that one drags."""

from __future__ import annotations

import numpy as np

from mapper.core.array_types import Float64Array
from server.parts.volume.chosen_voxel import box_edges
from server.parts.volume.look import AXES, PLAIN, Look
from server.parts.volume.message_fields import outside
from server.parts.volume.messages import VolumeLookCommand
from server.sessions.drawings import Drawing, Gizmo, Point, Quaternion, Segments

HANDLE_PIXELS = 64.0  #: length of the arrow on a face
LEAST_M = 0.05  #: least length of a side that handles make

#: Value of the look → the rotation that turns the arrow along an axis out of the box: by half a turn at the low faces.
_OUTWARDS: dict[str, Quaternion] = {
    "cut_x_low": (0.0, 0.0, 0.0, 1.0),
    "cut_x_high": (1.0, 0.0, 0.0, 0.0),
    "cut_y_low": (0.0, 1.0, 0.0, 0.0),
    "cut_y_high": (1.0, 0.0, 0.0, 0.0),
    "cut_low": (0.0, 1.0, 0.0, 0.0),
    "cut_high": (1.0, 0.0, 0.0, 0.0),
}


class ClipBox:
    """The clip box of a map whose least and greatest coordinates are ``low`` and ``high`` (3,), metres."""

    def __init__(self, low: Float64Array, high: Float64Array) -> None:
        self._low, self._high = low, high
        self._ends = outside(low, high)

    def drawings(self, look: Look) -> list[Drawing]:
        """Return the edges where the box cuts off a part of the map, and with handles always."""
        if look.cut_handles:
            low, high = self._corners(look)
            return [_edges(low, high), *_handles(low, high)]
        low, high = np.maximum(look.low, self._low), np.minimum(look.high, self._high)
        if (low >= high).any() or ((low == self._low).all() and (high == self._high).all()):
            return []
        return [_edges(low, high)]

    def moved(self, look: Look, handle: str, position: Point) -> VolumeLookCommand | None:
        """Return the command for a handle that was moved to ``position``, metres; None for a name of none.

        A face stays within the bounds of its slider, and at least :data:`LEAST_M` before the opposite face.
        """
        name = handle.replace("-", "_")
        if name not in _OUTWARDS:
            return None
        axis = AXES[name]
        low, high = self._corners(look)
        if name.endswith("low"):
            least, most = self._ends[0][axis], float(high[axis]) - LEAST_M
        else:
            least, most = float(low[axis]) + LEAST_M, self._ends[1][axis]
        return VolumeLookCommand({name: round(min(max(position[axis], least), most), 3)})

    def _corners(self, look: Look) -> tuple[Float64Array, Float64Array]:
        """Return the box within the map (3,), (3,)."""
        low, high = (np.clip(corner, self._low, self._high) for corner in (look.low, look.high))
        return low, high


def _edges(low: Float64Array, high: Float64Array) -> Segments:
    return Segments(name="clip", label="Clip box", points=box_edges(low, high), colors=PLAIN, width=1.5)


def _handles(low: Float64Array, high: Float64Array) -> list[Drawing]:
    found: list[Drawing] = []
    for name, wxyz in _OUTWARDS.items():
        axis, place = AXES[name], (low + high) / 2
        place[axis] = (low if name.endswith("low") else high)[axis]
        x, y, z = place.tolist()
        axes = (axis == 0, axis == 1, axis == 2)
        found.append(
            Gizmo(name=name.replace("_", "-"), label="Clip box", position=(x, y, z), wxyz=wxyz, axes=axes, turns=False,
                  scale=HANDLE_PIXELS, unit="screen")
        )  # fmt: skip
    return found
