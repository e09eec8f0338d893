"""View of a simulation's 3D map: grids over the belief, the message with its numbers, and the 3D view."""

from __future__ import annotations

import numpy as np
from msgspec import Struct

from mapper.core.array_types import BoolArray, Float32Array, Float64Array
from mapper.core.errors import ConfigError
from mapper.core.sampling import sample_rows
from mapper.grid import OccupancyGrid
from mapper.io.clouds.ply import points_ply
from mapper.simulation.live_map import LiveMap
from mapper.volume import Octree, octree_file
from mapper.volume.mesh.faces import CENTRE, ChunkKey, FaceRule, VoxelFaces, chunks_of, face_rule, voxel_mesh
from mapper.volume.mesh.files import glb_bytes, ply_bytes
from mapper.volume.mesh.voxel_classes import Painted
from mapper.volume.mesh.voxel_normals import painted_directions
from mapper.volume.occupancy.volume import centres_of
from server.parts.volume.chosen_voxel import ChosenVoxel
from server.parts.volume.clip_box import ClipBox, chunks_between
from server.parts.volume.live_surface import LabSurface
from server.parts.volume.live_volume import LabVolume, only_in_3d, points_of, true_ground
from server.parts.volume.look import NORMAL_COLOURS
from server.parts.volume.messages import Map3dCommand, Map3dMessage, SurfaceMessage, VoxelCommand, VoxelRayCommand
from server.parts.volume.parameters import HIGHEST, LOWEST, VolumeParameters
from server.parts.volume.parameters import TABLE as MAP_3D
from server.parts.volume.voxel_questions import VoxelQuestions, place_met
from server.sessions.drawings import Drawing, GridColumns, Point, Points, Voxels
from server.sessions.hosting import ModelHost
from server.sessions.part import Offers, OtherMap, Part
from server.sessions.parts import DepthSensing, Volumetric
from server.sessions.tick import TickResult
from server.sessions.view import Playback
from server.stream.commands import RestartCommand, WorldCommand
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer
from server.stream.message_parts import rows_of

MOST_POINTS = 2000  #: maximum number drawn of the newest scan
SCANS_OF_PROJECTION = 2  #: scans between two projections,
SCANS_OF_MEMORY = 8  #: and between two counts of the nodes of the octree
BANDS = 12  #: colours of heights
POINT = (200, 60, 120)
#: From dark blue at the floor to yellow, in even steps of lightness.
PALETTE = np.array(
    [
        (48, 60, 120), (46, 82, 140), (42, 104, 152), (40, 124, 156), (44, 144, 154), (58, 162, 146),
        (84, 178, 134), (116, 192, 118), (150, 204, 102), (184, 212, 92), (216, 216, 92), (240, 218, 104),
    ],
    dtype=np.uint8,
)  # fmt: skip


#: The clip box for another world covers all of its x and y.
_WHOLE_WORLD = {row.name: row.initial for row in MAP_3D if row.name.startswith(("cut_x", "cut_y"))}
_AT_FIRST = VolumeParameters().look


class VolumeView(Part, Volumetric, DepthSensing):
    """The 3D map of a simulation. The ``map3d`` command begins and ends it.

    Faces of voxels are computed only while a 3D view requests them.
    """

    commands = (Map3dCommand, VoxelCommand, VoxelRayCommand)
    subject = "map_3d"
    is_on = False

    def __init__(self, host: ModelHost, mapper: LiveMap, playback: Playback) -> None:
        self.tables = {"map3d": rows_of(MAP_3D)}
        self._host, self._mapper, self._playback = host, mapper, playback
        self._map: LabVolume | None = None
        self._surface: LabSurface | None = None  #: while it is shown instead of the voxels
        self._only = GridLayer("only_in_3d", "Only in the 3D map", "only_in_3d")
        self._faces = VoxelFaces()
        self._chosen = ChosenVoxel()
        self._questions = VoxelQuestions(host, self._chosen)
        self._dirty: set[ChunkKey] = set()
        self._is_drawn = False  #: whether a 3D view has requested drawings since the last tick
        self._voxels: dict[ChunkKey, np.ndarray] = {}
        self._palette = PALETTE  #: of these
        self._since = 0  #: scans since the last projection
        self._memory: dict[str, int] = {}
        self._memory_at = -1  #: number of scans in the map when memory was last counted
        self._missing = 0
        self.projection: OccupancyGrid | None = None  #: map from above, replaced when it changes; None while it is off

    @property
    def is_asked(self) -> bool:
        """Whether a click in the 3D view queries a voxel; otherwise it places the robot."""
        return self._map is not None and self._map.parameters.values["click"] == "asks_a_voxel"

    @property
    def answering(self) -> str:
        """Whether the answer about a voxel is being computed."""
        is_busy = self._questions.is_busy or (self._surface is not None and self._surface.surface.is_busy)
        return "voxel" if is_busy else ""

    @property
    def hint(self) -> str:
        """Effect of a click: it queries a voxel, or places the robot."""
        return "Click a voxel to ask about it." if self.is_asked else ""

    @property
    def count(self) -> int:
        """Number of recorded scans; 0 while it is off."""
        return 0 if self._map is None else len(self._map.scans)

    @property
    def truth(self) -> str | None:
        """The simulated world, which defines the ground points."""
        return "the true world"

    def points(self) -> Float64Array:
        """Return the points of the scans (n, 3)."""
        return points_of(() if self._map is None else self._map.scans)

    def read(self) -> tuple[Float64Array, tuple[float, float, float, float], BoolArray | None]:
        """Return the points of the scans (n, 3), the world's bounds, and which points are on its floor and ramps."""
        world = self._mapper.simulation.world
        points = self.points()
        return points, world.bounds, true_ground(world, points)

    @property
    def is_behind(self) -> bool:
        """Whether recorded scans are not yet in the map or the displayed surface."""
        if self._surface is not None and self._surface.is_behind:
            return True
        return self._map is not None and self._map.is_behind

    @property
    def progress(self) -> float | None:
        """Share of the recorded scans in the map, or in the displayed surface; None once all are."""
        if self._map is None or not self.is_behind:
            return None
        used = self._map.used if self._surface is None else min(self._map.used, self._surface.index)
        return used / len(self._map.scans)

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Layers of the 3D map; none while it is off."""
        return () if self._map is None else (self._only,)

    @property
    def cells(self) -> int:
        """Number of 4-byte values that it uses."""
        surface = 0 if self._surface is None else self._surface.surface.cells
        return surface + (0 if self._map is None else 512 * self._map.volume.blocks.count)

    # -- commands -------------------------------------------------------------------------------------------------

    def handle(self, command: Map3dCommand | VoxelCommand | VoxelRayCommand, result: TickResult) -> None:
        """Begin the 3D map, change it, end it, or explain a voxel.

        Raises :class:`ConfigError`; nothing has changed then.
        """
        result.changed = True
        if not isinstance(command, Map3dCommand):
            lab = self._made()
            if self._surface is not None:
                self._surface.surface.ask(command, self._host, self._chosen, result)
                return
            self._questions.handle(command, lab, lambda: self._rule(lab), result)
            return
        if not command.value:
            self.end(result)
            return
        before = VolumeParameters() if self._map is None else self._map.parameters
        parameters = before.with_values(command.values)
        if self._map is None:
            self._map, self.is_on = LabVolume(self._mapper.simulation.world, self._mapper.seed, parameters), True
            self._start_again()
        elif self._map.change(parameters):
            self._choose_none(self._map, result)
            self._start_again()
        elif parameters.values["colour"] != before.values["colour"]:
            self._dirty.update(chunks_of(self._map.volume), self._faces.chunks)
        else:
            self._dirty.update(chunks_between(self._map.volume, before.look, parameters.look))
        self._show_kind(self._map, result)
        self._since = SCANS_OF_PROJECTION
        result.slot(self.message())

    def _show_kind(self, lab: LabVolume, result: TickResult) -> None:
        """Begin, change or end the surface according to the parameters."""
        if not lab.parameters.is_surface:
            if self._surface is not None:
                self._choose_none(lab, result)
                self._surface = None
            return
        if self._surface is None:
            self._choose_none(lab, result)
            self._surface = LabSurface(lab, self._host.limits)
        elif self._surface.change(lab.parameters):
            self._choose_none(lab, result)
        result.slot(self._surface.message())

    def _made(self) -> LabVolume:
        if self._map is None:
            raise ConfigError("map3d.off", "There is no 3D map: begin one first.")
        return self._map

    def question(self, origin: Point, direction: Point) -> VoxelRayCommand:
        """Return the command that queries the voxel that a line of sight meets."""
        return VoxelRayCommand(origin, direction)

    def met(self, origin: Point, direction: Point) -> tuple[Point, float] | None:
        """Return where a line of sight meets the displayed surface or voxels."""
        lab = self._made()
        if self._surface is not None:
            return self._surface.surface.met(origin, direction)
        return place_met(lab, self._rule(lab), (np.array(origin), np.array(direction)), None)

    def clipped(self, handle: str, position: Point) -> Map3dCommand | None:
        """Return the command that moves a face of the clip box with its handle."""
        lab = self._made()
        values = self._clip_box(lab).moved(lab.parameters.look, handle, position)
        return None if values is None else Map3dCommand(values=values)

    @staticmethod
    def _clip_box(lab: LabVolume) -> ClipBox:
        x0, y0, x1, y1 = lab.world.bounds
        return ClipBox(np.array([x0, y0, LOWEST]), np.array([x1, y1, HIGHEST]))

    def newest_depths(self) -> tuple[Float32Array, float] | None:
        """Return the newest image of the 3D sensor, if it is a depth camera."""
        scan = self._map.scans[-1] if self._map is not None and self._map.scans else None
        image = None if scan is None else scan.depth_image()
        return None if scan is None or image is None else (image.depth, scan.sensor.reach)

    def octree_bytes(self, kind: str) -> bytes:
        """Return the map as a ``.bt`` or ``.ot`` file. Raises :class:`ConfigError` if there is none."""
        lab = self._made()
        return octree_file(Octree.of(lab.volume), kind, lab.config).bytes(lab.config)

    def mesh_bytes(self, kind: str) -> bytes:
        """Return the outside of the occupied voxels, or the surface if that is shown, as a ``.ply`` or ``.glb`` file.

        Raises like :meth:`octree_bytes`.
        """
        lab = self._made()
        if self._surface is not None:
            return self._surface.surface.file(kind, self._surface.index)
        mesh = voxel_mesh(lab.volume)
        return ply_bytes(mesh) if kind == ".ply" else glb_bytes(mesh)

    def selection_bytes(self) -> bytes:
        """Return the centres of the drawn voxels as a ``.ply`` file. Raises like :meth:`octree_bytes`."""
        lab = self._made()
        centres = centres_of(lab.volume.voxels(float(lab.config.log_odds_occupied))[0], lab.config.resolution)
        return points_ply(centres[lab.parameters.look.shows(centres)], {}, np.zeros(3))

    @property
    def above(self) -> OccupancyGrid | None:
        """The map from above, of the band of heights."""
        return self.projection

    def end(self, result: TickResult) -> None:
        """Discard the 3D map."""
        if self._map is not None:
            self._choose_none(self._map, result)
            self._map = self._surface = self.projection = None
            self.is_on = False
            self._start_again()
            result.slot(self.message())

    def note(self, command: Struct, result: TickResult) -> None:
        """Begin an empty map if the world changes."""
        if self._map is not None and isinstance(command, WorldCommand | RestartCommand):
            self._choose_none(self._map, result)
            parameters = self._map.parameters
            if isinstance(command, WorldCommand):
                parameters = parameters.with_values(_WHOLE_WORLD)
            self._map = LabVolume(self._mapper.simulation.world, self._mapper.seed, parameters)
            self._start_again()
            self._surface = None
            self._show_kind(self._map, result)
            self._since = SCANS_OF_PROJECTION
            result.slot(self.message())

    def _choose_none(self, lab: LabVolume, result: TickResult) -> None:
        if self._chosen.drawings:
            self._questions.clear(lab.config.resolution, result)
            if self._surface is not None:
                result.slot(self._surface.surface.no_voxel())

    def _start_again(self) -> None:
        self._faces.clear()
        self._voxels = {}
        self._dirty.clear()
        self._memory, self._memory_at, self._missing = {}, -1, 0

    # -- computing ------------------------------------------------------------------------------------------------

    def changed(self, result: TickResult) -> None:
        """Record a scan if one is due, integrate scans into the map, and update the display."""
        lab = self._map
        if lab is None:
            return
        mapper, problem = self._mapper, lab.problem
        simulation = mapper.simulation
        if not mapper.hidden:
            lab.look(simulation.world, simulation.robot.pose, mapper.believed_now, simulation.time)
        for slots in lab.catch_up(self._host.limits()):
            self._dirty.update(chunks_of(lab.volume, slots))
            self._since += 1
        if lab.problem is not None and problem is None:
            result.notice(lab.problem.code, lab.problem.message)
        if self._since >= SCANS_OF_PROJECTION and not lab.is_behind:
            self._since = 0
            self._project(lab)
            result.changed = True
            result.slot(self.message())
        if self._surface is not None:
            self._make_surface(self._surface, result)
        elif self._is_drawn and self._dirty:
            self._make_faces(lab)
        self._is_drawn = False

    def _make_surface(self, surface: LabSurface, result: TickResult) -> None:
        has_news = surface.catch_up()
        if self._is_drawn and surface.is_unmeshed:
            surface.mesh()
            has_news = True
        if has_news:
            result.changed = True
            result.slot(surface.message())

    def _project(self, lab: LabVolume) -> None:
        self.projection = lab.projection()
        states, self._missing = only_in_3d(self.projection, self._mapper.grid)
        self._only.set_bytes(self.projection.geometry, states)
        if lab.used < self._memory_at or lab.used - self._memory_at >= SCANS_OF_MEMORY or self._memory_at < 0:
            self._memory, self._memory_at = lab.memory(), lab.used

    def _rule(self, lab: LabVolume) -> FaceRule:
        """Return which faces of voxels are drawn."""
        look = lab.parameters.look
        return face_rule(
            lab.volume, look.low, look.high, base=0.0, band=HIGHEST / BANDS, colours=BANDS,
            by_belief=lab.parameters.values["colour"] == "belief",
        )  # fmt: skip

    def _make_faces(self, lab: LabVolume) -> None:
        dirty, self._dirty = self._dirty, set()
        by_normal = lab.parameters.values["colour"] == "normal"
        painted: Painted | None = None
        if by_normal:
            parts = (painted_directions(lab.volume, key) for key in dirty)
            painted = {key: directions for part in parts for key, directions in part.items()}
        if self._faces.update(lab.volume, self._rule(lab), dirty, painted=painted):
            self._voxels = dict(self._faces.chunks)
        self._palette = NORMAL_COLOURS if by_normal else PALETTE  # changes with the chunks

    # -- display --------------------------------------------------------------------------------------------------

    def messages(self) -> list[Map3dMessage | SurfaceMessage]:
        """Return the ``map3d`` message, and ``surface`` while the surface is shown."""
        return [self.message(), *([] if self._surface is None else [self._surface.message()])]

    def message(self) -> Map3dMessage:
        """Return the ``map3d`` message."""
        lab = self._map
        nothing = {"known": 0, "nodes": 0, "leaves": 0, "octree_bytes": 0, "block_bytes": 0, "dense_bytes": 0}
        return Map3dMessage(
            is_on=lab is not None,
            values=dict((VolumeParameters() if lab is None else lab.parameters).values),
            scans=0 if lab is None else lab.used,
            taken=0 if lab is None else len(lab.scans),
            only_in_3d=self._missing,
            problem=None if lab is None or lab.problem is None else lab.problem.message,
            **(self._memory or nothing),
        )

    def over(self, flat: list[Drawing]) -> list[Drawing]:
        """Return the voxels, the newest scan, and the robot from ``flat`` (event loop, between two ticks)."""
        lab = self._map
        if lab is None:
            return flat
        self._is_drawn = True
        surface = self._surface
        if (self._dirty if surface is None else surface.is_unmeshed) and not self._playback.playing:
            self._host.enqueue(Map3dCommand())  # otherwise no tick would compute the faces
        size, look = lab.parameters.config.resolution, lab.parameters.look
        drawings = [value for value in flat if not isinstance(value, GridColumns)]
        drawings.append(
            Voxels(name="map3d", label="3D map", chunks=self._voxels, palette=self._palette, size=size, corner=CENTRE)
            if surface is None
            else surface.drawing(look)
        )
        if (look.low, look.high, look.cut_handles) != (_AT_FIRST.low, _AT_FIRST.high, _AT_FIRST.cut_handles):
            drawings += self._clip_box(lab).drawings(look)
        if lab.scans:
            scan = lab.scans[-1]
            points = scan.ends()[0][np.isfinite(scan.ranges)]
            some = points[sample_rows(len(points), MOST_POINTS)].astype(np.float32)
            drawings.append(Points(name="scan3d", label="3D scan", points=some, colors=POINT, size=0.04))
        return [*drawings, *self._chosen.drawings]


def part_of(offers: Offers) -> VolumeView | None:
    """Return the part for a simulation, which offers its points and its map from above."""
    if offers.simulation is None:
        return None
    view = VolumeView(offers.host, offers.simulation, offers.playback)
    offers.cloud = view
    offers.maps["map_3d"] = OtherMap("the 3D map from above, while there is one", lambda: view.projection)
    return view
