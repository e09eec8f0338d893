"""Drawings of a 3D map: its voxels in chunks, its points, the queried voxel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int32Array, Int64Array
from mapper.core.sampling import sample_rows
from mapper.volume import OccupancyVolume, OctreeFile, VolumeConfig
from mapper.volume.mesh.faces import CENTRE, ChunkKey, FaceRule, VoxelFaces, chunks_of, face_rule
from mapper.volume.mesh.voxel_classes import Painted, voxel_classes
from mapper.volume.mesh.voxel_normals import painted_directions
from mapper.volume.occupancy.changes import Changes
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume.chosen_voxel import HIT, ChosenVoxel
from server.parts.volume.clip_box import ClipBox, chunks_between
from server.parts.volume.look import (
    ADDED,
    BELIEF_RAMP,
    CLASS_COLOURS,
    COLOURS,
    CUTS,
    HEIGHT_RAMP,
    NORMAL_COLOURS,
    REMOVED,
    SIDE_COLOURS,
    Look,
    ramp_of,
)
from server.parts.volume.message_fields import outside
from server.parts.volume.point_values import UNITS, PointValues
from server.sessions.drawings import Drawing, Points, Voxels

MOST_POINTS = 5_000_000  #: maximum number of points drawn,
MOST_WHILE_CHANGING = 1_000_000  #: and until the last scan is in the map, as each scan sends them all again
IN_A_DRAWING = 1_000_000  #: points of one drawing: 15 MB in one message
IN_ORDER = 100_000  #: number of points above which they are in random order, so that a browser may draw a part
MOST_CLASSED = 2_000_000  #: maximum number of points whose classes are counted
MOST_MOVING = 6000  #: maximum number drawn of the newest scan while the map changes: 72 kB on the wire
DRAWN = ("show", "colour", "band", "whole", "point_size", *CUTS)  #: values of the look that change the drawings
WITHOUT_VOXELS = ("points", "surface")
PALETTES = {"side": SIDE_COLOURS, "probability": BELIEF_RAMP, "class": CLASS_COLOURS, "normal": NORMAL_COLOURS}
NUMBERED = ("probability", "class", "normal", *UNITS)  #: colourings with rectangles other than those for heights
NO_CHUNKS: dict[ChunkKey, NDArray[np.uint8]] = {}


class VolumeDrawings:
    """The drawings of a map. :meth:`work` updates them in pieces, :meth:`current` returns their current state."""

    def __init__(
        self, source: ScanSequence | OctreeFile, low: Float64Array, high: Float64Array, values: PointValues
    ) -> None:
        self._scans = source if isinstance(source, ScanSequence) else None
        self._low, self._high = low, high
        self.clip_box = ClipBox(low, high, outside(low, high))
        self.faces = VoxelFaces()
        self._values = values
        self._painted: tuple[tuple[float, str, int], Painted] | None = None  #: by resolution, colouring, points
        self._pending: set[ChunkKey] = set()
        self._chunks: dict[ChunkKey, NDArray[np.uint8]] = {}  #: the chunks shown
        self._points: list[Points] = []
        self._stale_points = True
        self._newest: Points | None = None
        self.chosen = ChosenVoxel()
        self._changes: list[Drawing] = []

    # -- updates --------------------------------------------------------------------------------------------------

    @property
    def pending(self) -> int:
        """Number of chunks to recompute."""
        return len(self._pending)

    @property
    def n_cells(self) -> int:
        """Size of the drawn points in 4-byte values."""
        return sum(points.nbytes for points in self._points) // 4

    @property
    def is_stale(self) -> bool:
        """Whether anything must be recomputed."""
        return bool(self._pending) or self._stale_points

    def note_change(self, volume: OccupancyVolume, slots: Int32Array | None) -> None:
        """Record that blocks have changed; None means all of them."""
        if slots is None:
            self._pending = set(chunks_of(volume)) | set(self.faces.chunks)
        else:
            self._pending |= set(chunks_of(volume, slots))
        self._stale_points = True

    def note_look(self, volume: OccupancyVolume, old: Look, new: Look) -> None:
        """Record that another look was chosen."""
        if all(getattr(old, name) == getattr(new, name) for name in DRAWN):
            return
        # A cut alone does not change the points, because the browser clips them.
        self._stale_points |= any(getattr(old, name) != getattr(new, name) for name in DRAWN if name not in CUTS)
        if old.show in WITHOUT_VOXELS:
            self._pending = set(chunks_of(volume)) | set(self.faces.chunks)
            return
        if old.colour != new.colour and not {old.colour, new.colour}.isdisjoint(NUMBERED):
            # Old rectangles in the new colours would be misleading until all are recomputed.
            self.faces.clear()
            self._chunks = {}
            self.note_change(volume, None)
            return
        if (old.band, old.whole) != (new.band, new.whole):
            self.note_change(volume, None)
            return
        self._pending.update(chunks_between(volume, old, new))

    def rule(self, volume: OccupancyVolume, look: Look, *, has_free: bool) -> FaceRule:
        """Return the rule by which voxels are drawn."""
        return face_rule(
            volume, look.low, look.high, base=float(self._low[2]), band=look.band, colours=COLOURS,
            by_belief=look.colour == "probability", seen_only=has_free and not look.whole,
        )  # fmt: skip

    def work(
        self, volume: OccupancyVolume, index: int, look: Look, *, has_free: bool, is_over: Callable[[], bool]
    ) -> None:
        """Recompute what is stale, until that is finished or ``is_over``."""
        if look.show in WITHOUT_VOXELS:
            self._pending.clear()
            self.faces.clear()
        rule = self.rule(volume, look, has_free=has_free)
        of_points = self._painted_by(look.colour, volume.config.resolution, index)
        # Low chunks first: the ground and the objects on it.
        for key in sorted(self._pending, key=lambda key: (key[2], key[1], key[0])):
            painted = painted_directions(volume, key) if look.colour == "normal" else of_points
            self.faces.update(volume, rule, [key], painted=painted)
            self._pending.discard(key)
            if is_over():
                break
        self._chunks = dict(self.faces.chunks)
        if not self._pending and self._stale_points:
            self._points = self._drawn_points(index, look)
            self._newest = None
            self._stale_points = False

    def _painted_by(self, colour: str, resolution: float, index: int) -> Painted | None:
        """Return the value that most points of each voxel have, as colours; None for a colouring without points.

        Times count only the first ``index`` scans.
        """
        if colour != "class" and colour not in UNITS:
            return None
        if self._scans is None or colour not in self._values.names:
            return {}
        end = int(self._scans.starts[index]) if colour == "time" else len(self._scans.points)
        if self._painted is None or self._painted[0] != (resolution, colour, end):
            some = sample_rows(end, MOST_CLASSED)
            is_class = colour == "class"
            numbers = self._scans.fields["class"].reshape(-1) if is_class else self._values.bands(colour)
            most = len(CLASS_COLOURS) if is_class else COLOURS
            painted = voxel_classes(self._scans.points[some], numbers[some], resolution, most)
            self._painted = (resolution, colour, end), painted
        return self._painted[1]

    def show_newest(self, index: int, look: Look) -> None:
        """Show the newest scan as points, while voxels are updated less often."""
        if self._scans is None or index == 0:
            return
        points = self._scans.points[self._scans.starts[index - 1] : self._scans.starts[index]]
        points = points[sample_rows(len(points), MOST_MOVING)]
        points = points[look.shows(points)]
        size = self._point_size(look)
        self._newest = Points(name="newest", points=np.ascontiguousarray(points), colors=HIT, size=size)

    def _point_size(self, look: Look) -> float:
        return look.point_size * float(np.clip(np.linalg.norm(self._high - self._low) / 1500.0, 0.004, 0.2))

    def _drawn_points(self, index: int, look: Look) -> list[Points]:
        """Return the points of the first ``index`` scans, each drawing with a random sample of them.

        While the camera moves, the browser draws only the first points of each
        (``static/src/render/voxels/pointBudget.ts``).
        """
        if self._scans is None or look.show in ("voxels", "surface"):
            return []
        scans, end = self._scans, int(self._scans.starts[index])
        most = MOST_POINTS if index == len(scans) else MOST_WHILE_CHANGING
        some = np.arange(end) if end <= min(most, IN_ORDER) else np.random.default_rng(0).permutation(end)[:most]
        points = np.ascontiguousarray(scans.points[some])
        colors: NDArray[np.uint8]
        if look.colour == "own colour" and "rgb" in scans.fields:
            colors = scans.fields["rgb"][some].astype(np.uint8)
        elif self._values.is_banded(look.colour):
            colors = HEIGHT_RAMP[self._values.bands(look.colour)[some]]
        elif look.colour == "class" and "class" in scans.fields:
            colors = CLASS_COLOURS[np.clip(scans.fields["class"][some].astype(np.int64), 0, len(CLASS_COLOURS) - 1)]
        else:
            low = float(self._low[2])
            colors = ramp_of(points[:, 2], low, low + COLOURS * look.band, HEIGHT_RAMP)
        size = self._point_size(look)
        return [
            Points(
                name=f"points-{start // IN_A_DRAWING}" if start else "points",
                label="Points",
                points=points[start : start + IN_A_DRAWING],
                colors=colors[start : start + IN_A_DRAWING],
                size=size,
            )
            for start in range(0, max(len(points), 1), IN_A_DRAWING)
        ]

    # -- comparison -------------------------------------------------------------------------------------------------

    def show_changes(self, changes: Changes | None, size: float) -> None:
        """Show the voxels that differ from another map; None ends it."""
        self._changes = []
        if changes is None:
            return
        for name, label, keys, color in (
            ("appeared", "Appeared", changes.appeared, ADDED),
            ("vanished", "Vanished", changes.vanished, REMOVED),
        ):
            chunks = _chunks_of_keys(keys, size)
            palette = np.array([color], dtype=np.uint8)
            self._changes.append(
                Voxels(name=name, label=label, chunks=chunks, palette=palette, size=size, corner=CENTRE)
            )

    def current(self, volume: OccupancyVolume, look: Look) -> list[Drawing]:
        """Return the drawings."""
        by_side = look.colour == "side"
        palette = PALETTES.get(look.colour, HEIGHT_RAMP)
        chunks = NO_CHUNKS if look.show in WITHOUT_VOXELS else self._chunks
        drawings: list[Drawing] = [
            Voxels(name="voxels", label="Voxels", chunks=chunks, palette=palette, size=volume.config.resolution,
                   corner=CENTRE, by_side=by_side)
        ]  # fmt: skip
        drawings += [replace(points, clip=(look.low, look.high)) for points in self._points]
        if self._newest is not None:
            drawings.append(self._newest)
        return [*drawings, *self.clip_box.drawings(look), *self.chosen.drawings, *self._changes]


def _chunks_of_keys(keys: Int64Array, size: float) -> dict[ChunkKey, NDArray[np.uint8]]:
    """Return the chunks of voxels (n, 3)."""
    if not len(keys):
        return {}
    volume = OccupancyVolume(VolumeConfig(resolution=size))
    volume.insert_scan((keys - CENTRE + 0.5) * size, None)
    faces = VoxelFaces()
    rule = face_rule(volume, -np.inf, np.inf, base=0.0, band=1e6, colours=1)
    faces.update(volume, rule, chunks_of(volume))
    return dict(faces.chunks)
