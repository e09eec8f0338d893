"""Parameters of the planner and the path follower in a Nav2 parameter file: NavFn, Regulated Pure Pursuit.

Source: the Nav2 documentation, Planner Server, NavFn Planner, Controller Server and Regulated Pure Pursuit.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import yaml

from mapper.core.parameter import Parameter
from mapper.io.nav2_declared import CONTROLLER_SERVER, NAVFN, PLANNER_SERVER, PURSUIT, checked, not_built, undeclared
from mapper.io.nav2_declared import NODE as OF_EVERY_NODE
from mapper.io.ros_parameters import find_node, names_of
from mapper.planning.parameters import PLANNER_PARAMETERS, PURSUIT_PARAMETERS, PlannerConfig, PursuitConfig

NODE = "planner_server"
CONTROLLER = "controller_server"
_LISTS = {NODE: "planner_plugins", CONTROLLER: "controller_plugins"}
#: The default plugins of a node without a list, and their types if not stated (planner_server.cpp,
#: controller_server.cpp: default_ids_, default_types_).
_DEFAULTS = {NODE: ("GridBased", "NavfnPlanner"), CONTROLLER: ("FollowPath", "DWBLocalPlanner")}
_DECLARED = {NODE: PLANNER_SERVER | OF_EVERY_NODE, CONTROLLER: CONTROLLER_SERVER | OF_EVERY_NODE}
#: Used if the file has no plugin of a supported kind.
_IN_PLACE = {
    NODE: "the path is that of NavFn with Nav2’s defaults",
    CONTROLLER: "the path is followed by Regulated Pure Pursuit with Nav2’s defaults",
}
_NAVFN = "nav2_navfn_planner::NavfnPlanner"
_PURSUIT = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
_RENAMED = {"max_linear_vel": "desired_linear_vel"}  #: the name since the release after Kilted, and the one before
_NAMES = ("tolerance", "use_astar", "allow_unknown")  #: the other two rows are constants in Nav2


@dataclass(frozen=True, slots=True)
class Nav2Path:
    """The planner and the path follower of a Nav2 parameter file.

    ``planner_name`` and ``follower_name`` are their plugin names. ``others`` are the parameters of both nodes without
    effect here, by path: (node, name) or (node, plugin, name), which :func:`nav2_path_yaml` writes again. ``notes`` are
    sentences on names that Nav2 does not declare.
    """

    planner: PlannerConfig = field(default_factory=PlannerConfig)
    pursuit: PursuitConfig = field(default_factory=PursuitConfig)
    planner_name: str = "GridBased"
    follower_name: str = "FollowPath"
    others: Mapping[tuple[str, ...], Any] = field(default_factory=dict)
    notes: tuple[str, ...] = field(default=(), compare=False)

    @property
    def unused(self) -> tuple[str, ...]:
        """The names of the parameters that have no effect here."""
        return tuple(".".join(path) for path in self.others if path[1:] != (_LISTS[path[0]],))


def path_of(root: dict[str, Any]) -> Nav2Path:
    """Return the first NavFn of ``planner_plugins`` and the first Regulated Pure Pursuit of ``controller_plugins``.

    ``root`` is the result of :func:`mapper.io.ros_parameters.parse_ros_parameters`. Missing values have Nav2's
    defaults, including the plugin lists; a name that Nav2 does not declare gets a note. Raises :class:`ConfigError`,
    naming the parameter with its path, for an impossible value.
    """
    others: dict[tuple[str, ...], Any] = {}
    notes: list[str] = []
    planner_name, planner = _plugin(root, NODE, "NavfnPlanner", _TABLES[0], NAVFN, others, notes)
    follower_name, follower = _plugin(
        root, CONTROLLER, "RegulatedPurePursuitController", _TABLES[1], PURSUIT, others, notes
    )
    return Nav2Path(
        replace(PlannerConfig(), **planner),
        replace(PursuitConfig(), **follower),
        planner_name or _free_name(others, NODE, "GridBased", "NavFn"),
        follower_name or _free_name(others, CONTROLLER, "FollowPath", "RegulatedPurePursuit"),
        others,
        tuple(notes),
    )


def nav2_path_yaml(path: Nav2Path) -> str:
    """Return a parameter file with both, which :func:`path_of` reads."""
    navfn = {"plugin": _NAVFN, **{name: getattr(path.planner, name) for name in _NAMES}}
    own = {
        NODE: (path.planner_name, navfn),
        CONTROLLER: (path.follower_name, {"plugin": _PURSUIT, **asdict(path.pursuit)}),
    }
    nodes: dict[str, Any] = {}
    for node, (name, block) in own.items():
        others = {path_[1:]: value for path_, value in path.others.items() if path_[0] == node}
        general = {path_[0]: value for path_, value in others.items() if len(path_) == 1}
        default = _DEFAULTS[node][0]  # listed if the file has no list
        listed = general.pop(_LISTS[node], [default] if (node, default) in path.others else [])
        of_block = {path_[1]: value for path_, value in others.items() if path_[:-1] == (name,)}
        names = [*listed] if name in listed else [*listed, name]
        parameters = {_LISTS[node]: names, **general, name: block | of_block}
        nodes[node] = {"ros__parameters": parameters}
    return yaml.safe_dump(nodes, sort_keys=False)


_TABLES = tuple(row for row in PLANNER_PARAMETERS if row.name in _NAMES), PURSUIT_PARAMETERS


def _free_name(others: Mapping[tuple[str, ...], Any], node: str, usual: str, other: str) -> str:
    """Return a name for our plugin: the usual one, unless the file has another plugin of that name."""
    return other if (node, usual) in others else usual


def _plugin(
    root: dict[str, Any],
    node: str,
    kind: str,
    table: tuple[Parameter, ...],
    declared: Collection[str],
    others: dict[tuple[str, ...], Any],
    notes: list[str],
) -> tuple[str | None, dict[str, Any]]:
    """Return the name and the values of the first plugin of a kind in a node's list; None if there is none.

    Everything else in the node is put into ``others``, and sentences on names that Nav2 does not declare into
    ``notes``.
    """
    key = _LISTS[node]
    section = find_node(root, (node,), (key,))
    parameters = {**section[1]} if section else {}
    default, default_kind = _DEFAULTS[node]
    names = names_of(parameters.get(key, [default]), f"{node}.{key}")
    rows = {row.name: row for row in table}
    usual = default_kind if names == [default] else ""
    own = next((name for name in names if _is(parameters.get(name), kind, usual)), None)
    values: dict[str, Any] = {}
    for name, value in (parameters.pop(own) if own else {}).items():
        parameter = _RENAMED.get(name, name)
        if parameter in rows:
            values[parameter] = checked(rows[parameter], value, f"{node}.{own}.{name}", notes)
        elif own and name != "plugin":
            others[node, own, name] = value
            if name not in declared:
                notes.append(undeclared(f"{node}.{own}", name, {*declared, *rows}))
    if own is None and section:
        block = parameters.get(next(iter(names), ""))
        plugin = block.get("plugin", usual) if isinstance(block, dict) else default_kind
        notes.append(not_built(".".join([node, *names[:1]]), plugin, _IN_PLACE[node]))
    others |= {(node, str(name)): value for name, value in parameters.items()}
    blocks = {name for name, value in parameters.items() if isinstance(value, dict)}  # of other plugins
    known = _DECLARED[node]
    notes += [undeclared(node, str(name), known) for name in parameters if name not in blocks and name not in known]
    return own, values


def _is(block: object, kind: str, usual: str) -> bool:
    """Return whether a plugin's block is of a kind, which is the ``usual`` one if the block does not state it."""
    return isinstance(block, dict) and kind in str(block.get("plugin", usual))
