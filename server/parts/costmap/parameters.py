"""The parameters of the costmap, the planner and the follower, as one table with flat names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter, check_names
from mapper.costmap.footprint import Footprint
from mapper.costmap.nav2.costmap import LayerConfig, NamedLayer, Nav2Costmap
from mapper.costmap.nav2.filters import NamedFilter
from mapper.costmap.nav2.writing import nav2_yaml
from mapper.costmap.parameters import (
    COSTMAP_PARAMETERS,
    DECAY_PARAMETERS,
    INFLATION_PARAMETERS,
    OBSTACLE_PARAMETERS,
    CostmapConfig,
    DecayConfig,
    GivenConfig,
    InflationConfig,
    ObstacleConfig,
    StaticConfig,
)
from mapper.costmap.speed_filter import ABSOLUTE
from mapper.planning.nav2_parameters import Nav2Path, nav2_path_yaml
from mapper.planning.parameters import PLANNER_PARAMETERS, PURSUIT_PARAMETERS, PlannerConfig, PursuitConfig
from mapper.simulation.robot import HEXAGON
from server.parts.costmap.nav2_file import CLEARED_BEYOND_M, PARAMETERS, Nav2File, source_of_scans, table_name
from server.sessions.parts import FootprintAnswer
from server.stream.message_parts import Parameter as ParameterRow
from server.stream.message_parts import rows_of


def _row(table: tuple[Parameter, ...], name: str, **changes: Any) -> Parameter:  # noqa: ANN401
    return replace(next(row for row in table if row.name == name), **changes)


def _layer(name: str, label: str, sentence: str, *, initial: bool = True) -> Parameter:
    return Parameter(name, label, "layers", "flag", initial, sentence)


SPEED_LIMITS = ("percentage", "absolute")
LAYERS = ("static_layer", "obstacle_layer", "dynamic_layer", "terrain_layer", "keepout_filter", "inflation_layer")
IN_NAV2 = ("static_layer", "obstacle_layer", "terrain_layer", "inflation_layer")  #: layers that a Nav2 file has
MAPS = ("belief", "plan", "map_3d", "terrain", "given")
OF_THE_FOLLOWER = ("desired_linear_vel", "lookahead_dist")  #: without effect if nothing drives

TABLE: tuple[Parameter, ...] = (
    _layer("static_layer", "Static", "The map: its occupied cells are lethal."),
    _layer("obstacle_layer", "Obstacle", "What the scans mark; the beams that pass clear it."),
    _layer("dynamic_layer", "Dynamic", "What the scans mark, for the lifetime of an obstacle."),
    _layer(
        "terrain_layer", "Terrain", "Costs of the patches of the group Terrain, where it is on.", initial=False
    ),
    _layer("keepout_filter", "Keepout", "What you paint: the robot does not go there."),
    _layer("speed_filter", "Speed limits", "Whether painted speed limits slow the robot down."),
    Parameter(
        "speed_limits", "Speed limits are", "layers", "choice", "percentage",
        "Percentage: of the desired linear velocity, type 1 of Nav2’s speed filter. Absolute: m/s, type 2.",
        choices=SPEED_LIMITS,
    ),
    _layer("inflation_layer", "Inflation", "Costs around the obstacles of the layers below."),
    Parameter(
        "map", "Static map", "static", "choice", "belief",
        "Which map the static layer has: the belief as it changes, the plan of the world, the 3D map, the terrain or a "
        "reference map.",
        choices=MAPS,
    ),
    _row(COSTMAP_PARAMETERS, "track_unknown_space", initial=True, group="static"),
    _row(OBSTACLE_PARAMETERS, "clearing", label="Beams clear", sentence="Whether beams clear what they pass."),
    _row(OBSTACLE_PARAMETERS, "obstacle_max_range", initial=5.0, high=20.0),
    _row(DECAY_PARAMETERS, "lifetime", label="Obstacle lifetime", low=0.5, high=60.0, step=0.5),
    _row(INFLATION_PARAMETERS, "inflation_radius", high=3.0),
    _row(INFLATION_PARAMETERS, "cost_scaling_factor", initial=3.0, low=0.1, high=20.0),
    _row(PLANNER_PARAMETERS, "allow_unknown", label="Drive through unknown", initial=False),
    _row(PLANNER_PARAMETERS, "use_astar"),
    _row(PLANNER_PARAMETERS, "tolerance", high=2.0),
    _row(PURSUIT_PARAMETERS, "desired_linear_vel", high=1.0),
    _row(PURSUIT_PARAMETERS, "lookahead_dist", low=0.1, high=3.0),
)  # fmt: skip


def rows_with(maps: Mapping[str, str], without: tuple[str, ...] = ()) -> list[ParameterRow]:
    """Return the table for pages without some rows. ``maps`` are the titles, by name, of the static layer's maps."""
    *most, last = maps.values()
    sentence = f"Which map the static layer has: {', '.join(most)} or {last}." if most else f"The map: {last}."
    rows = [replace(row, choices=(*maps,), sentence=sentence) if row.name == "map" else row for row in TABLE]
    return rows_of(row for row in rows if row.name not in without)


_ROWS = {row.name: row for row in TABLE}
INITIAL: Mapping[str, Any] = {row.name: row.initial for row in TABLE}

MOST_CORNERS = 24  #: maximum for a footprint here
_OF_PLANNER, _OF_PURSUIT = ("use_astar", "allow_unknown", "tolerance"), OF_THE_FOLLOWER
PAGE_ONLY = ("dynamic_layer", "terrain_layer")  #: layers of the page that a loaded file may lack


@dataclass(frozen=True, slots=True)
class LoadedFile:
    """A loaded Nav2 parameter file: ``first`` as loaded and ``now`` with the changes since.

    ``values`` and ``footprint`` are those that loading it set. A value beyond the bounds of the table is shown as the
    nearest allowed one, and keeps the file's value until it is changed. ``path`` has its planner and its follower.
    """

    first: Nav2File
    now: Nav2File
    values: Mapping[str, Any]
    footprint: Footprint
    path: Nav2Path

    def changed(self, values: Mapping[str, Any], footprint: Footprint) -> LoadedFile:
        """Return the file with the current values of the table and the current footprint."""
        changes = {name: value for name, value in values.items() if value != self.values.get(name, value)}
        outline = None if footprint == self.footprint else footprint
        return replace(self, now=self.first.changed(changes, outline) if changes or outline else self.first)


@dataclass(frozen=True, slots=True)
class CostmapParameters:
    """The current values and the outline of the robot. Raises :class:`ConfigError` if the tables reject them.

    ``loaded`` is the loaded Nav2 file, if any. Its layers replace the table's own.
    """

    values: Mapping[str, Any] = field(default_factory=lambda: dict(INITIAL))
    footprint: Footprint = field(default_factory=lambda: Footprint(HEXAGON))
    loaded: LoadedFile | None = None

    def with_values(self, values: Mapping[str, Any], footprint: Footprint | None = None) -> CostmapParameters:
        """Return the parameters with other values, and another footprint if one is given."""
        check_names(values, TABLE, "navigation parameter")
        present = {**self.values, **{name: _ROWS[name].check(v) for name, v in values.items()}}
        outline = footprint or self.footprint
        loaded = None if self.loaded is None else self.loaded.changed(present, outline)
        return CostmapParameters(present, outline, loaded)

    def is_on(self, layer: str) -> bool:
        """Return whether a layer is used."""
        return bool(self.values[layer])

    @property
    def general(self) -> CostmapConfig:
        """Parameters of the whole costmap."""
        if self.loaded is not None:
            return self.loaded.now.costmap.general
        return CostmapConfig(track_unknown_space=self.values["track_unknown_space"])

    @property
    def outline(self) -> Footprint:
        """The padded outline of the robot."""
        return self.footprint.padded(self.general.footprint_padding)

    def footprint_answer(self) -> FootprintAnswer:
        """Return the footprint with both radii of the padded one."""
        outline = self.outline
        return FootprintAnswer(
            [*self.footprint.vertices], round(outline.inscribed_radius, 4), round(outline.circumscribed_radius, 4)
        )

    def _of_readings(self) -> dict[str, Any]:
        """Return the parameters of the layers that use scans."""
        farthest = self.values["obstacle_max_range"]
        return {
            "clearing": self.values["clearing"],
            "obstacle_max_range": farthest,
            "raytrace_max_range": farthest + CLEARED_BEYOND_M,
            "inf_is_valid": True,
        }

    @property
    def _own(self) -> dict[str, LayerConfig]:
        """The table's own layers, bottom first."""
        on = {name: self.is_on(name) for name in LAYERS}
        return {
            "static_layer": StaticConfig(enabled=on["static_layer"]),
            "obstacle_layer": ObstacleConfig(enabled=on["obstacle_layer"], **self._of_readings()),
            "dynamic_layer": DecayConfig(
                enabled=on["dynamic_layer"], **self._of_readings(), lifetime=self.values["lifetime"]
            ),
            "terrain_layer": GivenConfig(enabled=on["terrain_layer"]),
            "inflation_layer": InflationConfig(
                enabled=on["inflation_layer"],
                inflation_radius=self.values["inflation_radius"],
                cost_scaling_factor=self.values["cost_scaling_factor"],
            ),
        }

    @property
    def stack(self) -> Nav2Costmap:
        """The costmap with all layers: those of the loaded file and, below its inflation, those that the file lacks."""
        own = self._own
        if self.loaded is None:
            layers = tuple(NamedLayer(name, config) for name, config in own.items())
            return Nav2Costmap("global_costmap", self.general, self.footprint, layers)
        costmap = self.loaded.now.costmap
        kinds = {table_name(layer.config) for layer in costmap.all_layers()}
        missing = [NamedLayer(name, own[name]) for name in PAGE_ONLY if name not in kinds]
        inflations = [k for k, layer in enumerate(costmap.layers) if isinstance(layer.config, InflationConfig)]
        at = inflations[0] if inflations else len(costmap.layers)
        return replace(costmap, layers=(*costmap.layers[:at], *missing, *costmap.layers[at:]), filters=())

    @property
    def planner(self) -> PlannerConfig:
        """Parameters of the planner."""
        first = PlannerConfig() if self.loaded is None else self.loaded.path.planner
        return replace(first, **self._of_path(_OF_PLANNER))

    @property
    def pursuit(self) -> PursuitConfig:
        """Parameters of the follower of the path."""
        first = PursuitConfig() if self.loaded is None else self.loaded.path.pursuit
        return replace(first, **self._of_path(_OF_PURSUIT))

    def _of_path(self, names: tuple[str, ...]) -> dict[str, Any]:
        """Return the values of some names, except those equal to the loaded file's."""
        loaded = {} if self.loaded is None else self.loaded.values
        return {name: self.values[name] for name in names if loaded.get(name) != self.values[name]}

    def nav2_text(self, filters: tuple[NamedFilter, ...], resolution: float) -> str:
        """Return the parameters as a Nav2 file, with the filters of painted zones. ``resolution`` is in m per cell.

        A loaded file is returned with the changes since. The obstacle layer with a lifetime, which Nav2 does not have,
        is written only if the file already has it.
        """
        loaded = self.loaded
        if loaded is not None:
            return loaded.now.yaml(filters, replace(loaded.path, planner=self.planner, pursuit=self.pursuit))
        layers = tuple(
            NamedLayer(name, config) for name, config in self._own.items() if name in IN_NAV2 and config.enabled
        )
        costmap = Nav2Costmap("global_costmap", self.general, self.footprint, layers, filters)
        return nav2_yaml(costmap, resolution) + nav2_path_yaml(Nav2Path(self.planner, self.pursuit))


def footprint_of(corners: Sequence[Sequence[float]]) -> Footprint:
    """Return the footprint with these corners [x, y], metres, as dragged on a page.

    As in Nav2 it may cross itself. Raises :class:`ConfigError` if it is impossible, with or without its padding.
    """
    if len(corners) > MOST_CORNERS:
        raise ConfigError("footprint.vertices", f"A footprint has at most {MOST_CORNERS} corners here.")
    footprint = Footprint(tuple((x, y) for x, y in corners))
    footprint.padded(CostmapConfig().footprint_padding)
    return footprint


def from_nav2(
    before: CostmapParameters, root: Mapping[str, Any], costmap: Nav2Costmap, path: Nav2Path
) -> tuple[CostmapParameters, list[str]]:
    """Return the parameters of a Nav2 parameter file, and notes. All other parameters are those of ``before``.

    ``costmap`` and ``path`` are the parsed contents of its mapping ``root``. If it has several layers of a kind, the
    table shows the first that is enabled. Of its filters, only the kind and whether they are on are used, because their
    masks are other files.
    """
    values: dict[str, Any] = {"track_unknown_space": costmap.general.track_unknown_space}
    values |= dict.fromkeys(IN_NAV2, False)
    shown = [layer for layer in costmap.all_layers() if table_name(layer.config) is not None]
    paths: dict[str, str] = {}
    for layer in sorted(shown, key=lambda layer: layer.config.enabled):  # the first that is enabled comes last
        kind = table_name(layer.config) or ""
        values[kind] = layer.config.enabled
        of_layer: dict[str, Any] = {}
        where = f"{costmap.node}.{layer.name}"
        if isinstance(layer.config, InflationConfig):
            of_layer = {name: getattr(layer.config, name) for name in PARAMETERS[kind]}
        elif isinstance(layer.config, ObstacleConfig):
            source = source_of_scans(layer.config)
            of_layer = {} if source is None else {name: getattr(source, name) for name in PARAMETERS["obstacle_layer"]}
            if isinstance(layer.config, DecayConfig):
                of_layer["lifetime"] = layer.config.lifetime
        values |= of_layer
        paths |= {name: f"{where}.{name}" for name in of_layer}
    for filter_ in costmap.filters:
        if filter_.kind == "speed":
            kind = "absolute" if filter_.type == ABSOLUTE else "percentage"
            values |= {"speed_filter": filter_.enabled, "speed_limits": kind}
        elif filter_.kind == "keepout":
            values["keepout_filter"] = filter_.enabled
    values |= {name: getattr(path.planner, name) for name in _OF_PLANNER}
    values |= {name: getattr(path.pursuit, name) for name in _OF_PURSUIT}
    paths |= {name: f"planner_server.{path.planner_name}.{name}" for name in _OF_PLANNER}
    paths |= {name: f"controller_server.{path.follower_name}.{name}" for name in _OF_PURSUIT}
    notes = []
    for name, value in values.items():
        row = _ROWS[name]
        if row.kind == "number" and not row.low <= value <= row.high:
            values[name] = min(max(value, row.low), row.high)
            notes.append(
                f"{paths[name]} is {value:g}, and the slider goes from {row.low:g} to {row.high:g}: {value:g} counts "
                "until the slider is moved."
            )
    footprint = costmap.footprint or Footprint.circle(costmap.general.robot_radius)
    file = Nav2File(root, costmap)
    present = replace(before, loaded=None).with_values(values, footprint)
    return replace(present, loaded=LoadedFile(file, file, values, footprint, path)), notes
