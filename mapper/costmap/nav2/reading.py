"""Reading of costmap parameters from Nav2's yaml.

Source: the Nav2 documentation, Costmap 2D, and the declarations of :mod:`mapper.io.nav2_declared`.
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import yaml

from mapper.core.errors import ConfigError, ReadError
from mapper.core.parameter import Parameter, table_of
from mapper.costmap.footprint import Footprint
from mapper.costmap.nav2.costmap import (
    CONTAINER,
    OF_SOURCE,
    OF_STATIC,
    PLUGINS,
    ContainerConfig,
    NamedLayer,
    Nav2Costmap,
    PluginConfig,
    SkippedLayer,
)
from mapper.costmap.nav2.filters import NamedFilter, is_filter, named_filter
from mapper.costmap.parameters import (
    COMBINATIONS,
    COSTMAP_PARAMETERS,
    SOURCE_PARAMETERS,
    STATIC_PARAMETERS,
    CostmapConfig,
    InflationConfig,
    NamedSource,
    ObstacleConfig,
    SourceConfig,
    StaticConfig,
)
from mapper.io.nav2_declared import COSTMAP, LAYERS, NODE, RENAMED, SOURCE, WHOLE, checked, undeclared, wrong_type
from mapper.io.ros_parameters import (
    ParameterFile,
    find_node,
    names_of,
    node_names,
    note_on_others,
    parse_ros_parameters,
)
from mapper.io.untrusted_yaml import load_untrusted

NODES = ("global_costmap", "local_costmap")

#: Names and types of Nav2's default layers, used if a file has no list (default_plugins_ and default_types_ of
#: costmap_2d_ros.cpp); the types also if its list is equal to the default one.
DEFAULT_LAYERS = {"static_layer": "StaticLayer", "obstacle_layer": "ObstacleLayer", "inflation_layer": "InflationLayer"}
#: Structural keys, which have an effect and are written again.
_STRUCTURE = frozenset(("plugins", "filters", "plugin", "resolution", "plugin_names", "plugin_types"))
#: Top-level keys of ROS 1 files, and their differences.
OF_ROS1 = frozenset((*NODES, "obstacle_range", "raytrace_range", "footprint", "robot_radius", "inflation_radius"))
ROS1 = "whose nodes have their parameters directly: put them below ros__parameters, with a list of plugins"
OF_NAV2 = ("nav2_costmap_2d", "gridbloom", "costmap_2d", "")  #: packages of supported plugins
MAX_LAYERS = 20
LEAST_POINTS = 3  #: of a footprint
#: Plugins that are equivalent to another one.
SAME_AS = {"LegacyInflationLayer": "InflationLayer"}


def parse_nav2_costmap(data: bytes, node: str | None = None) -> Nav2Costmap:
    """Return the costmap in a Nav2 parameter file: that of ``node``, or else the global one, or else the local one.

    Missing parameters have Nav2's defaults, including the list of layers. Unsupported parts (layers that are not
    implemented, names that Nav2 does not declare) are left out with a note. Raises :class:`ReadError` for a file
    without a costmap and :class:`ConfigError`, naming the parameter with its path, for an impossible value.
    """
    return costmap_of(parse_ros_parameters(data), node)


def costmap_of(root: dict[str, Any], node: str | None = None) -> Nav2Costmap:
    """Return the costmap in the result of :func:`mapper.io.ros_parameters.parse_ros_parameters` for a file.

    Like :func:`parse_nav2_costmap`, for callers that read more than the costmap from the file.
    """
    block = find_node(root, (node,) if node else NODES, COSTMAP)
    if block is None:
        nodes = node or " or ".join(NODES)
        has = ", ".join(node_names(root))
        others = (key for key in _keys(root) if key != "ros__parameters")
        misspelt = difflib.get_close_matches("ros__parameters", others, 1, 0.85)
        if misspelt:
            more = f": {misspelt[0]!r:.40} is there instead."
        elif has:
            more = f"; it has {has:.300}."
        else:
            more = f"; apparently it is one of ROS 1’s move_base, {ROS1}." if root.keys() & OF_ROS1 else "."
        message = f"The parameter file has no costmap: no {nodes} with ros__parameters{more}"
        raise ReadError("nav2.no_costmap", message)
    costmap = _Reader(root, *block).read()
    of_file = root.notes if isinstance(root, ParameterFile) else ()
    return replace(costmap, notes=(*of_file, *note_on_others(root, block[0]), *costmap.notes))


def _keys(parameters: Mapping[Any, Any]) -> Iterator[str]:
    """Yield the keys of a mapping and, recursively, of its values."""
    for key, value in parameters.items():
        yield str(key)[:40]
        if isinstance(value, dict):
            yield from _keys(value)


class _Reader:
    """Reads the parameters ``given`` of one node or container; the results are also in ``notes`` and ``others``."""

    def __init__(
        self, root: Mapping[str, Any], node: str, given: Mapping[str, Any], *, in_container: bool = False
    ) -> None:
        self.root, self.node, self.given, self.in_container = root, node, {**given}, in_container
        self.notes: list[str] = []
        self.others: dict[tuple[str, ...], Any] = {}
        self.skipped: list[SkippedLayer] = []

    def read(self) -> Nav2Costmap:
        names = self._layer_names()
        own = self.given
        blocks = {name: self._block(name, own.pop(name, None)) for name in names}
        of_filters = {name: own.pop(name, None) for name in _names(own, "filters", self.node) if name not in blocks}
        footprint = _footprint(own.pop("footprint", None), self.node, self.notes)
        if own.get("unknown_cost_value") == -1:  # from ROS 1's costmap_2d; it is an unsigned byte in Nav2
            own["unknown_cost_value"] = 255
        of_static = {
            row.name: checked(row, own.pop(row.name), f"{self.node}.{row.name}", self.notes)
            for row in STATIC_PARAMETERS
            if row.name in OF_STATIC and row.name in own
        }
        # Nav2 uses only the layers in its list. Other blocks are layers or sources that are not in use.
        self.others.update(
            {(key,): own.pop(key) for key in [key for key, value in own.items() if isinstance(value, dict)]}
        )
        general = self._config(CostmapConfig(), COSTMAP_PARAMETERS, own, (self.node,), COSTMAP)
        if footprint is None and general.robot_radius == 0.0:
            raise ConfigError(
                "nav2.value", f"{self.node}.robot_radius must be more than 0 m, or there must be a footprint."
            )
        filters: list[NamedFilter] = []
        for name, block in of_filters.items():
            if isinstance(block, dict) and isinstance(block.get("plugin"), str) and not is_filter(block):
                self._skip(name, block, None, "is no filter that is built here")
            else:
                filters.append(named_filter(self.root, name, block, f"{self.node}.{name}", None, self.notes))
        costmap = self._stack(blocks, general, of_static)
        costmap = replace(costmap, footprint=footprint, filters=(*filters, *costmap.filters))
        if sum(1 for _ in costmap.all_layers()) > MAX_LAYERS:
            raise ConfigError("nav2.plugins", f"{self.node} must have at most {MAX_LAYERS} layers.")
        return replace(costmap, notes=(*self.notes, *_warnings(costmap)))

    def _stack(
        self, blocks: Mapping[str, dict[str, Any]], general: CostmapConfig, of_static: Mapping[str, Any]
    ) -> Nav2Costmap:
        """Return the layers and filters of a plugin list, each with its parameter block."""
        layers: list[NamedLayer] = []
        filters: list[NamedFilter] = []
        last_inflation = [name for name, block in blocks.items() if _kind(block) == "InflationLayer"][-1:]
        for name, block in blocks.items():
            path = (self.node, name)
            if is_filter(block):
                filters.append(named_filter(self.root, name, block, ".".join(path), len(layers), self.notes))
            elif _kind(block) == CONTAINER:
                layers.append(NamedLayer(name, self._container(name, block, general, of_static)))
            elif _kind(block) not in PLUGINS:
                self._skip(name, block, len(layers), "is not built here")
            elif _kind(block) == "InflationLayer" and name not in last_inflation:
                self._skip(name, block, len(layers), f"stands below {last_inflation[0]!r:.80}, and one is built here")
            else:
                layers.append(NamedLayer(name, self._layer(block, of_static, path)))
        return Nav2Costmap(self.node, general, None, tuple(layers), tuple(filters), self.others, tuple(self.skipped))

    def _layer_names(self) -> tuple[str, ...]:
        if "plugins" in self.given:
            return _names(self.given, "plugins", self.node)
        if "plugin_names" not in self.given:
            return tuple(DEFAULT_LAYERS)
        names, types = (_names(self.given, key, self.node) for key in ("plugin_names", "plugin_types"))
        if len(names) != len(types):
            message = f"{self.node}: plugin_names has {len(names)} names, and plugin_types {len(types)}."
            raise ConfigError("nav2.plugins", message)
        self.notes.append(
            f"{self.node}.plugin_names and plugin_types are Nav2’s names up to Eloquent: since Foxy the list is "
            "'plugins', and each layer has a 'plugin'."
        )
        for name, kind in zip(names, types, strict=True):
            block = self.given.get(name) or {}
            if isinstance(block, dict):
                self.given[name] = {"plugin": kind} | block
        return names

    def _block(self, name: str, value: object) -> dict[str, Any]:
        """Return a layer's parameters with its plugin. Raises :class:`ConfigError` if its type is not stated."""
        where = f"{self.node}.{name}"
        if value is not None and not isinstance(value, dict):
            raise ConfigError("nav2.plugin", f"{where}: A layer has parameters, not {value!r:.40}.")
        block = {**(value or {})}
        may_be_default = name in DEFAULT_LAYERS and not self.in_container
        is_default = list(self.given.get("plugins", DEFAULT_LAYERS)) == list(DEFAULT_LAYERS)
        if may_be_default and is_default and "plugin" not in block and "plugin_names" not in self.given:
            block["plugin"] = f"nav2_costmap_2d::{DEFAULT_LAYERS[name]}"
        if not isinstance(block.get("plugin"), str):
            also = ""
            if may_be_default:
                also = f" Nav2 knows it by its name only where the list 'plugins' is {', '.join(DEFAULT_LAYERS)}."
            raise ConfigError("nav2.plugin", f"{where}: The layer has no 'plugin' that says what it is.{also}")
        return block

    def _container(
        self, name: str, block: dict[str, Any], general: CostmapConfig, of_static: Mapping[str, Any]
    ) -> ContainerConfig:
        """Return a container with the layers in its block."""
        where = f"{self.node}.{name}"
        inside = _Reader(self.root, where, block, in_container=True)
        own = inside.given
        blocks = {name: inside._block(name, own.pop(name, None)) for name in _names(own, "plugins", where)}
        inside.others.update(
            {(key,): own.pop(key) for key in [key for key, value in own.items() if isinstance(value, dict)]}
        )
        _name_combination(own, where)
        container: ContainerConfig = inside._config(
            ContainerConfig(inside._stack(blocks, general, of_static)),
            table_of(ContainerConfig), own, (where,), LAYERS[CONTAINER],
        )  # fmt: skip
        self.notes += inside.notes
        return container

    def _skip(self, name: str, block: Mapping[str, Any], below: int | None, why: str) -> None:
        self.skipped.append(SkippedLayer(name, block, below))
        self.notes.append(
            f"{self.node}.{name}: The layer {block['plugin']!r:.80} {why}; it is left out, and the costs are those "
            "without it."
        )

    def _layer(self, block: Mapping[str, Any], of_static: Mapping[str, Any], path: tuple[str, str]) -> PluginConfig:
        kind = _kind(block)
        config, table = PLUGINS[kind]
        values = {**block}
        if _package(block) not in OF_NAV2:
            self.notes.append(
                f"{'.'.join(path)}: {block['plugin']!r:.80} is another package’s; it is built as Nav2’s {kind}."
            )
        if config is StaticConfig:
            # Nav2's static layer reads them from the costmap, not from its own block.
            self.notes += [undeclared(".".join(path), name, LAYERS[kind]) for name in OF_STATIC if name in values]
            values = {name: value for name, value in values.items() if name not in OF_STATIC}
        if issubclass(config, ObstacleConfig):
            sources = self._of_sources(self._sources(values, path), path)
            _name_combination(values, ".".join(path))
            # Nav2's default for a source: it marks, and clears only if the file says so.
            start: Any = config(sources=sources, clearing=False)
            table = tuple(row for row in table if row.name not in OF_SOURCE)
        else:
            start = config(**of_static) if config is StaticConfig else config()
        made: PluginConfig = self._config(start, table, values, path, LAYERS.get(kind, LAYERS["ObstacleLayer"]))
        return made

    def _sources(self, values: dict[str, Any], path: tuple[str, str]) -> list[tuple[str, dict[str, Any]]]:
        """Remove the observation sources from their layer's parameters and return them."""
        where = ".".join(path)
        sources = values.pop("observation_sources", "")
        if not isinstance(sources, str):
            raise ConfigError("nav2.source", f"{where}.observation_sources must be names with spaces between them.")
        if "," in sources:
            self.notes.append(
                f"{where}.observation_sources, {sources!r:.80}, has commas, which Nav2 takes for parts of the names: "
                "put spaces alone between them."
            )
        blocks = []
        for source in dict.fromkeys(sources.split()):
            block = values.pop(source, None)
            if block is not None and not isinstance(block, dict):
                raise ConfigError("nav2.source", f"{where}.{source} must hold parameters, not {block!r:.40}.")
            blocks.append((source, self._renamed(block or {}, f"{where}.{source}")))
        return blocks

    def _renamed(self, block: Mapping[str, Any], where: str) -> dict[str, Any]:
        """Return the parameters with old names replaced by the current ones."""
        renamed = {**block}
        for old in [name for name in block if name in RENAMED]:
            new, release = RENAMED[old]
            value = renamed.pop(old)
            renamed.setdefault(new, value)
            self.notes.append(
                f"{where}.{old} is named {new} since {release}; "
                + ("its value is read as that." if new not in block else f"{new} is given too, and counts.")
            )
        return renamed

    def _of_sources(self, blocks: list[tuple[str, dict[str, Any]]], path: tuple[str, str]) -> tuple[NamedSource, ...]:
        """Return the observation sources of a layer, each with its own parameters."""
        where = ".".join(path)
        sources = []
        for source, block in blocks:
            values: dict[str, Any] = {
                row.name: checked(row, block[row.name], f"{where}.{source}.{row.name}", self.notes)
                for row in SOURCE_PARAMETERS
                if row.name in block
            }
            stated = {name: block[name] for name in ("topic", "data_type") if isinstance(block.get(name), str)}
            sources.append(NamedSource(source, SourceConfig(**values), **stated))
            unknown = [name for name in block if name not in SOURCE]
            self.notes += [undeclared(f"{where}.{source}", name, SOURCE) for name in unknown]
            if block.get("marking", True) is True and "max_obstacle_height" not in block:
                self.notes.append(
                    f"{where}.{source} states no max_obstacle_height, which is 0 m then in Nav2: what a sensor sees "
                    "above that marks nothing there. Files of Nav2 have 2.0."
                )
            self.others.update(
                {(path[1], source, name): value for name, value in block.items() if name not in values | stated}
            )
        return tuple(sources)

    def _config(
        self,
        config: Any,  # noqa: ANN401 - one of the configurations
        table: tuple[Parameter, ...],
        parameters: Mapping[str, Any],
        path: tuple[str, ...],
        declared: Collection[str],
    ) -> Any:  # noqa: ANN401
        where = ".".join(path)
        rows = {row.name: row for row in table}
        values = {}
        for key, value in self._renamed(parameters, where).items():
            if key in rows:
                values[key] = checked(rows[key], value, f"{where}.{key}", self.notes)
            elif key not in _STRUCTURE:
                self.others[*path[1:], key] = value
                if key in WHOLE:
                    self.notes += wrong_type(value, f"{where}.{key}", is_whole=True)
                # A block in a layer is an observation source that is not in use.
                if key not in declared and key not in NODE and not isinstance(value, dict):
                    self.notes.append(undeclared(where, key, {*declared, *rows}))
        return replace(config, **values)


def _package(block: Mapping[str, Any]) -> str:
    return str(block["plugin"]).replace("/", "::").rpartition("::")[0]


def _kind(block: Mapping[str, Any]) -> str:
    """Return the class of a layer's plugin, or its equivalent, without the package."""
    kind = str(block["plugin"]).replace("/", "::").split("::")[-1]
    return SAME_AS.get(kind, kind)


def _name_combination(values: dict[str, Any], where: str) -> None:
    """Replace the number of a combination method by its name. Raises :class:`ConfigError`."""
    method = values.pop("combination_method", None)
    if method is None:
        return
    if type(method) is not int or method not in (0, 1, 2):
        raise ConfigError("nav2.value", f"{where}.combination_method must be 0, 1 or 2, not {method!r:.40}.")
    values["combination_method"] = COMBINATIONS[method]


def _warnings(costmap: Nav2Costmap) -> list[str]:
    """Return warnings as given by Nav2, on layers without observations, and on a costmap without the map."""
    warnings = []
    radius = costmap.outline.inscribed_radius
    layers = [*costmap.all_layers()]
    for layer in layers:
        config = layer.config
        if isinstance(config, InflationConfig) and config.enabled and config.inflation_radius < radius:
            warnings.append(
                f"{costmap.node}.{layer.name}: The inflation radius of {config.inflation_radius:g} m is smaller than "
                f"the inscribed radius of the footprint, {radius:.3f} m: planners that take the robot for a point lead "
                "it into obstacles. Nav2 warns of it too, and recommends at least the inscribed radius."
            )
    warnings += _not_inflated(costmap.layers, costmap.node)
    if not any(isinstance(layer.config, StaticConfig) and layer.config.enabled for layer in layers):
        warnings.append(
            f"{costmap.node} has no static layer in use: nothing of the map is in its costs, only what sensors see."
        )
    warnings += [
        f"{costmap.node}.{layer.name} has no observation_sources: as in Nav2 it sees nothing."
        for layer in layers
        if isinstance(layer.config, ObstacleConfig) and layer.config.enabled and not layer.config.sources
    ]
    return warnings


def _not_inflated(layers: Sequence[NamedLayer], where: str) -> list[str]:
    """Return a sentence for each list of layers in which obstacles are drawn after the inflation.

    Source: LayeredCostmap::updateMap of nav2_costmap_2d, which lets one layer after the other draw.
    """
    notes = []
    inflation = None
    after: list[str] = []
    for layer in layers:
        if isinstance(layer.config, InflationConfig) and layer.config.enabled:
            inflation, after = layer, []
        elif isinstance(layer.config, ContainerConfig):
            notes += _not_inflated(layer.config.inner.layers, f"{where}.{layer.name}")
        if inflation is not None and isinstance(layer.config, StaticConfig | ObstacleConfig) and layer.config.enabled:
            after.append(layer.name)
    if inflation is not None and after:
        notes.append(
            f"{where}.{inflation.name} stands before {', '.join(after)} in the list: as in Nav2 it inflates only what "
            "the layers before it draw. Put it last."
        )
    return notes


def _names(parameters: Mapping[str, Any], key: str, where: str) -> tuple[str, ...]:
    names = [
        name for name in names_of(parameters.get(key, []), f"{where}.{key}") if name
    ]  # [""] is an empty list of names in ROS 2
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        message = f"{where}.{key} has the name {twice!r:.80} twice: leave one out, or give the other its own name."
        raise ConfigError("nav2.plugins", message)
    if len(names) > MAX_LAYERS:
        raise ConfigError("nav2.plugins", f"{where}.{key} must be at most {MAX_LAYERS} names, not {len(names)}.")
    return tuple(names)


def _footprint(value: object, where: str, notes: list[str]) -> Footprint | None:
    """Return the footprint; None if there is none, or for a text that Nav2 rejects, with a note.

    Source: Costmap2DROS::getParameters and makeFootprintFromString of nav2_costmap_2d.
    """
    if value is None or value in ("", "[]", []):
        return None
    points: object = value
    if isinstance(value, str):
        points = _points_of(value)
        if points is None:
            notes.append(
                f"{where}.footprint, {value!r:.80}, is no list of three points [x, y] or more: Nav2 takes robot_radius "
                "in its place, and logs an error."
            )
            return None
    elif isinstance(value, list):
        notes.append(f"{where}.footprint is a list, where Nav2 declares a text, and does not start: put it in quotes.")
    if not isinstance(points, list):
        raise ConfigError("nav2.footprint", f"{where}.footprint: {value!r:.80} is not a list of points.")
    try:
        footprint = Footprint(tuple(tuple(point) for point in points))
    except (ConfigError, TypeError) as error:
        message = error.message if isinstance(error, ConfigError) else "Each point must be [x, y]."
        raise ConfigError("nav2.footprint", f"{where}.footprint: {message}") from error
    crossing = footprint.crossing
    if crossing is not None:
        notes.append(
            f"{where}.footprint crosses itself: the edges from point {crossing[0]} and from point "
            f"{crossing[1]} meet. As in Nav2 it is taken as it is: the inscribed radius is the distance from "
            "(0, 0) to the nearest edge. Put the points in their order along the outline."
        )
    if not footprint.holds_origin:
        notes.append(
            f"{where}.footprint does not hold (0, 0), about which the robot turns. As in Nav2 it is taken as it is: "
            "the inscribed radius is the distance from there to the outline."
        )
    return footprint


def _points_of(text: str) -> list[Any] | None:
    """Return the points of a footprint's text; None for fewer than three, and for text that is not a list of pairs."""
    try:
        points = load_untrusted(text[:10_000])
    except yaml.YAMLError:
        return None
    is_list = isinstance(points, list) and len(points) >= LEAST_POINTS
    if not is_list or any(not isinstance(point, list) or len(point) != 2 for point in points):
        return None
    numbers = (value for point in points for value in point)
    return points if all(isinstance(value, int | float) for value in numbers) else None
