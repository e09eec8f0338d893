"""Parameters of the planner in a Nav2 parameter file: those of its NavFn.

Source: the Nav2 documentation, Planner Server and NavFn Planner.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mapper.core.errors import ConfigError
from mapper.io.ros_parameters import find_node, parse_ros_parameters
from mapper.planning.parameters import PLANNER_PARAMETERS, PlannerConfig

NODE = "planner_server"
_NAMES = ("tolerance", "use_astar", "allow_unknown")  #: the other two rows are constants in Nav2
_WITHOUT_EFFECT = frozenset(("plugin", "use_final_approach_orientation"))


def parse_nav2_planner(data: bytes) -> PlannerConfig:
    """Return the parameters of the first NavFn among ``planner_server``'s ``planner_plugins``.

    Nav2's defaults where the file has none. Raises :class:`ConfigError`, which names the parameter with its path, for
    an unknown name and an impossible value, and what :func:`mapper.io.ros_parameters.parse_ros_parameters` raises.
    """
    found = find_node(parse_ros_parameters(data), (NODE,))
    names = found[1].get("planner_plugins", []) if found else []
    if not isinstance(names, list):
        raise ConfigError("nav2.plugins", f"{NODE}.planner_plugins must be a list of names, not {names!r:.80}.")
    for name in names:
        block = found[1].get(name) if found and isinstance(name, str) else None
        if not isinstance(block, dict) or "NavfnPlanner" not in str(block.get("plugin")):
            continue
        rows = {row.name: row for row in PLANNER_PARAMETERS if row.name in _NAMES}
        values: dict[str, Any] = {}
        for key, value in block.items():
            if key in rows:
                try:
                    values[key] = rows[key].check(value)
                except ConfigError as error:
                    raise ConfigError("nav2.value", f"{NODE}.{name}.{key}: {error.message}") from error
            elif key not in _WITHOUT_EFFECT:
                raise ConfigError("nav2.unknown", f"{NODE}.{name}: There is no parameter {key!r:.80}.")
        return replace(PlannerConfig(), **values)
    return PlannerConfig()
