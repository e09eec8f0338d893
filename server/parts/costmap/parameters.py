"""The parameters of the costmap, the planner and the follower: rows of their tables, in one table with flat names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter, check_names
from mapper.costmap.footprint import Footprint
from mapper.costmap.nav2.costmap import ContainerConfig, LayerConfig, NamedLayer, Nav2Costmap, SkippedLayer
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
from mapper.planning.nav2_parameters import Nav2Path
from mapper.planning.parameters import PLANNER_PARAMETERS, PURSUIT_PARAMETERS, PlannerConfig, PursuitConfig
from mapper.simulation.robot import HEXAGON
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
OF_THE_FOLLOWER = ("desired_linear_vel", "lookahead_dist")  #: without effect where nothing drives

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
    """Return the table for pages, without some rows, and with ``maps`` for the static layer: their titles by name."""
    *most, last = maps.values()
    sentence = f"Which map the static layer has: {', '.join(most)} or {last}." if most else f"The map: {last}."
    rows = [replace(row, choices=(*maps,), sentence=sentence) if row.name == "map" else row for row in TABLE]
    return rows_of(row for row in rows if row.name not in without)


_ROWS = {row.name: row for row in TABLE}
INITIAL: Mapping[str, Any] = {row.name: row.initial for row in TABLE}

MOST_CORNERS = 24  #: of a footprint here
_OF_PLANNER, _OF_PURSUIT = ("use_astar", "allow_unknown", "tolerance"), OF_THE_FOLLOWER
_CLEARED_BEYOND_M = 0.5  #: how much farther beams clear than they mark, as Nav2's defaults have it


@dataclass(frozen=True, slots=True)
class CostmapParameters:
    """The present values and the outline of the robot. Raises :class:`ConfigError` for what the tables refuse.

    ``others`` are what a Nav2 file that was loaded has besides, as :class:`mapper.costmap.nav2.reading.Nav2Costmap`
    has them, with the table's names of its layers, and ``skipped`` the layers that are not built. ``loaded_path`` is
    the planner and the follower of that file: of their parameters those that the table lacks.
    """

    values: Mapping[str, Any] = field(default_factory=lambda: dict(INITIAL))
    footprint: Footprint = field(default_factory=lambda: Footprint(HEXAGON))
    others: Mapping[tuple[str, ...], Any] = field(default_factory=dict)
    skipped: tuple[SkippedLayer, ...] = ()
    loaded_path: Nav2Path = field(default_factory=Nav2Path)

    def with_values(self, values: Mapping[str, Any]) -> CostmapParameters:
        """Return the parameters with other values; the rest stays."""
        check_names(values, TABLE, "navigation parameter")
        return replace(self, values={**self.values, **{name: _ROWS[name].check(v) for name, v in values.items()}})

    def is_on(self, layer: str) -> bool:
        """Whether a layer is used."""
        return bool(self.values[layer])

    @property
    def general(self) -> CostmapConfig:
        """Parameters of the whole costmap."""
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

    @property
    def obstacle(self) -> ObstacleConfig:
        """Parameters of the obstacle layer."""
        farthest = self.values["obstacle_max_range"]
        return ObstacleConfig(
            clearing=self.values["clearing"],
            obstacle_max_range=farthest,
            raytrace_max_range=farthest + _CLEARED_BEYOND_M,
            inf_is_valid=True,
        )

    @property
    def dynamic(self) -> DecayConfig:
        """Parameters of the layer of obstacles with a lifetime."""
        return DecayConfig(**asdict(self.obstacle), lifetime=self.values["lifetime"])

    @property
    def inflation(self) -> InflationConfig:
        """Parameters of the inflation layer."""
        return InflationConfig(
            inflation_radius=self.values["inflation_radius"], cost_scaling_factor=self.values["cost_scaling_factor"]
        )

    @property
    def planner(self) -> PlannerConfig:
        """Parameters of the planner."""
        return replace(
            self.loaded_path.planner,
            **{name: self.values[name] for name in _OF_PLANNER},
        )

    @property
    def pursuit(self) -> PursuitConfig:
        """Parameters of the follower of the path."""
        return replace(
            self.loaded_path.pursuit,
            **{name: self.values[name] for name in _OF_PURSUIT},
        )

    @property
    def path(self) -> Nav2Path:
        """Planner and follower as Nav2's parameters have them."""
        return replace(self.loaded_path, planner=self.planner, pursuit=self.pursuit)

    @property
    def has_more(self) -> bool:
        """Whether a Nav2 file was loaded that has more than the table: other parameters, or other names."""
        first, path = CostmapParameters().path, self.path
        planner = replace(first.planner, **{name: getattr(path.planner, name) for name in _OF_PLANNER})
        pursuit = replace(first.pursuit, **{name: getattr(path.pursuit, name) for name in _OF_PURSUIT})
        return bool(self.others or self.skipped) or path != replace(first, planner=planner, pursuit=pursuit)

    @property
    def nav2(self) -> Nav2Costmap:
        """The costmap as Nav2's parameters have it: without the dynamic layer and the painted zones."""
        configs: dict[str, LayerConfig] = {
            "static_layer": StaticConfig(),
            "obstacle_layer": self.obstacle,
            "terrain_layer": GivenConfig(),
            "inflation_layer": self.inflation,
        }
        layers = tuple(NamedLayer(name, config) for name, config in configs.items() if self.is_on(name))
        return Nav2Costmap(
            "global_costmap", self.general, self.footprint, layers, others=self.others, skipped=self.skipped
        )


def footprint_of(corners: Sequence[Sequence[float]]) -> Footprint:
    """Return the footprint with these corners [x, y], metres.

    Raises :class:`ConfigError` for one that is impossible, or is so with its padding.
    """
    if len(corners) > MOST_CORNERS:
        raise ConfigError("footprint.vertices", f"A footprint has at most {MOST_CORNERS} corners here.")
    footprint = Footprint(tuple((x, y) for x, y in corners))
    footprint.padded(CostmapConfig().footprint_padding)
    return footprint


def _as_one_list(found: Nav2Costmap, others: dict[tuple[str, ...], Any]) -> Iterator[NamedLayer]:
    """Yield the layers, those of containers in their places; what the latter have besides is put into ``others``."""
    for layer in found.layers:
        config = layer.config
        if isinstance(config, ContainerConfig):
            others |= {path: value for path, value in config.inner.others.items() if len(path) > 1}
            for one in _as_one_list(config.inner, others):
                is_on = config.enabled and one.config.enabled
                yield replace(one, config=replace(one.config, enabled=is_on))
        else:
            yield layer


def from_nav2(before: CostmapParameters, found: Nav2Costmap, path: Nav2Path) -> CostmapParameters:
    """Return the parameters of a Nav2 parameter file, of others those ``before``.

    The table has one layer of each kind: those of containers are taken as if they stood in the list of plugins. Of its
    filters only their kind and whether they are on is taken: their masks are other files.

    Raises :class:`ConfigError` for a value beyond the bounds of the table.
    """
    values: dict[str, Any] = {"track_unknown_space": found.general.track_unknown_space}
    named: dict[str, str] = {}  # the file's names of the layers, and the table's
    values |= dict.fromkeys(IN_NAV2, False)
    others: dict[tuple[str, ...], Any] = {**found.others}
    for layer in _as_one_list(found, others):
        config = layer.config
        if isinstance(config, StaticConfig):
            named[layer.name] = "static_layer"
            values["static_layer"] = config.enabled
        elif isinstance(config, GivenConfig):
            named[layer.name] = "terrain_layer"
            values["terrain_layer"] = config.enabled
        elif isinstance(config, InflationConfig):
            named[layer.name] = "inflation_layer"
            values |= {
                "inflation_layer": config.enabled,
                "inflation_radius": config.inflation_radius,
                "cost_scaling_factor": config.cost_scaling_factor,
            }
        elif isinstance(config, ObstacleConfig):
            named[layer.name] = "obstacle_layer"
            values |= {
                "obstacle_layer": config.enabled,
                "clearing": config.clearing,
                "obstacle_max_range": config.obstacle_max_range,
            }
    for one in found.filters:
        if one.kind == "speed":
            kind = "absolute" if one.type == ABSOLUTE else "percentage"
            values |= {"speed_filter": one.enabled, "speed_limits": kind}
        elif one.kind == "keepout":
            values["keepout_filter"] = one.enabled
    values |= {name: getattr(path.planner, name) for name in _OF_PLANNER}
    values |= {name: getattr(path.pursuit, name) for name in _OF_PURSUIT}
    footprint = found.footprint or Footprint.circle(found.general.robot_radius)
    others = {(named.get(path[0], path[0]), *path[1:]): value for path, value in others.items()}
    loaded = replace(before.with_values(values), footprint=footprint, others=others, loaded_path=path)
    return replace(loaded, skipped=found.skipped)
