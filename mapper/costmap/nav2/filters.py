"""Costmap filters of a Nav2 parameter file: a filter, the server of its information and the server of its mask.

Source: the Nav2 documentation, Navigating with Keepout Zones and with Speed Limits: a filter names the topic of a
costmap filter info server, that server names the topic of the mask, and a map server of that topic names the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mapper.core.errors import ConfigError
from mapper.io.nav2_declared import FILTERS, switched, undeclared
from mapper.io.ros_parameters import nodes_of

KINDS = {"KeepoutFilter": "keepout", "SpeedFilter": "speed", "BinaryFilter": "binary"}
#: The types of nav2_msgs/CostmapFilterInfo that each kind of filter takes; the keepout filter takes any.
TYPES = {"keepout": (0,), "speed": (1, 2), "binary": (3,)}
_PLUGIN_OF = {kind: plugin for plugin, kind in KINDS.items()}
_DEFAULT_TOPIC = "/costmap_filter_info"


@dataclass(frozen=True, slots=True)
class NamedFilter:
    """A filter of a parameter file.

    ``kind`` is keepout, speed or binary; ``mask`` is the file name of its mask, or None. ``type``, ``base`` and
    ``multiplier`` are those of nav2_msgs/CostmapFilterInfo. ``below`` is the number of layers below the filter, None
    for a filter above all of them.
    """

    name: str
    kind: str
    mask: str | None = None
    type: int = 0
    base: float = 0.0
    multiplier: float = 1.0
    enabled: bool = True
    below: int | None = None


def is_filter(block: object) -> bool:
    """Return whether a block of parameters belongs to a filter."""
    return isinstance(block, dict) and kind_of(block) is not None


def kind_of(block: Mapping[str, Any]) -> str | None:
    """Return the kind of filter of a block's plugin, or None."""
    return KINDS.get(str(block.get("plugin", "")).replace("/", "::").split("::")[-1])


def named_filter(
    root: Mapping[str, Any], name: str, block: object, where: str, below: int | None, notes: list[str]
) -> NamedFilter:
    """Return the filter ``name`` with the values of its servers in a whole file's mapping ``root``; append to
    ``notes``.

    Raises :class:`ConfigError` for a block that is not a filter, and for impossible values of its servers.
    """
    kind = kind_of(block) if isinstance(block, dict) else None
    if not isinstance(block, dict) or kind is None:
        known = ", ".join(KINDS)
        raise ConfigError("nav2.filter", f"{where}: The filter has no 'plugin' that is one of {known}.")
    declared = FILTERS[_PLUGIN_OF[kind]]
    notes += [undeclared(where, key, declared) for key in block if key not in declared]
    enabled = switched(block.get("enabled", True), f"{where}.enabled", notes)
    topic = _topic(block.get("filter_info_topic", _DEFAULT_TOPIC))
    servers = [
        ("/".join(path), info)
        for path, info in nodes_of(root)
        if "mask_topic" in info and _topic(info.get("filter_info_topic", _DEFAULT_TOPIC)) == topic
    ]
    none = NamedFilter(name, kind, None, TYPES[kind][0], enabled=enabled, below=below)
    if not servers:
        return none
    server, info = next((one for one in servers if one[1].get("type", 0) in TYPES[kind]), servers[0])
    type_, base, multiplier = _info(info, server)
    if len(servers) > 1:
        others = ", ".join(other for other, _ in servers if other != server)
        notes.append(
            f"{where}: Not only {server} but also {others} has the filter_info_topic {topic!r:.80}, and in Nav2 the "
            f"last one to start counts: {server} is taken. Give each filter a topic of its own."
        )
    if kind != "keepout" and type_ not in TYPES[kind]:
        fit = " or ".join(map(str, TYPES[kind]))
        notes.append(
            f"{where}: {server} states the type {type_}, where a {kind} filter needs {fit}: as in Nav2, which logs an "
            "error, the filter has no effect."
        )
        return none
    if kind == "keepout" and (base, multiplier) != (0.0, 1.0):
        notes.append(
            f"{server} states a base of {base:g} and a multiplier of {multiplier:g}, which a keepout filter does not "
            "use: Nav2 logs an error, and takes the mask as it is."
        )
    return NamedFilter(name, kind, _mask_file(root, info["mask_topic"]), type_, base, multiplier, enabled, below)


def filter_nodes(filter_: NamedFilter, label: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a filter's block of the costmap, and the nodes of its servers, in the form read by :func:`named_filter`.

    The names of the servers and their topics are prefixed with ``label``.
    """
    info_topic = f"/{label}_info"
    block = {
        "plugin": f"nav2_costmap_2d::{_PLUGIN_OF[filter_.kind]}",
        "enabled": filter_.enabled,
        "filter_info_topic": info_topic,
    }
    if filter_.mask is None:
        return block, {}
    mask_topic = f"/{label}_mask"
    info = {
        "type": filter_.type,
        "filter_info_topic": info_topic,
        "mask_topic": mask_topic,
        "base": filter_.base,
        "multiplier": filter_.multiplier,
    }
    server = {"topic_name": mask_topic, "yaml_filename": filter_.mask}
    return block, {
        f"{label}_info_server": {"ros__parameters": info},
        f"{label}_mask_server": {"ros__parameters": server},
    }


def _topic(value: object) -> str:
    return str(value).strip("/")


def _mask_file(root: Mapping[str, Any], mask_topic: object) -> str | None:
    for node, parameters in nodes_of(root):
        if "yaml_filename" in parameters and _topic(parameters.get("topic_name", "map")) == _topic(mask_topic):
            path = parameters["yaml_filename"]
            if not isinstance(path, str):
                raise ConfigError(
                    "nav2.mask", f"{'/'.join(node)}.yaml_filename must be the name of a file, not {path!r:.80}."
                )
            return path or None
    return None


def _info(info: Mapping[str, Any], node: str) -> tuple[int, float, float]:
    kind, base, multiplier = info.get("type", 0), info.get("base", 0.0), info.get("multiplier", 1.0)
    if isinstance(kind, bool) or kind not in (0, 1, 2, 3):
        raise ConfigError("nav2.value", f"{node}.type must be 0, 1, 2 or 3, not {kind!r:.40}.")
    for name, value in (("base", base), ("multiplier", multiplier)):
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= 1e6:
            raise ConfigError("nav2.value", f"{node}.{name} must be a number, not {value!r:.40}.")
    return int(kind), float(base), float(multiplier)
