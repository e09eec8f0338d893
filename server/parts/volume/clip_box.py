"""The clip box of a 3D map: its edges, and a handle for dragging each face."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.parameter import Values
from mapper.volume import OccupancyVolume
from mapper.volume.mesh.faces import CENTRE, CHUNK, ChunkKey, chunks_of
from server.parts.volume.chosen_voxel import box_edges
from server.parts.volume.look import AXES, CUTS, PLAIN, Look
from server.sessions.drawings import Drawing, Gizmo, Point, Quaternion, Segments

HANDLE_PIXELS = 64.0  #: length of the arrow on a face
LEAST_M = 0.05  #: least side length that handles can set

#: Value of the look → the rotation that turns the arrow along an axis out of the box (by half a turn at low faces).
_OUTWARDS: dict[str, Quaternion] = {
    "cut_x_low": (0.0, 0.0, 0.0, 1.0),
    "cut_x_high": (1.0, 0.0, 0.0, 0.0),
    "cut_y_low": (0.0, 1.0, 0.0, 0.0),
    "cut_y_high": (1.0, 0.0, 0.0, 0.0),
    "cut_low": (0.0, 1.0, 0.0, 0.0),
    "cut_high": (1.0, 0.0, 0.0, 0.0),
}


class ClipBox:
    """The clip box of a map with the least and greatest coordinates ``low`` and ``high`` (3,), metres.

    Its faces stay within ``ends``, the bounds of their sliders; by default the map's.
    """

    def __init__(
        self, low: Float64Array, high: Float64Array, ends: tuple[Sequence[float], Sequence[float]] | None = None
    ) -> None:
        self._low, self._high = low, high
        self._ends = (low.tolist(), high.tolist()) if ends is None else ends

    def drawings(self, look: Look) -> list[Drawing]:
        """Return the edges of the box. Without handles, they are drawn only if it cuts off a part of the map."""
        if look.cut_handles:
            low, high = self._corners(look)
            return [_edges(low, high), *_handles(low, high)]
        low, high = np.maximum(look.low, self._low), np.minimum(look.high, self._high)
        if (low >= high).any() or ((low == self._low).all() and (high == self._high).all()):
            return []
        return [_edges(low, high)]

    def moved(self, look: Look, handle: str, position: Point) -> Values | None:
        """Return the new look value for a handle that was moved to ``position``, metres; None for another name.

        A face stays within the bounds of its slider, and at least :data:`LEAST_M` from the opposite face.
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
        return {name: round(min(max(position[axis], least), most), 3)}

    def _corners(self, look: Look) -> tuple[Float64Array, Float64Array]:
        """Return the box within the map (3,), (3,)."""
        low, high = (np.clip(corner, self._low, self._high) for corner in (look.low, look.high))
        return low, high


def chunks_between(volume: OccupancyVolume, old: Look, new: Look) -> list[ChunkKey]:
    """Return the chunks of a map in which the visible voxels change between two clip boxes."""
    voxel = volume.config.resolution
    spans = [(AXES[name], *sorted((getattr(old, name), getattr(new, name)))) for name in CUTS]
    spans = [(axis, low - voxel, high + voxel) for axis, low, high in spans if low < high]
    chunks = []
    for key in chunks_of(volume):
        corner = [(CHUNK * number - CENTRE) * voxel for number in key]
        if any(low <= corner[axis] + CHUNK * voxel and corner[axis] <= high for axis, low, high in spans):
            chunks.append(key)
    return chunks


def _edges(low: Float64Array, high: Float64Array) -> Segments:
    return Segments(name="clip", label="Clip box", points=box_edges(low, high), colors=PLAIN, width=1.5)


def _handles(low: Float64Array, high: Float64Array) -> list[Drawing]:
    handles: list[Drawing] = []
    for name, wxyz in _OUTWARDS.items():
        axis, place = AXES[name], (low + high) / 2
        place[axis] = (low if name.endswith("low") else high)[axis]
        x, y, z = place.tolist()
        axes = (axis == 0, axis == 1, axis == 2)
        handles.append(
            Gizmo(name=name.replace("_", "-"), label="Clip box", position=(x, y, z), wxyz=wxyz, axes=axes, turns=False,
                  scale=HANDLE_PIXELS, unit="screen")
        )  # fmt: skip
    return handles
