"""A loaded Nav2 parameter file of which some parameters are changed. Everything else in it is preserved."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from mapper.costmap.footprint import Footprint
from mapper.costmap.nav2.costmap import ContainerConfig, LayerConfig, NamedLayer, Nav2Costmap
from mapper.costmap.nav2.filters import NamedFilter, filter_nodes
from mapper.costmap.nav2.reading import DEFAULT_LAYERS, costmap_of
from mapper.costmap.nav2.writing import nav2_yaml
from mapper.costmap.parameters import (
    DecayConfig,
    GivenConfig,
    InflationConfig,
    ObstacleConfig,
    SourceConfig,
    StaticConfig,
)
from mapper.io.nav2_declared import COSTMAP, RENAMED
from mapper.io.ros_parameters import find_node, with_node
from mapper.planning.nav2_parameters import CONTROLLER, Nav2Path, nav2_path_yaml, path_of
from mapper.planning.nav2_parameters import NODE as PLANNER

#: Parameters of the table, by the table's name of their layer.
PARAMETERS: Mapping[str, Sequence[str]] = {
    "obstacle_layer": ("clearing", "obstacle_max_range"),
    "dynamic_layer": ("lifetime",),
    "inflation_layer": ("inflation_radius", "cost_scaling_factor"),
}
CLEARED_BEYOND_M = 0.5  #: distance by which beams clear farther than they mark, as in Nav2's defaults
_OF_FILTERS = {"keepout": "keepout_filter", "speed": "speed_filter"}


def table_name(config: LayerConfig) -> str | None:
    """Return the table's name of layers with such parameters; None if the table has no such layer."""
    kinds: tuple[tuple[type, str], ...] = (
        (StaticConfig, "static_layer"),
        (DecayConfig, "dynamic_layer"),
        (ObstacleConfig, "obstacle_layer"),
        (GivenConfig, "terrain_layer"),
        (InflationConfig, "inflation_layer"),
    )
    return next((name for kind, name in kinds if isinstance(config, kind)), None)


def source_of_scans(config: ObstacleConfig) -> SourceConfig | None:
    """Return the parameters of the first source that uses a lidar's scans; None if there is none."""
    names = config.sources_of_scans()
    return config.source(names[0]) if names else None


class _Plain(yaml.SafeDumper):
    """Writes a repeated value in full each time, because the parameter reader of ROS 2 rejects aliases."""

    def ignore_aliases(self, data: object) -> bool:
        del data
        return True


@dataclass(frozen=True, slots=True)
class Nav2File:
    """A parameter file's mapping ``root``, and the costmap that it describes."""

    root: Mapping[str, Any]
    costmap: Nav2Costmap

    def changed(self, changes: Mapping[str, Any], footprint: Footprint | None) -> Nav2File:
        """Return the file with other values of the table, by their names there, and another footprint if one is given.

        A layer that is switched on and missing in the file is added. Raises :class:`ConfigError` for a value that the
        file cannot hold.
        """
        parameters = self._parameters()
        if "track_unknown_space" in changes:
            parameters["track_unknown_space"] = changes["track_unknown_space"]
        if footprint is not None:
            parameters["footprint"] = str([list(vertex) for vertex in footprint.vertices])
        kinds = set()
        for layer, block in _blocks(self.costmap, parameters):
            kind = table_name(layer.config)
            if kind is not None:
                kinds.add(kind)
                _change(layer.config, kind, block, changes)
        for filter_, block in _filter_blocks(self.costmap, parameters):
            if _OF_FILTERS.get(filter_.kind) in changes:
                block["enabled"] = changes[_OF_FILTERS[filter_.kind]]
        for kind, config in (("static_layer", StaticConfig()), ("obstacle_layer", ObstacleConfig()),
                             ("terrain_layer", GivenConfig()), ("inflation_layer", InflationConfig())):  # fmt: skip
            if changes.get(kind) is True and kind not in kinds:
                self._add(parameters, kind, config, changes)
        return self._with(parameters)

    def yaml(self, filters: Sequence[NamedFilter], path: Nav2Path) -> str:
        """Return the file, including painted ``filters``, and the planner and the follower if they were changed."""
        parameters = self._parameters()
        servers: dict[str, Any] = {}
        for filter_ in filters:
            name = filter_.name if filter_.name not in parameters else f"painted_{filter_.name}"
            parameters["filters"] = [*(parameters.get("filters") or ()), name]
            parameters[name], nodes = filter_nodes(filter_, name)
            servers |= nodes
        root = {**self._with(parameters).root} | servers
        before, nodes = path_of(dict(self.root)), yaml.safe_load(nav2_path_yaml(path))
        changed = {PLANNER: path.planner != before.planner, CONTROLLER: path.pursuit != before.pursuit}
        for name, has_changed in changed.items():
            if has_changed:
                root = with_node(root, name, nodes[name]["ros__parameters"], (name,))
        return yaml.dump(root, Dumper=_Plain, sort_keys=False, default_flow_style=None)

    def _parameters(self) -> dict[str, Any]:
        """Return a copy of the costmap's parameters, with a nested mapping for each dot in their names."""
        node = find_node(self.root, (self.costmap.node,), COSTMAP)
        return {} if node is None else copy.deepcopy(node[1])

    def _with(self, parameters: dict[str, Any]) -> Nav2File:
        node = self.costmap.node
        root = with_node(self.root, node, parameters, (node, node))
        return Nav2File(root, costmap_of(root, node))

    def _add(self, parameters: dict[str, Any], kind: str, config: LayerConfig, changes: Mapping[str, Any]) -> None:
        name = kind if kind not in parameters else f"gridbloom_{kind}"
        alone = Nav2Costmap(self.costmap.node, self.costmap.general, None, (NamedLayer(name, config),))
        node = yaml.safe_load(nav2_yaml(alone, 1.0))[alone.node][alone.node]["ros__parameters"]
        parameters[name] = node[name]
        _change(config, kind, parameters[name], changes)
        inflations = [layer.name for layer in self.costmap.layers if isinstance(layer.config, InflationConfig)]
        types = dict(
            zip(parameters.pop("plugin_names", ()), parameters.pop("plugin_types", ()), strict=True)
        )  # of Eloquent
        types = types or {name: f"nav2_costmap_2d::{plugin}" for name, plugin in DEFAULT_LAYERS.items()}
        plugins = list(parameters.get("plugins", types))
        for named in [plugin for plugin in plugins if plugin in types]:  # these layers are identified only by that list
            parameters[named] = {"plugin": types[named]} | (parameters.get(named) or {})
        places = {"static_layer": 0, "inflation_layer": len(plugins)}
        last = plugins.index(inflations[0]) if inflations else len(plugins)
        plugins.insert(places.get(kind, last), name)
        parameters["plugins"] = plugins


def _blocks(costmap: Nav2Costmap, parameters: dict[str, Any]) -> Iterator[tuple[NamedLayer, dict[str, Any]]]:
    """Yield each layer, including those in containers, with its parameter block, which is created if missing."""
    for layer in costmap.layers:
        block = parameters[layer.name] = parameters.get(layer.name) or {}
        yield layer, block
        if isinstance(layer.config, ContainerConfig):
            yield from _blocks(layer.config.inner, block)


def _filter_blocks(costmap: Nav2Costmap, parameters: dict[str, Any]) -> Iterator[tuple[NamedFilter, dict[str, Any]]]:
    for filter_ in costmap.filters:
        yield filter_, parameters[filter_.name]
    for layer in costmap.layers:
        if isinstance(layer.config, ContainerConfig):
            yield from _filter_blocks(layer.config.inner, parameters[layer.name])


def _change(config: LayerConfig, kind: str, block: dict[str, Any], changes: Mapping[str, Any]) -> None:
    """Write a layer's changes into its block; changes that concern readings go into each of its sources."""
    if kind in changes:
        block["enabled"] = changes[kind]
    values = {name: changes[name] for name in PARAMETERS.get(kind, ()) if name in changes}
    if isinstance(config, ObstacleConfig) and kind == "dynamic_layer":
        values |= {name: changes[name] for name in PARAMETERS["obstacle_layer"] if name in changes}
    of_sources = {name: values.pop(name) for name in PARAMETERS["obstacle_layer"] if name in values}
    block |= values
    if isinstance(config, ObstacleConfig) and of_sources:
        if "obstacle_max_range" in of_sources:
            of_sources["raytrace_max_range"] = of_sources["obstacle_max_range"] + CLEARED_BEYOND_M
        names = str(block.get("observation_sources", "")).split()
        for name in names:
            block[name] = block.get(name) or {}
        for values_of_source in (block[name] for name in names):
            for old, (new, _) in RENAMED.items():
                if new in of_sources:
                    values_of_source.pop(old, None)
            values_of_source.update(of_sources)
