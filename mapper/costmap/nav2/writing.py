"""Writing of costmap parameters in Nav2's yaml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

import yaml

from mapper.costmap.nav2.costmap import CONTAINER, OF_SOURCE, OF_STATIC, PLUGINS, ContainerConfig, Nav2Costmap
from mapper.costmap.nav2.filters import filter_nodes
from mapper.costmap.parameters import COMBINATIONS, NamedSource, ObstacleConfig, StaticConfig
from mapper.io.nav2_declared import WHOLE

_OWN = frozenset(("DecayLayer", "TerrainLayer"))  #: layers that Nav2 does not have


def nav2_yaml(costmap: Nav2Costmap, resolution: float) -> str:
    """Return a parameter file with a costmap; ``resolution`` is in m per cell.

    It can be read by :func:`mapper.costmap.nav2.reading.parse_nav2_costmap`.
    """
    general: dict[str, Any] = _below(costmap.others, ()) | {
        "resolution": resolution,
        "track_unknown_space": costmap.general.track_unknown_space,
        "footprint_padding": costmap.general.footprint_padding,
    }
    if costmap.footprint is None:
        general["robot_radius"] = costmap.general.robot_radius
    else:
        general["footprint"] = str([list(vertex) for vertex in costmap.footprint.vertices])
    blocks, servers, of_static = _stack(costmap)
    root = {costmap.node: {costmap.node: {"ros__parameters": general | of_static | blocks}}} | servers
    return yaml.safe_dump(root, sort_keys=False, default_flow_style=None)


def _stack(costmap: Nav2Costmap, within: str = "") -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Return the lists of layers and filters with their blocks, the nodes of filter servers, and global parameters.

    The last are the parameters of the whole costmap that its static layers read. ``within`` is the prefix of the
    servers' names.
    """
    blocks: dict[str, Any] = {}
    servers: dict[str, Any] = {}
    of_static: dict[str, Any] = {}
    for layer in costmap.layers:
        config = layer.config
        values = {field.name: getattr(config, field.name) for field in fields(config)}
        kind = next((name for name, (kind, _) in PLUGINS.items() if kind is type(config)), CONTAINER)
        package = "gridbloom" if kind in _OWN else "nav2_costmap_2d"
        block: dict[str, Any] = {"plugin": f"{package}::{kind}"} | _below(costmap.others, (layer.name,))
        if isinstance(config, StaticConfig):
            for key in OF_STATIC:
                value = values.pop(key)
                of_static[key] = int(value) if key in WHOLE else value
        if isinstance(config, ObstacleConfig | ContainerConfig):
            values["combination_method"] = COMBINATIONS.index(config.combination_method)
        if isinstance(config, ObstacleConfig):
            block |= _sources(costmap.others, layer.name, config)
            values = {key: value for key, value in values.items() if key not in OF_SOURCE and key != "sources"}
        block |= {key: int(value) if key in WHOLE else value for key, value in values.items() if key != "inner"}
        if isinstance(config, ContainerConfig):
            inner, of_filters, of_inner = _stack(config.inner, f"{within}{layer.name}_")
            block |= _below(config.inner.others, ()) | inner
            servers |= of_filters
            of_static |= of_inner
        blocks[layer.name] = block
    plugins = [layer.name for layer in costmap.layers]
    for filter_ in costmap.filters:
        blocks[filter_.name], nodes = filter_nodes(filter_, within + filter_.name)
        servers |= nodes
    placed = [(filter_.name, filter_.below) for filter_ in costmap.filters]
    placed += [(layer.name, layer.below) for layer in costmap.skipped]
    filters = [name for name, below in placed if below is None]
    between = [(below, name) for name, below in placed if below is not None]
    for below, name in sorted(between, key=lambda item: -item[0]):
        plugins.insert(below, name)
    blocks |= {layer.name: {**layer.block} for layer in costmap.skipped}
    return {"plugins": plugins} | ({"filters": filters} if filters else {}) | blocks, servers, of_static


def _below(others: Mapping[tuple[str, ...], Any], path: tuple[str, ...]) -> dict[str, Any]:
    return {path_[-1]: value for path_, value in others.items() if path_[:-1] == path}


def _sources(others: Mapping[tuple[str, ...], Any], layer: str, config: ObstacleConfig) -> dict[str, Any]:
    """Return the observation sources of a layer: those of the file, or one for scans if it is not from a file."""
    sources = config.sources
    if sources is None:
        sources = (NamedSource("scan", config.source(None), "/scan"),)
    blocks = {}
    for source in sources:
        topic = {"topic": source.topic} if source.topic else {}
        of_file = _below(others, (layer, source.name))
        blocks[source.name] = {**topic, "data_type": source.data_type, **of_file, **asdict(source.config)}
    return {"observation_sources": " ".join(blocks), **blocks}
