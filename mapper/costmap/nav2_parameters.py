"""Parameters of a costmap as Nav2's yaml has them, read and written.

Source: the Nav2 documentation, Costmap 2D.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, TypeAlias

import yaml

from mapper.core.errors import ConfigError, ReadError
from mapper.core.parameter import Parameter
from mapper.costmap.footprint import Footprint
from mapper.costmap.nav2_filters import NamedFilter, filter_nodes, is_filter, named_filter
from mapper.costmap.parameters import (
    COMBINATIONS,
    COSTMAP_PARAMETERS,
    DECAY_PARAMETERS,
    GIVEN_PARAMETERS,
    INFLATION_PARAMETERS,
    OBSTACLE_PARAMETERS,
    STATIC_PARAMETERS,
    VOXEL_PARAMETERS,
    CostmapConfig,
    DecayConfig,
    GivenConfig,
    InflationConfig,
    ObstacleConfig,
    StaticConfig,
    VoxelConfig,
)
from mapper.io.ros_parameters import find_node, parse_ros_parameters
from mapper.io.untrusted_yaml import load_untrusted

NODES = ("global_costmap", "local_costmap")

LayerConfig: TypeAlias = StaticConfig | ObstacleConfig | VoxelConfig | DecayConfig | GivenConfig | InflationConfig

_PLUGINS: Mapping[str, tuple[type[LayerConfig], tuple[Parameter, ...]]] = {
    "StaticLayer": (StaticConfig, STATIC_PARAMETERS),
    "ObstacleLayer": (ObstacleConfig, OBSTACLE_PARAMETERS),
    "VoxelLayer": (VoxelConfig, VOXEL_PARAMETERS),
    "InflationLayer": (InflationConfig, INFLATION_PARAMETERS),
    "DecayLayer": (DecayConfig, DECAY_PARAMETERS),
    "TerrainLayer": (GivenConfig, GIVEN_PARAMETERS),
}
_OWN = frozenset(("DecayLayer", "TerrainLayer"))  #: layers that Nav2 does not have
#: Parameters of the whole costmap that Nav2's static layer reads.
_OF_STATIC = (
    "trinary_costmap", "lethal_cost_threshold", "inscribed_obstacle_cost_value", "unknown_cost_value", "use_maximum",
)  # fmt: skip
#: Names that Nav2 has and that do not change costs: topics, rates, frames, sizes.
_WITHOUT_EFFECT = frozenset((
    "width", "height", "origin_x", "origin_y", "rolling_window", "update_frequency",
    "publish_frequency", "global_frame", "robot_base_frame", "transform_tolerance", "always_send_full_costmap",
    "map_vis_z", "use_sim_time", "map_topic", "initial_transform_timeout", "subscribe_to_stamped_footprint",
    "footprint_topic", "service_introspection_mode", "introspection_mode", "bond_heartbeat_period", "topic",
    "sensor_frame", "observation_persistence",
    "expected_update_rate", "data_type", "map_subscribe_transient_local", "subscribe_to_updates",
    "restore_cleared_footprint", "tf_filter_tolerance", "publish_voxel_map", "qos_overrides", "transport_type",
))  # fmt: skip
#: Keys that name the parts of a file; they have an effect and are written again.
_STRUCTURE = frozenset(("plugins", "filters", "plugin", "resolution"))
MAX_LAYERS = 20


@dataclass(frozen=True, slots=True)
class NamedLayer:
    """A layer of a parameter file: its name there, and its parameters."""

    name: str
    config: LayerConfig


@dataclass(frozen=True, slots=True)
class Nav2Costmap:
    """A costmap of a Nav2 parameter file.

    ``layers`` are in the order of its plugins, bottom first. ``footprint`` is None for a robot given by its radius.
    ``filters`` are its costmap filters. ``others`` are parameters that change no cost here, by their path below the
    node, which :func:`nav2_yaml` writes again: (name,) of the costmap, (layer, name), (layer, source, name).
    """

    node: str
    general: CostmapConfig
    footprint: Footprint | None
    layers: tuple[NamedLayer, ...]
    filters: tuple[NamedFilter, ...] = ()
    others: Mapping[tuple[str, ...], Any] = field(default_factory=dict)

    @property
    def unused(self) -> tuple[str, ...]:
        """The names of the parameters that change no cost here."""
        return tuple(".".join((self.node, *path)) for path in self.others)

    @property
    def outline(self) -> Footprint:
        """The padded outline of the robot."""
        shape = self.footprint or Footprint.circle(self.general.robot_radius)
        return shape.padded(self.general.footprint_padding)


def parse_nav2_costmap(data: bytes, node: str | None = None) -> Nav2Costmap:
    """Return the costmap in a Nav2 parameter file: that of ``node``, or the global one, else the local one.

    A parameter that the file does not name has Nav2's default. Raises :class:`ReadError` for a file without a costmap
    and :class:`ConfigError`, which names the parameter with its path, for an unknown name or plugin or an impossible
    value.
    """
    return costmap_of(parse_ros_parameters(data), node)


def costmap_of(root: dict[str, Any], node: str | None = None) -> Nav2Costmap:
    """Return the costmap in what :func:`mapper.io.ros_parameters.parse_ros_parameters` returned for a file.

    As :func:`parse_nav2_costmap`, for who reads more than the costmap from the file.
    """
    found = find_node(root, (node,) if node else NODES)
    if found is None:
        wanted = node or " or ".join(NODES)
        raise ReadError("nav2.no_costmap", f"The parameter file has no costmap: no {wanted} with ros__parameters.")
    name, given = found
    names = _names(given, "plugins", name)
    others: dict[tuple[str, ...], Any] = {}
    own = {**given}
    blocks = {key: own.pop(key) for key in names if key in own}
    filters = [named_filter(root, key, own.get(key), f"{name}.{key}", None) for key in _names(given, "filters", name)]
    for key in [key for key, value in own.items() if isinstance(value, dict) and "plugin" in value]:
        del own[key]  # a layer that is described, but not in the list of those in use
    footprint = _footprint(own.pop("footprint", None), name)
    of_static = {key: own.pop(key) for key in _OF_STATIC if key in own}
    general = _config(CostmapConfig(), COSTMAP_PARAMETERS, own, (name,), others)
    layers: list[NamedLayer] = []
    for key in names:
        block = blocks.get(key)
        if not isinstance(block, dict) or not isinstance(block.get("plugin"), str):
            raise ConfigError("nav2.plugin", f"{name}.{key}: The layer has no 'plugin' that says what it is.")
        if is_filter(block):
            filters.append(named_filter(root, key, block, f"{name}.{key}", len(layers)))
            continue
        layers.append(NamedLayer(key, _layer(block, of_static, (name, key), others)))
    return Nav2Costmap(name, general, footprint, tuple(layers), tuple(filters), others)


def nav2_yaml(costmap: Nav2Costmap, resolution: float) -> str:
    """Return a parameter file with a costmap, as :func:`parse_nav2_costmap` reads it; ``resolution`` in m per cell."""
    general: dict[str, Any] = _below(costmap.others, ()) | {
        "resolution": resolution,
        "track_unknown_space": costmap.general.track_unknown_space,
        "footprint_padding": costmap.general.footprint_padding,
    }
    if costmap.footprint is None:
        general["robot_radius"] = costmap.general.robot_radius
    else:
        general["footprint"] = str([list(vertex) for vertex in costmap.footprint.vertices])
    blocks: dict[str, Any] = {}
    for layer in costmap.layers:
        values = {field.name: getattr(layer.config, field.name) for field in fields(layer.config)}
        kind = next(name for name, (config, _) in _PLUGINS.items() if config is type(layer.config))
        package = "gridbloom" if kind in _OWN else "nav2_costmap_2d"
        block: dict[str, Any] = {"plugin": f"{package}::{kind}"} | _below(costmap.others, (layer.name,))
        if isinstance(layer.config, StaticConfig):
            for key in _OF_STATIC:
                value = values.pop(key)
                general[key] = int(value) if key in _WHOLE else value
        if isinstance(layer.config, ObstacleConfig):
            values["combination_method"] = COMBINATIONS.index(layer.config.combination_method)
            source = {key: values.pop(key) for key in _OF_SOURCE}
            block |= _sources(costmap.others, layer.name, source)
        blocks[layer.name] = block | {key: int(value) if key in _WHOLE else value for key, value in values.items()}
    plugins, filters = [layer.name for layer in costmap.layers], []
    servers: dict[str, Any] = {}
    for one in costmap.filters:
        blocks[one.name], nodes = filter_nodes(one)
        servers |= nodes
        if one.below is None:
            filters.append(one.name)
    for one in sorted((one for one in costmap.filters if one.below is not None), key=lambda one: -(one.below or 0)):
        plugins.insert(one.below or 0, one.name)
    parameters = general | {"plugins": plugins} | ({"filters": filters} if filters else {}) | blocks
    root = {costmap.node: {costmap.node: {"ros__parameters": parameters}}} | servers
    return yaml.safe_dump(root, sort_keys=False, default_flow_style=None)


def _below(others: Mapping[tuple[str, ...], Any], path: tuple[str, ...]) -> dict[str, Any]:
    return {one[-1]: value for one, value in others.items() if one[:-1] == path}


def _sources(others: Mapping[tuple[str, ...], Any], layer: str, source: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sources of observations of a layer; the first one has the values of ``source``."""
    names = dict.fromkeys(path[1] for path in others if len(path) == 3 and path[0] == layer)
    blocks = {name: _below(others, (layer, name)) for name in names}
    if not blocks:
        blocks = {"scan": {"topic": "/scan", "data_type": "LaserScan"}}
    next(iter(blocks.values())).update(source)
    return {"observation_sources": " ".join(blocks), **blocks}


_WHOLE = frozenset(("lethal_cost_threshold", "unknown_cost_value", "z_voxels", "mark_threshold", "unknown_threshold"))
_OF_SOURCE = (
    "marking", "clearing", "obstacle_min_range", "obstacle_max_range", "raytrace_min_range", "raytrace_max_range",
    "inf_is_valid",
)  # fmt: skip


def _names(given: Mapping[str, Any], key: str, where: str) -> tuple[str, ...]:
    names = given.get(key, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ConfigError("nav2.plugins", f"{where}.{key} must be a list of names, not {names!r:.80}.")
    if len(names) > MAX_LAYERS or len(set(names)) < len(names):
        raise ConfigError("nav2.plugins", f"{where}.{key} must be at most {MAX_LAYERS} different names.")
    return tuple(names)


def _layer(
    block: Mapping[str, Any], of_static: Mapping[str, Any], path: tuple[str, str], others: dict[tuple[str, ...], Any]
) -> LayerConfig:
    where = ".".join(path)
    kind = str(block["plugin"]).replace("/", "::").split("::")[-1]
    if kind not in _PLUGINS:
        known = ", ".join(_PLUGINS)
        raise ConfigError("nav2.plugin", f"{where}.plugin: {block['plugin']!r:.80} is none of {known}.")
    config, table = _PLUGINS[kind]
    values = {**block}
    if config is StaticConfig:
        values = {**of_static, **values}
    if issubclass(config, ObstacleConfig):
        sources = values.pop("observation_sources", "")
        if not isinstance(sources, str):
            raise ConfigError("nav2.source", f"{where}.observation_sources must be names with spaces between them.")
        blocks = [(source, values.pop(source, {})) for source in sources.split()]
        values.update(_of_source(blocks, path, others))
        # Nav2's own default of a source: what it sees marks, and clears only where the file says so.
        values.setdefault("clearing", False)
        method = values.pop("combination_method", None)
        if method is not None:
            if method not in (0, 1, 2):
                raise ConfigError("nav2.value", f"{where}.combination_method must be 0, 1 or 2, not {method!r:.40}.")
            values["combination_method"] = COMBINATIONS[method]
    made: LayerConfig = _config(config(), table, values, path, others)
    return made


def _of_source(
    blocks: list[tuple[str, Any]], path: tuple[str, str], others: dict[tuple[str, ...], Any]
) -> dict[str, Any]:
    """Return the parameters of the first source of observations; those of further sources have no effect."""
    where = ".".join(path)
    found: dict[str, Any] = {}
    for k, (source, block) in enumerate(blocks):
        if not isinstance(block, dict):
            raise ConfigError("nav2.source", f"{where}.{source} must hold parameters, not {block!r:.40}.")
        known = {name: block[name] for name in block if name not in _WITHOUT_EFFECT}
        unknown = [name for name in known if name not in (*_OF_SOURCE, "min_obstacle_height", "max_obstacle_height")]
        if unknown:
            raise ConfigError("nav2.unknown", f"{where}.{source}: There is no parameter {unknown[0]!r:.80}.")
        if k == 0:
            found = known
        without_effect = block if k else {name: block[name] for name in block if name not in known}
        others.update({(path[1], source, name): value for name, value in without_effect.items()})
    return found


def _config(
    config: Any,  # noqa: ANN401 - one of the configurations
    table: tuple[Parameter, ...],
    given: Mapping[str, Any],
    path: tuple[str, ...],
    others: dict[tuple[str, ...], Any],
) -> Any:  # noqa: ANN401
    where = ".".join(path)
    rows = {row.name: row for row in table}
    values = {}
    for key, value in given.items():
        if key in rows:
            try:
                values[key] = rows[key].check(value)
            except ConfigError as error:
                raise ConfigError("nav2.value", f"{where}.{key}: {error.message}") from error
        elif key in _WITHOUT_EFFECT:
            others[*path[1:], key] = value
        elif key not in _STRUCTURE:
            raise ConfigError("nav2.unknown", f"{where}: There is no parameter {key!r:.80}.")
    return replace(config, **values)


def _footprint(given: object, where: str) -> Footprint | None:
    if given is None or given in ("", "[]"):
        return None
    points: object = given
    if isinstance(given, str):
        try:
            points = load_untrusted(given[:10_000])
        except yaml.YAMLError as error:
            raise ConfigError("nav2.footprint", f"{where}.footprint: {given!r:.80} is no list of points.") from error
    if not isinstance(points, list):
        raise ConfigError("nav2.footprint", f"{where}.footprint: {given!r:.80} is no list of points.")
    try:
        return Footprint(tuple(tuple(point) for point in points))
    except (ConfigError, TypeError) as error:
        message = error.message if isinstance(error, ConfigError) else "Each point must be [x, y]."
        raise ConfigError("nav2.footprint", f"{where}.footprint: {message}") from error
