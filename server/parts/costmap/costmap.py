"""The layers of costs over a map. They follow the map, the scans and what a visitor paints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mapper.core.array_types import Float64Array, Int8Array, UInt8Array
from mapper.core.errors import MapperError
from mapper.costmap import (
    NO_INFORMATION,
    CellReason,
    GivenLayer,
    InflationLayer,
    KeepoutLayer,
    Mask,
    SpeedFilter,
    SpeedLimit,
)
from mapper.costmap.build import ObservedLayer, build_costmap
from mapper.costmap.layers import Layer as CostLayer
from mapper.costmap.layers import observation_of_scan, part_of
from mapper.costmap.nav2.filters import NamedFilter
from mapper.costmap.parameters import InflationConfig
from mapper.grid import CellBox, GridGeometry, OccupancyGrid
from mapper.io.costmaps import RecordedCostmap
from mapper.planning.parameters import PlannerConfig, PursuitConfig
from mapper.sensors.scan import RangeScan
from mapper.simulation.robot import PoseTuple
from server.parts.costmap.nav2_file import table_name
from server.parts.costmap.parameters import LAYERS, CostmapParameters
from server.parts.costmap.zones import SpeedZones, Stroke
from server.sessions.part import StaticMap
from server.sessions.parts import LayerCosts
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer

_ZONES = "map_keepout"  #: name of the keepout zones of a loaded map


class Costmap:
    """Layers of costs over the map of a session, or over a plan. Each is a grid of the session.

    :meth:`follow` applies changes of the map, :meth:`look` a scan, :meth:`change` other parameters and :meth:`paint`
    the keepout zones; :meth:`update` brings the costs up to date.
    """

    def __init__(
        self, grid: OccupancyGrid, plan: Callable[[str], StaticMap | None], parameters: CostmapParameters
    ) -> None:
        """Create layers over ``grid``, or over the plan that ``plan`` returns for the parameter ``map``, if any."""
        self.revision = 0  #: changes with the costs and the parameters
        self._plan = plan(parameters.values["map"])
        self.parameters = parameters
        self.strokes: tuple[Stroke, ...] = ()
        names = {name: name.partition("_")[0].capitalize() for name in LAYERS}
        self._sheets = {name: GridLayer(name, title, "costs") for name, title in names.items()}
        self._master = GridLayer("costmap", "Costmap", "costs")
        self._limits = GridLayer("speed_filter", "Speed limits", "speed")
        self._terrain: LayerCosts | None = None
        self._shown: dict[str, tuple[GridGeometry, UInt8Array]] = {}
        self.begin(grid)

    def begin(self, grid: OccupancyGrid) -> None:
        """Recreate all layers over the current map. Painted zones are kept."""
        map_ = grid if self._plan is None else self._plan.grid
        self.geometry = map_.geometry
        self._values = map_.classify()
        self._graded = GivenLayer(self.geometry, "terrain_layer", self._why_terrain)
        if self._terrain is not None:
            self._graded.take(self._terrain.costs(), self._terrain.geometry)
        self._keepout = KeepoutLayer(self.geometry)
        given_limits = None if self._plan is None else self._plan.speed
        self._speed = SpeedZones(self.geometry, self.parameters.values["speed_limits"], given_limits)
        self._zones = None
        if self._plan is not None and self._plan.keepout is not None:
            zones = np.where(self._plan.keepout > 0, self._plan.keepout, -1).astype(np.int8)
            self._zones = Mask(self.geometry, zones)
        for stroke in self.strokes:
            self._paint(stroke)
        self._stack(())
        self._show_speed()

    def _stack(self, observed: Sequence[ObservedLayer]) -> None:
        """Stack all layers. Those in ``observed`` keep their marks."""
        parameters = self.parameters
        stack, masks, is_painted = parameters.stack, {}, parameters.is_on("keepout_filter")
        if self._zones is not None and is_painted:
            at = next((k for k, layer in enumerate(stack.layers) if isinstance(layer.config, InflationConfig)), None)
            stack = replace(stack, filters=(NamedFilter(_ZONES, "keepout", _ZONES, below=at),))
            masks[_ZONES] = self._zones
        self._built = build_costmap(
            self.geometry, self._values, stack, parameters.outline, masks,
            self._keepout if is_painted else KeepoutLayer(self.geometry), (*observed, self._graded),
        )  # fmt: skip
        self.costmap = self._built.costmap
        self._own: dict[str, CostLayer | InflationLayer] = {"keepout_filter": self._keepout}
        enabled = sorted(stack.all_layers(), key=lambda layer: not layer.config.enabled)
        for layer in enabled:
            kind = table_name(layer.config)
            if kind is not None:
                self._own.setdefault(kind, self._built.layers[layer.name])

    @property
    def layers(self) -> tuple[Layer, ...]:
        """The costs, the layers' own costs (those of a terrain only if there is one), and the speed limits."""
        sheets = [sheet for name, sheet in self._sheets.items() if name != "terrain_layer" or self._terrain is not None]
        return (self._master, *sheets, self._limits)

    @property
    def cells(self) -> int:
        """Number of cells of its grids."""
        return (20 + 3 * len(self._built.layers)) * self.geometry.rows * self.geometry.cols

    @property
    def blind(self) -> list[str]:
        """The names of the obstacle layers without a source of scans."""
        layers = zip(self._built.observed, self._built.obstacles, strict=True)
        return [name for name, layer in layers if layer.config.sources and not layer.config.sources_of_scans()]

    def with_other_topics(self, topics: Sequence[str]) -> list[str]:
        """Return the names of the obstacle layers whose sources use scans, but none of these topics."""
        layers = zip(self._built.observed, self._built.obstacles, strict=True)
        seeing = [(name, layer.config) for name, layer in layers if layer.config.sources]
        return [name for name, config in seeing if config.sources_of_scans() and not config.has_topic_of(topics)]

    @property
    def costs(self) -> UInt8Array:
        """The costs (rows, cols)."""
        return self.costmap.costs

    @property
    def planner(self) -> PlannerConfig:
        """Parameters of the planner."""
        return self.parameters.planner

    @property
    def pursuit(self) -> PursuitConfig:
        """Parameters of the follower of the path."""
        return self.parameters.pursuit

    @property
    def radius(self) -> float:
        """Circumscribed radius of the padded outline, metres."""
        return self.parameters.outline.circumscribed_radius

    def follow(self, grid: OccupancyGrid, box: CellBox | None, *, whole: bool) -> None:
        """Apply changes of the map: in a box, or in the ``whole`` map."""
        if self._plan is not None or not (whole or box):
            return
        if grid.geometry != self.geometry:
            self.begin(grid)
            return
        if whole or box is None:
            box = CellBox(0, grid.geometry.rows, 0, grid.geometry.cols)
        state = grid.band(slice(box.row0, box.row1)).classify()[:, box.col0 : box.col1]
        self._values[part_of(box)] = state
        for layer in self._built.statics:
            layer.renew(np.ascontiguousarray(state), box)

    def look(
        self, scan: RangeScan, sensor_pose: PoseTuple | Float64Array, topic: str = "", topics: Sequence[str] = ()
    ) -> None:
        """Mark and clear with a scan in the obstacle layers.

        ``topic`` is the topic of the scan, ``topics`` are all topics of scans.
        """
        for layer in self._built.obstacles:
            config = layer.config
            seen = []
            for name in config.sources_of_scans(topic, topics):
                source = config.source(name)
                # The height of the sensor is unknown, so its scans are assumed to be within the observed heights.
                least = max(0.0, source.min_obstacle_height, config.min_obstacle_height)
                height = min(least, source.max_obstacle_height, config.max_obstacle_height)
                observation = observation_of_scan(scan, sensor_pose, inf_is_valid=source.inf_is_valid, height=height)
                seen.append(replace(observation, source=name))
            layer.observe(*seen)

    def lay_terrain(self, terrain: LayerCosts | None) -> None:
        """Use other costs for the terrain layer; None for none."""
        self._terrain = terrain
        if terrain is None:
            self._graded.set(np.full(self.geometry.shape, NO_INFORMATION, dtype=np.uint8))
        else:
            self._graded.take(terrain.costs(), terrain.geometry)

    def _why_terrain(self, row: int, col: int) -> str:
        """Return one sentence about the terrain patch at a cell of the costmap."""
        if self._terrain is None:
            return "There is no terrain: begin it in the group Terrain."
        geometry = self._terrain.geometry
        at_row, at_col = (int(k) for k in geometry.world_to_cell(self.geometry.cell_to_world((row, col))))
        if not geometry.contains((at_row, at_col)):
            return "Terrain: there is no patch here."
        return self._terrain.why(at_row, at_col)

    def renew_plan(self, plan: StaticMap | None, grid: OccupancyGrid) -> None:
        """Use another map instead of the belief."""
        self._plan = plan
        self.begin(grid)

    def change(
        self, parameters: CostmapParameters, grid: OccupancyGrid, plan: Callable[[str], StaticMap | None]
    ) -> None:
        """Use other parameters. If it raises :class:`MapperError`, nothing has changed."""
        before, old_plan, geometry = self.parameters, self._plan, self.geometry
        try:
            self.parameters = parameters
            map_name, unknown = parameters.values["map"], parameters.values["track_unknown_space"]
            if map_name != before.values["map"] or unknown != before.values["track_unknown_space"]:
                if map_name != before.values["map"]:
                    self._plan = plan(map_name)
                self.begin(grid)
                return
            self._stack(self._built.obstacles)
            self._speed.interpret(parameters.values["speed_limits"])
            self._show_speed()
        except MapperError:
            self.parameters, self._plan = before, old_plan
            if self.geometry == geometry:
                self._stack(self._built.obstacles)
            else:
                self.begin(grid)
            raise

    def paint(self, strokes: tuple[Stroke, ...]) -> None:
        """Paint zones. The strokes replace the previous ones; a stroke that only grew is continued."""
        known = len(self.strokes)
        grows = bool(known) and len(strokes) >= known and strokes[: known - 1] == self.strokes[:-1]
        grows = grows and strokes[known - 1].continues(self.strokes[-1])
        if not grows and known:
            self._keepout.clear()
            self._speed.clear()
        for stroke in strokes[known - 1 if grows else 0 :]:
            self._paint(stroke)
        self.strokes = strokes
        self._show_speed()

    def _paint(self, stroke: Stroke) -> None:
        if stroke.speed is None:
            for outline in stroke.outlines():
                self._keepout.paint(outline, -1 if stroke.erases else 100)
        if stroke.erases or stroke.speed is not None:
            self._speed.paint(stroke)

    def _show_speed(self) -> None:
        """Write the mask of the speed limits into its layer."""
        is_on = self.parameters.is_on("speed_filter")
        self._show(self._limits, self._speed.picture if is_on else None)

    def update(self, now: float, pose: PoseTuple) -> bool:
        """Bring the costs up to date at ``now``, s, with the robot at ``pose``; return whether they changed."""
        box = self.costmap.update(now, pose)
        if box is None:
            return False
        for name, sheet in self._sheets.items():
            layer = self._own.get(name)
            costs = None if layer is None or not self.parameters.is_on(name) else layer.costs
            self._show(sheet, costs)
        return self._show(self._master, self.costmap.costs)

    def _show(self, sheet: GridLayer, costs: UInt8Array | None) -> bool:
        """Write the costs into a sheet where they differ from what it shows; None for a layer that is off."""
        costs = np.full(self.geometry.shape, NO_INFORMATION, dtype=np.uint8) if costs is None else costs
        geometry, before = self._shown.get(sheet.name, (None, costs))
        if geometry == self.geometry and np.array_equal(before, costs):
            return False
        self._shown[sheet.name] = (self.geometry, costs.copy())
        sheet.set_bytes(self.geometry, costs)
        return True

    def recorded(self, seconds: float, frame: str | None) -> RecordedCostmap:
        """Return a copy of the costs in the form of a recorded message."""
        stamp_ns = max(round(seconds * 1e9), 0)
        return RecordedCostmap(stamp_ns, stamp_ns, frame or "map", "master", self.geometry, self.costs.copy())

    @property
    def masks(self) -> dict[str, Int8Array]:
        """Copies of the painted masks (rows, cols): ``keepout`` (−1: unpainted) and ``speed`` (0: unpainted)."""
        painted = {"keepout": (self._keepout.mask, -1), "speed": (self._speed.mask, 0)}
        return {name: mask.copy() for name, (mask, none) in painted.items() if (mask > none).any()}

    def speed_limit(self, pose: PoseTuple) -> SpeedLimit | None:
        """Return the speed limit of a robot at ``pose``; None if speed limits are off."""
        return self._speed.at(pose[0], pose[1]) if self.parameters.is_on("speed_filter") else None

    @property
    def speed_filters(self) -> tuple[SpeedFilter, ...]:
        """The speed filter; empty if speed limits are off."""
        return (self._speed.filter,) if self.parameters.is_on("speed_filter") else ()

    def why_speed(self, x: float, y: float) -> str | None:
        """Return one sentence about the speed limit that is painted at (x, y), metres; None if there is none."""
        return self._speed.why(x, y) if self.parameters.is_on("speed_filter") else None

    def why(self, x: float, y: float) -> list[CellReason]:
        """Return what each layer contributes to the cell at (x, y), metres. Raises :class:`ConfigError` if outside."""
        row, col = (int(k) for k in self.geometry.world_to_cell((x, y)))
        return self.costmap.why(row, col)
