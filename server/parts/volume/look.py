"""Display options of a 3D map: their table and the colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import BoolArray, Float32Array
from mapper.core.parameter import check_fields, choice, flag, number, table_of
from mapper.volume.mesh.voxel_normals import directions

#: Rows with the bounds of the map, and their axes.
AXES = {
    "cut_x_low": 0, "cut_x_high": 0, "cut_y_low": 1, "cut_y_high": 1, "cut_low": 2, "cut_high": 2,
    "band_low": 2, "band_high": 2,
}  # fmt: skip
CUTS = tuple(name for name in AXES if name.startswith("cut"))  #: those of the clip box
Corner = tuple[float, float, float]  #: of the clip box, metres
COLOURS = 24  #: of a ramp
FARTHEST_M = 10_000.0


def _place(label: str, initial: float, sentence: str) -> float:
    return number(label, "look", initial, sentence, "m", -FARTHEST_M, FARTHEST_M, 0.01)


@dataclass(frozen=True, slots=True)
class Look:
    """Display options of a 3D map, see the table :data:`LOOK_PARAMETERS`.

    Raises :class:`ConfigError` for a value outside its row.
    """

    # fmt: off
    show: str = choice(
        "Show", "look", "voxels",
        "Occupied voxels, the points that they were made from, both, or the surface by signed distances.",
        ("voxels", "points", "both", "surface"),
    )
    colour: str = choice(
        "Colour by", "look", "height",
        "What the colours show: height, occupancy probability, the side of a voxel, the direction that a surface "
        "faces, what the file states of its points, when they were measured, or how far the nearest point of the cloud "
        "is that this one is compared with.",
        ("height", "probability", "side", "normal", "intensity", "time", "difference", "class", "own colour"),
    )
    band: float = number("Height band", "look", 0.25, "Height of one colour.", "m", 0.05, 10.0, 0.05)
    whole: bool = flag(
        "Unseen sides", "look", False,
        "Whether faces towards unknown space are drawn too, which no sensor has seen. Without them a room can be "
        "looked into from outside.",
    )
    point_size: float = number(
        "Point size", "look", 1.0, "Width of a point, relative to the usual one.", "", 0.25, 8.0, 0.25
    )
    cut_x_low: float = _place("Clip x from", -FARTHEST_M, "What has a smaller x is not drawn.")
    cut_x_high: float = _place("Clip x to", FARTHEST_M, "What has a greater x is not drawn.")
    cut_y_low: float = _place("Clip y from", -FARTHEST_M, "What has a smaller y is not drawn.")
    cut_y_high: float = _place("Clip y to", FARTHEST_M, "What has a greater y is not drawn.")
    cut_low: float = _place("Cut below", -FARTHEST_M, "What is lower is not drawn.")
    cut_high: float = _place("Cut above", FARTHEST_M, "What is higher is not drawn.")
    cut_handles: bool = flag(
        "Handles", "look", False, "Whether each face of the clip box has a handle in the view, which one drags.",
    )
    band_low: float = _place("Map from", -FARTHEST_M, "Lowest height of the map from above.")
    band_high: float = _place(
        "Map to", FARTHEST_M, "Greatest height of the map from above; equal heights are a slice.",
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def low(self) -> Corner:
        """The least coordinates of the clip box, metres."""
        return self.cut_x_low, self.cut_y_low, self.cut_low

    @property
    def high(self) -> Corner:
        """The greatest coordinates of the clip box, metres."""
        return self.cut_x_high, self.cut_y_high, self.cut_high

    def shows(self, points: Float32Array) -> BoolArray:
        """Return which of points (n, 3) are in the clip box (n,)."""
        return np.asarray(((points >= self.low) & (points <= self.high)).all(axis=1))


LOOK_PARAMETERS = table_of(Look)


def _ramp(*stops: tuple[int, int, int]) -> NDArray[np.uint8]:
    at = np.linspace(0.0, len(stops) - 1.0, COLOURS)
    rgb = [np.interp(at, range(len(stops)), [stop[k] for stop in stops]) for k in range(3)]
    return np.round(np.stack(rgb, axis=1)).astype(np.uint8)


#: From low to high. Lightness increases throughout, so that heights differ without hues too.
HEIGHT_RAMP = _ramp((46, 58, 128), (33, 113, 151), (44, 158, 128), (137, 196, 82), (240, 222, 96))
#: From the least probability of an occupied voxel to the greatest.
BELIEF_RAMP = _ramp((250, 224, 190), (222, 130, 66), (110, 36, 12))
#: Of the sides −x, +x, −y, +y, −z, +z; opposite sides have the same hue.
SIDE_COLOURS = np.array(
    [(206, 104, 82), (206, 104, 82), (92, 160, 104), (92, 160, 104), (98, 116, 184), (120, 150, 220)], dtype=np.uint8
)
ADDED, REMOVED = (22, 138, 96), (196, 48, 40)
PLAIN = (96, 106, 124)
#: Of the ASPRS LAS 1.4 classes used for airborne scans: created, unclassified, ground, vegetation, building, ...
CLASS_COLOURS = np.array(
    [
        (150, 150, 150), (150, 150, 150), (172, 120, 66), (150, 200, 110), (96, 170, 80), (38, 130, 56), (208, 74, 60),
        (90, 60, 90), (230, 200, 80), (60, 120, 210), (110, 110, 120), (80, 80, 90),
    ],
    dtype=np.uint8,
)  # fmt: skip


def ramp_of(values: NDArray[Any], low: float, high: float, ramp: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the colours (n, 3) of values (n,) between ``low`` and ``high``."""
    share = (values - low) * (len(ramp) / max(high - low, 1e-9))
    # The maximum is 0 for NaN too.
    return ramp.take(np.fmin(np.fmax(share, 0.0), len(ramp) - 1.0).astype(np.intp), axis=0)


def normal_colors(normals: NDArray[np.int8]) -> NDArray[np.uint8]:
    """Return the colours (n, 3) of surfaces with ``normals`` (n, 3), mixed from those of the voxels' sides."""
    away = normals.astype(np.float64)
    squares = away * away
    squares /= np.maximum(squares.sum(axis=1, keepdims=True), 1.0)
    sides = SIDE_COLOURS.astype(np.float64)
    mixed = sum(
        squares[:, [axis]] * np.where(away[:, [axis]] < 0.0, sides[2 * axis], sides[2 * axis + 1]) for axis in range(3)
    )
    return np.round(np.asarray(mixed)).astype(np.uint8)


#: Of the directions of voxels, numbered from 1.
NORMAL_COLOURS = normal_colors(np.round(127.0 * directions()).astype(np.int8))
