"""The model of a session that shows a 3D map. It integrates the scans and answers questions about voxels."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from msgspec import Struct

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError, MapperError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.core.parameter import Values, with_values
from mapper.grid import OccupancyGrid
from mapper.io.clouds.ply import points_ply
from mapper.volume import VOLUME_PARAMETERS, Octree, OctreeFile, VolumeConfig, octree_file, project
from mapper.volume.mesh.faces import FaceRule
from mapper.volume.occupancy.volume import centres_of
from mapper.volume.scans.map_offset import georeferenced
from mapper.volume.scans.replayed import ReplayedVolume
from mapper.volume.scans.scan_sequence import ScanSequence
from mapper.volume.surface.replayed import ReplayedSurface
from server.parts import parts_of
from server.parts.volume.cloud_points import CloudPoints
from server.parts.volume.comparison import VolumeComparison
from server.parts.volume.drawings import VolumeDrawings
from server.parts.volume.message_fields import log_info, look_table, no_voxel
from server.parts.volume.messages import (
    SurfaceCommand,
    VolumeKeepCommand,
    VolumeLookCommand,
    VolumeMessage,
    VoxelCommand,
    VoxelRayCommand,
)
from server.parts.volume.point_values import PointValues
from server.parts.volume.sight import sensor_sight
from server.parts.volume.start import bounds_of, check_resolution, first_look, first_resolution, map_limits, times_of
from server.parts.volume.surface import VolumeSurface
from server.parts.volume.voxel_questions import VoxelQuestions, place_met
from server.sessions.drawings import Drawing, Point
from server.sessions.model import NO_READINGS, Footprint, SessionModel
from server.sessions.part import Offers
from server.sessions.parts import Volumetric
from server.sessions.scene_controls import SceneControls
from server.sessions.tick import TickResult
from server.sources.scan_timeline import ScanTimeline
from server.stream.commands import CancelCommand, ParametersCommand, RestartCommand, SeekCommand, StepCommand
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer
from server.stream.message_parts import Table, rows_of
from server.stream.messages import FrameMessage, Hello, ParametersMessage, ScanFields
from server.stream.protocol import ProtocolError

if TYPE_CHECKING:
    from server.library.packs.volume import VolumeSource
    from server.sessions.hosting import ModelHost

SLICE_S = 0.1  #: longest time of inserting scans before the map is shown
PIECE_S = 0.05  #: longest time of drawing voxels
LOG_ODDS = 3.5  #: the range of the map from above


class VolumeModel(SessionModel, Volumetric):
    """A map of occupied and free voxels from the scans of ``source`` so far, or an octree."""

    kind: ClassVar[str] = "volume"
    is_on = True
    is_asked = True
    replacing: ClassVar[tuple[type[Struct], ...]] = (
        SeekCommand,
        StepCommand,
        RestartCommand,
        ParametersCommand,
        SurfaceCommand,
    )
    resent_on_refusal: ClassVar[Mapping[type[Struct], str]] = {
        ParametersCommand: "parameters",
        VolumeLookCommand: "volume",
        SurfaceCommand: "surface",
    }

    def __init__(
        self, host: ModelHost, source: VolumeSource, *, log_id: str, title: str, topic: str | None = None,
        other: tuple[str, VolumeSource] | None = None, up: str = "z",
    ) -> None:  # fmt: skip
        """``other`` is the title and source of a map to compare with, ``up`` the file's axis that becomes z here."""
        self._host, self._source = host, source
        self._log_id, self._title, self._topic = log_id, title, topic
        self._up = up
        if isinstance(source, OctreeFile):
            source.tree.check_size(self._limits())  # it has one scan; if that did not fit, nothing would be shown
        self._low, self._high = bounds_of(source)
        self._config = VolumeConfig(resolution=first_resolution(source, self._low, self._high))
        self._map = ReplayedVolume(source, self._config, self._limits)
        self._look = self._first_look = first_look(self._low, self._high, self._config.resolution)
        scans = source if isinstance(source, ScanSequence) else None
        points = None if other is None else other[1]
        self._values = PointValues(scans, points if isinstance(points, ScanSequence) else None)
        self._drawn = VolumeDrawings(source, self._low, self._high, self._values)
        self._questions = VoxelQuestions(host, self._drawn.chosen, scans)
        self._surface = VolumeSurface(scans, self._config.resolution, self._limits)
        self._timeline = ScanTimeline(times_of(source), self._map.count)
        self._layer = GridLayer("map", "Map from above")
        self._stale_grid = True
        self._nodes: int | None = None
        self._comparison = VolumeComparison(other, self._limits)
        self.parts = parts_of(Offers(host, CloudPoints(scans, self._low, self._high, other)))
        super().__init__(self._timeline.first_playback())

    def _limits(self) -> Limits:
        """Return the limits of the map."""
        return map_limits(self._host.limits())

    # -- display --------------------------------------------------------------------------------------------------

    @property
    def layers(self) -> Sequence[Layer]:
        """The map from above, and the layers of the parts."""
        return (self._layer, *(layer for part in self.parts_on for layer in part.layers))

    @property
    def title(self) -> str:
        """The name of the file."""
        return self._title

    @property
    def grid(self) -> OccupancyGrid | None:
        """The map from above, of the band of heights."""
        with contextlib.suppress(MapperError):
            return project(self._map.volume, self._look.band_low, self._look.band_high)
        return None

    @property
    def above(self) -> OccupancyGrid | None:
        """The map from above in the file's coordinates."""
        grid = self.grid
        return None if grid is None else georeferenced(grid, self._offset)

    @property
    def _offset(self) -> Float64Array:
        """What to add to map coordinates to get those of the file (3,), metres."""
        return self._source.offset

    def question(self, origin: Point, direction: Point) -> VoxelRayCommand:
        """Return the command that queries the voxel that a line of sight meets."""
        return VoxelRayCommand(origin, direction)

    def met(self, origin: Point, direction: Point) -> tuple[Point, float] | None:
        """Return where a line of sight meets the displayed surface, points or voxels."""
        if self._is_surface:
            return self._surface.met(origin, direction)
        scans = self._source if isinstance(self._source, ScanSequence) and self._look.show != "voxels" else None
        return place_met(self._map, self._rule(), (np.array(origin), np.array(direction)), scans)

    def clipped(self, handle: str, position: Point) -> VolumeLookCommand | None:
        """Return the command that moves a face of the clip box with its handle."""
        values = self._drawn.clip_box.moved(self._look, handle, position)
        return None if values is None else VolumeLookCommand(values)

    def octree_bytes(self, kind: str) -> bytes:
        """Return the current map as a ``.bt`` or ``.ot`` file; for an octree of this kind, the original file."""
        if isinstance(self._source, OctreeFile) and self._source.kind == kind:
            return self._source.bytes(self._config)
        return octree_file(Octree.of(self._map.volume), kind, self._config, self._offset).bytes(self._config)

    def mesh_bytes(self, kind: str) -> bytes:
        """Return the current surface as a ``.ply`` or ``.glb`` file. Raises :class:`ConfigError` if there is none."""
        return self._surface.file(kind, self._shown.index, self._offset)

    def selection_bytes(self) -> bytes:
        """Return the points of the scans so far in the clip box as a ``.ply`` file, with their known values."""
        if not isinstance(self._source, ScanSequence):
            voxels = self._map.volume.voxels(float(self._config.log_odds_occupied))[0]
            centres = centres_of(voxels, self._config.resolution)
            return points_ply(centres[self._look.shows(centres)], {}, self._offset)
        points = self._source.points[: self._source.starts[self._map.index]]
        some = np.flatnonzero(self._look.shows(points))
        fields = {name: values[some] for name, values in self._source.fields.items()}
        return points_ply(points[some], fields, self._offset)

    @property
    def _is_surface(self) -> bool:
        return self._look.show == "surface"

    @property
    def _shown(self) -> ReplayedVolume | ReplayedSurface:
        """The map that follows the timeline first."""
        return self._surface.replayed if self._is_surface else self._map

    @property
    def footprint(self) -> Footprint:
        """Voxels of the map and of the one compared with it, and the points, stored and drawn."""
        points = 3 * len(self._source.points) if isinstance(self._source, ScanSequence) else self._source.tree.n_nodes
        of_parts = sum(part.cells for part in self.parts_on)
        drawn = self._surface.cells + self._drawn.n_cells
        return Footprint(self._map.n_cells + self._comparison.n_cells + points + of_parts + drawn)

    @property
    def progress(self) -> tuple[int, int]:
        """Scans in the map, scans in total."""
        return (self._shown.index, self._map.count)

    def complete(self, hello: Hello) -> None:
        """Set the file as a log without planar scans, and the table of the map's parameters."""
        if isinstance(self._source, ScanSequence):
            hello.parameters = Table(rows_of(VOLUME_PARAMETERS), asdict(self._config))
        hello.log = log_info(self._source, self._log_id, self._topic, self._timeline.duration)

    def messages(self) -> list[Struct]:
        """Return the contents of the map, its parameters, and the message that no voxel is chosen."""
        return [
            self._message(),
            self._parameters(),
            *super().messages(),
            self._surface.message(),
            no_voxel(self._config.resolution),
            self._surface.no_voxel(),
        ]

    def _parameters(self) -> ParametersMessage:
        return ParametersMessage(asdict(self._config), None)

    def complete_frame(self, frame: FrameMessage) -> None:
        """Set the time of the newest scan."""
        frame.stamp = round(self._timeline.stamp(self._shown.index), 3)

    def scan(self) -> ScanFields:
        """Return a scan without readings."""
        return NO_READINGS

    def drawings(self) -> list[Drawing]:
        """Return the voxels, the points, the chosen voxel, and the differences from another map."""
        surface = [self._surface.drawing(self._look, float(self._low[2]))] if self._is_surface else []
        return [
            *self._drawn.current(self._map.volume, self._look),
            *surface,
            *(drawing for part in self.parts_on for drawing in part.drawings()),
        ]

    def controls(self) -> SceneControls:
        """Return the initial view of the camera, and the sensor's pose."""
        (x0, y0, z0), (x1, y1, z1) = self._low.tolist(), self._high.tolist()
        sight = sensor_sight(self._source, self._shown.index) if isinstance(self._source, ScanSequence) else None
        return SceneControls(playing=self.playback.playing, bounds=(x0, y0, x1, y1), heights=(z0, z1), sight=sight)

    @property
    def _has_free(self) -> bool:
        return not isinstance(self._source, ScanSequence) or self._source.has_origins

    def _rule(self) -> FaceRule:
        return self._drawn.rule(self._map.volume, self._look, has_free=self._has_free)

    def _message(self) -> VolumeMessage:
        volume, source = self._map.volume, self._map.source
        occupied, free = volume.count_states()
        sides = np.maximum(np.ceil((self._high - self._low) / self._map.config.resolution), 1.0)
        chunks = self._drawn.faces.chunks
        return VolumeMessage(
            look=look_table(self._first_look, self._look, self._low, self._high),
            low=self._low.tolist(),
            high=self._high.tolist(),
            has_scans=isinstance(source, ScanSequence),
            has_free=self._has_free,
            up=self._up,
            points=int(source.starts[self._map.index]) if isinstance(source, ScanSequence) else len(source.tree.masks),
            left_out=self._map.inserted.left_out,
            occupied=occupied,
            free=free,
            bytes=volume.n_bytes,
            dense_bytes=4.0 * float(np.prod(sides)),
            nodes=self._nodes,
            chunks=len(chunks),
            quads=sum(len(quads) for quads in chunks.values()),
            pending=self._drawn.pending,
            colours=self._values.names,
            scale=self._values.scale(self._look.colour),
            compared=self._comparison.summary(),
        )

    # -- commands -------------------------------------------------------------------------------------------------

    def handle(self, command: Struct, result: TickResult) -> None:
        """Carry out a command."""
        match command:
            case VoxelCommand() | VoxelRayCommand():
                if self._is_surface:
                    self._surface.ask(command, self._host, self._drawn.chosen, result)
                else:
                    self._questions.handle(command, self._map, self._rule, result)
            case SeekCommand(index=index):
                if not 0 <= index <= self._map.count:
                    message = f"There are {self._map.count} scans; there is none after {index}."
                    raise ProtocolError("command.index", message)
                is_there = index == self._timeline.target
                self._timeline.go_to(index)
                if is_there:
                    return
            case StepCommand(scans=scans):
                self.playback.playing = False
                self._timeline.go_to(self._shown.index + scans)
            case RestartCommand():
                self._timeline.go_to(0)
                self.playback.playing = True
            case CancelCommand():
                self._timeline.go_to(self._shown.index)
            case ParametersCommand(values=values):
                self._set_config(values, result)
            case SurfaceCommand(values=values):
                if self._surface.set_values(values):
                    self._clear_voxel(result)
                result.slot(self._surface.message())
            case VolumeLookCommand(values=values):
                self._set_look(values, result)
            case VolumeKeepCommand(value=keeps):
                self._comparison.end()
                self._drawn.show_changes(None, self._config.resolution)
                if keeps:
                    self._comparison.keep(self._map)
                result.slot(self._message())
            case _:
                super().handle(command, result)
                return
        result.changed = True

    def play(self) -> None:
        """Play; from the start if the end was reached."""
        if self._shown.index == self._map.count:
            self._timeline.go_to(0)
        super().play()

    def _set_config(self, values: Values, result: TickResult) -> None:
        config = with_values(self._config, values)
        if isinstance(self._source, OctreeFile):
            raise ConfigError("volume.octree", "An octree has no parameters: its scans are not known.")
        if config == self._config:
            return
        check_resolution(self._low, self._high, config.resolution)
        self._config = config
        self._map = ReplayedVolume(self._source, config, self._limits)
        self._comparison.note_change()
        self._drawn.faces.clear()
        self._drawn.show_changes(None, config.resolution)
        self._clear_voxel(result)
        result.slot(self._parameters())

    def _clear_voxel(self, result: TickResult) -> None:
        """Choose no voxel."""
        self._questions.clear(self._config.resolution, result)
        result.slot(self._surface.no_voxel())

    def _set_look(self, values: Values, result: TickResult) -> None:
        look = with_values(self._look, values)
        if look.show == "surface":
            self._surface.replayed  # noqa: B018 - raises where there is none
        old, self._look = self._look, look
        if (old.show == "surface") != (look.show == "surface"):
            self._clear_voxel(result)
        if (old.band_low, old.band_high) != (self._look.band_low, self._look.band_high):
            self._stale_grid = True
        self._drawn.note_look(self._map.volume, old, self._look)

    # -- computing ------------------------------------------------------------------------------------------------

    @property
    def is_catching_up(self) -> bool:
        """Whether scans still have to be integrated; during playback, only into the displayed map."""
        if self._shown.index != self._timeline.target:
            return True
        return self._map.index != self._timeline.target and not self.playback.playing

    @property
    def catch_up_pause_s(self) -> float:
        """Remaining time for sending the surface."""
        return self._surface.sending_s if self._is_surface and self._shown.index == self._timeline.target else 0.0

    @property
    def fraction(self) -> float | None:
        """Share of the requested scans in the map, or the completed share of a part's computation."""
        share = next((part.progress for part in self.parts_on if part.progress is not None), None)
        if share is not None:
            return share
        target = self._timeline.target
        behind = self._map if self._shown.index == target else self._shown
        return behind.index / target if target and self.is_catching_up else None

    @property
    def working_on(self) -> str:
        """The answer about a voxel if one is being computed, otherwise the map or a part."""
        is_voxel = self._questions.is_busy or self._surface.is_busy
        return "voxel" if is_voxel else super().working_on

    def advance(self, dt: float, result: TickResult) -> None:
        """Play, and integrate scans into the map for a tenth of a second."""
        if dt > 0.0 and self.playback.playing:
            self._timeline.play(dt * self.playback.speed)
            result.changed = True
        if self._is_surface and self._shown.index != self._timeline.target:
            self._follow_surface(result)
        elif self.is_catching_up:
            self._catch_up(result)
        if self.playback.playing and self._shown.index == self._map.count:
            self.playback.playing = False
            result.changed = True

    def _catch_up(self, result: TickResult) -> None:
        self._nodes = None
        try:
            self._go_on(self._map)
        finally:
            self._note_change()
        if not self._is_surface:
            self._drawn.show_newest(self._map.index, self._look)
        result.changed = True

    def _follow_surface(self, result: TickResult) -> None:
        """Fuse scans and mesh the changes, so that they are drawn at once."""
        try:
            self._go_on(self._surface.replayed)
        finally:
            self._surface.mesh()
            result.slot(self._surface.message())
        result.changed = True

    def _go_on(self, shown: ReplayedVolume | ReplayedSurface) -> None:
        """Bring a map closer to the requested scan; if that is impossible, request the current one."""
        began = time.monotonic()
        try:
            with self._host.cancellable():
                shown.go_to(self._timeline.target, lambda: time.monotonic() - began > SLICE_S, self._host.may_continue)
        except WorkCancelledError:
            raise
        except MapperError:
            self._timeline.target = shown.index
            raise

    def _note_change(self) -> None:
        self._drawn.note_change(self._map.volume, self._map.take_touched())
        self._stale_grid = True
        self._comparison.note_change()

    @property
    def has_deferred_work(self) -> bool:
        """Whether voxels, the map from above or the comparison are out of date."""
        stale = self._is_surface and self._surface.is_stale
        return stale or self._drawn.is_stale or self._stale_grid or self._comparison.is_stale or self._nodes is None

    def run_deferred_work(self, result: TickResult) -> None:
        """Bring one of them, or a part of it, up to date."""
        began = time.monotonic()
        result.changed = True
        if self._is_surface and self._surface.is_stale:
            self._surface.mesh()
            result.slot(self._surface.message())
            return
        if self._drawn.is_stale:
            self._drawn.work(
                self._map.volume, self._map.index, self._look, has_free=self._has_free,
                is_over=lambda: time.monotonic() - began > PIECE_S,
            )  # fmt: skip
        elif self._stale_grid:
            self._update_layer()
        elif self._comparison.is_stale:
            self._comparison.update(self._map, self._drawn, self._host.may_continue, result)
        else:
            self._nodes = Octree.of(self._map.volume).n_nodes
        result.slot(self._message())

    def _update_layer(self) -> None:
        self._stale_grid = False
        if (grid := self.grid) is not None:
            self._layer.set(grid.geometry, grid.log_odds, -LOG_ODDS, LOG_ODDS, ~grid.observed)
