"""Drawings of a model in 3D, as plain data. The code that draws them is in ``server.scenes.drawers``.

Positions are in metres in the map frame, x forward, y left, z up; rotations are unit quaternions (w, x, y, z). A
drawing is identified by its ``name``: the next drawing of the same name replaces it, and parts that did not change are
not sent again. Arrays must not be modified once they are in a drawing, unless its class says otherwise: a model puts
changed values into a new array of the next drawing. If an array is the same object as before, it counts as unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry
from mapper.volume.mesh.chunk_mesh import ChunkMesh

MAX_DRAWING_BYTES = 64 << 20  #: bytes of the arrays of one drawing, which are sent in one message

Color = tuple[int, int, int]  #: red, green, blue, 0 to 255
Point = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Pose = tuple[float, float, float]  #: x, y, yaw

_NAME = re.compile(r"[a-z0-9_-]{1,100}")

CHOSEN = (232, 60, 140)  #: colour of the selected item


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawing:
    """Base class of drawings.

    ``name`` is unique among the drawings of a model: 1 to 100 characters of a–z, 0–9, ``_`` and ``-``. ``label`` names
    the switch that shows and hides all drawings of the same label; "" for no switch. Raises :class:`ValueError` for an
    invalid name.
    """

    name: str
    label: str = ""

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ValueError(f"a drawing cannot be named {self.name!r}")

    @property
    def nbytes(self) -> int:
        """Bytes of the arrays that are sent in one message. A drawing above :data:`MAX_DRAWING_BYTES` is not shown."""
        return 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlacedDrawing(Drawing):
    """A drawing with its own frame: ``position`` and ``wxyz`` are T_map_drawing."""

    position: Point = (0.0, 0.0, 0.0)
    wxyz: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh(PlacedDrawing):
    """Triangles: ``vertices`` (V, 3) float32, ``faces`` (F, 3) uint32, counter-clockwise seen from outside.

    ``opacity`` is 0 to 1, None for opaque. Raises :class:`ValueError` for other shapes or types.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    color: Color = (150, 160, 178)
    opacity: float | None = None
    flat_shading: bool = True
    two_sided: bool = False

    def __post_init__(self) -> None:
        Drawing.__post_init__(self)
        _check("vertices", self.vertices, "f4", (None, 3))
        _check("faces", self.faces, "u4", (None, 3))

    @property
    def nbytes(self) -> int:
        """Bytes of the vertices and faces."""
        return self.vertices.nbytes + self.faces.nbytes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Points(PlacedDrawing):
    """A point cloud: ``points`` (n, 3) float32; ``colors`` (n, 3) uint8, or one colour for all.

    Points are drawn ``size`` metres wide. Only those within ``clip`` (least and greatest coordinates, inclusive; None:
    all) are drawn. The browser clips them, so that another box is sent without the points. Raises :class:`ValueError`
    for other shapes or types.
    """

    points: NDArray[np.float32]
    colors: NDArray[np.uint8] | Color = (71, 78, 96)
    size: float = 0.05
    clip: tuple[Point, Point] | None = None

    def __post_init__(self) -> None:
        Drawing.__post_init__(self)
        _check("points", self.points, "f4", (None, 3))
        if isinstance(self.colors, np.ndarray):
            _check("colors", self.colors, "u1", self.points.shape)

    @property
    def nbytes(self) -> int:
        """Bytes of the points and their colours."""
        return self.points.nbytes + (self.colors.nbytes if isinstance(self.colors, np.ndarray) else 0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Voxels(PlacedDrawing):
    """The visible faces of voxels of ``size`` metres, in chunks of 32³ voxels.

    ``chunks`` maps the key of each chunk (x, y, z of its first voxel, divided by 32) to its rectangles (n, 7) uint8, as
    :func:`mapper.volume.kernels.faces.merge_faces` computes them; an array that is the same object is unchanged. The
    voxel of key 0 begins at ``-corner * size`` along each axis of the drawing's frame. ``palette`` (k, 3) uint8 has the
    colours, from 1, which are lightened and darkened by the direction of the face. If ``by_side``, its first six are
    instead the colours of the sides −x, +x, −y, +y, −z, +z.
    """

    chunks: Mapping[tuple[int, int, int], NDArray[np.uint8]]
    palette: NDArray[np.uint8]
    size: float
    corner: int = 0
    by_side: bool = False

    def __post_init__(self) -> None:
        Drawing.__post_init__(self)
        _check("palette", self.palette, "u1", (None, 3))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surface(PlacedDrawing):
    """The triangles of a surface with voxels of ``size`` metres, in chunks of 32³ voxels.

    ``chunks`` maps the key of each chunk, as in :class:`Voxels`, to its mesh; a mesh that is the same object is
    unchanged. ``colors`` returns the colours (n, 3) uint8, sRGB, of a chunk's vertices from its key and mesh; they are
    lightened and darkened by the normals, and change only with ``colors_key``. Triangles are visible from outside.
    """

    chunks: Mapping[tuple[int, int, int], ChunkMesh]
    colors: Callable[[tuple[int, int, int], ChunkMesh], NDArray[np.uint8]]
    colors_key: Hashable
    size: float
    corner: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Segments(PlacedDrawing):
    """Straight lines: ``points`` (n, 2, 3) float32, the two ends of each; ``colors`` of them, or one colour for all.

    ``colors`` is (n, 2, 3) uint8, a colour for each end. ``width`` is in pixels, or in metres if ``unit`` is "world".
    Raises :class:`ValueError` for other shapes or types.
    """

    points: NDArray[np.float32]
    colors: NDArray[np.uint8] | Color = (71, 78, 96)
    width: float = 1.0
    unit: Literal["screen", "world"] = "screen"

    def __post_init__(self) -> None:
        Drawing.__post_init__(self)
        _check("points", self.points, "f4", (None, 2, 3))
        if isinstance(self.colors, np.ndarray):
            _check("colors", self.colors, "u1", self.points.shape)

    @property
    def nbytes(self) -> int:
        """Bytes of the ends and their colours."""
        return self.points.nbytes + (self.colors.nbytes if isinstance(self.colors, np.ndarray) else 0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Image(PlacedDrawing):
    """An image in the x-y plane of its frame, its centre at the origin, its top row at the greatest y.

    ``pixels`` (rows, cols, 3 or 4) uint8 are RGB or RGBA; the image is ``width`` by ``height`` metres. Raises
    :class:`ValueError` for other shapes or types.
    """

    pixels: NDArray[np.uint8]
    width: float
    height: float

    def __post_init__(self) -> None:
        Drawing.__post_init__(self)
        _check("pixels", self.pixels, "u1", (None, None, self.pixels.shape[-1]))
        if self.pixels.shape[-1] not in (3, 4):
            raise ValueError(f"pixels have 3 or 4 channels, not {self.pixels.shape[-1]}")

    @property
    def nbytes(self) -> int:
        """Bytes of the pixels; they are sent as PNG."""
        return self.pixels.nbytes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Gizmo(PlacedDrawing):
    """Handles for moving and rotating a frame. Each move calls the model's ``on_gizmo_moved``.

    The gizmo keeps its new pose until the model returns that pose. If the model does not, the gizmo is reset after 1.5
    s. ``axes`` are the axes along which it can be moved (if ``moves``) and about which it can be rotated (if
    ``turns``). An arrow is ``scale`` metres long, or ``scale`` pixels if ``unit`` is "screen".
    """

    scale: float = 1.0
    unit: Literal["screen", "world"] = "world"
    axes: tuple[bool, bool, bool] = (True, True, True)
    moves: bool = True
    turns: bool = True


COLUMN_M = 0.5  #: height of the highest columns of a grid


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GridColumns(Drawing):
    """An occupancy grid: a floor coloured by p_occ, and a column on each occupied cell.

    ``log_odds`` float32 and ``observed`` bool are (rows, cols). They may be the arrays that the session updates,
    because they are read between two ticks.
    """

    geometry: GridGeometry
    log_odds: NDArray[np.float32]
    observed: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Walls(Drawing):
    """The solids of a simulated world as low walls, and its ground.

    ``solids`` are simple polygons (n, 2), counter-clockwise; the same object as long as they do not change. ``bounds``
    are x_min, y_min, x_max, y_max of the ground.
    """

    solids: Sequence[NDArray[np.float64]]
    bounds: tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotBody(Drawing):
    """A robot on the floor at ``pose``, T_map_base, and the beams of its newest scan, which move with it.

    ``beams`` (n, 2, 3) float32 are the two ends of each beam in the base frame. ``beams_label`` is the label of their
    switch.
    """

    pose: Pose
    beams: NDArray[np.float32]
    beams_label: str = "Beams"
    radius: float = 0.25


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Path(Drawing):
    """A path on the floor along ``poses`` (n, 3 or 2), x and y first. Long paths are drawn with fewer points."""

    poses: NDArray[np.float64]
    color: Color = (71, 78, 96)


def _check(name: str, array: NDArray[Any], dtype: str, shape: tuple[int | None, ...]) -> None:
    """Raise :class:`ValueError` unless ``array`` has this type and shape; None stands for any length."""
    fits = len(shape) == array.ndim and all(b in (None, a) for a, b in zip(array.shape, shape, strict=True))
    if array.dtype != np.dtype(dtype) or not fits:
        expected = ", ".join("n" if side is None else str(side) for side in shape)
        raise ValueError(f"{name} must be ({expected}) of {np.dtype(dtype)}, not {array.shape} of {array.dtype}")
