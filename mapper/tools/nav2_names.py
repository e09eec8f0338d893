"""``python -m mapper.tools.nav2_names CHECKOUT…``: compare the parameters declared by Nav2 with those known here.

Each CHECKOUT is a folder with the sources of one release of navigation2, of which only the files in :data:`SOURCES` are
read. It prints the declared names that :mod:`mapper.io.nav2_declared` lacks, and the names there that none of the
checkouts declares, as names of other releases. It exits with 1 if a name is missing.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType

from mapper.io.nav2_declared import (
    AMCL,
    CONTROLLER_SERVER,
    COSTMAP,
    FILTERS,
    LAYERS,
    NAVFN,
    NODE,
    PLANNER_SERVER,
    PURSUIT,
    RENAMED,
    SOURCE,
)
from mapper.localization.amcl_parameters import NAV2_NAMES, OWN_ROWS
from mapper.localization.parameters import BY_NAME

_FILTERS = "nav2_costmap_2d/plugins/costmap_filters"
_PURSUIT = "nav2_regulated_pure_pursuit_controller/src"
#: Files of a checkout, and the known names of what they declare for a node or a plugin itself.
SOURCES: Mapping[str, frozenset[str]] = MappingProxyType({
    "nav2_costmap_2d/src/costmap_2d_ros.cpp": COSTMAP,
    "nav2_costmap_2d/plugins/static_layer.cpp": LAYERS["StaticLayer"],
    "nav2_costmap_2d/plugins/obstacle_layer.cpp": LAYERS["ObstacleLayer"],
    "nav2_costmap_2d/plugins/voxel_layer.cpp": LAYERS["VoxelLayer"],
    "nav2_costmap_2d/plugins/denoise_layer.cpp": LAYERS["DenoiseLayer"],
    "nav2_costmap_2d/plugins/inflation_layer.cpp": LAYERS["InflationLayer"],
    "nav2_costmap_2d/plugins/plugin_container_layer.cpp": LAYERS["PluginContainerLayer"],
    f"{_FILTERS}/costmap_filter.cpp": FILTERS["KeepoutFilter"],
    f"{_FILTERS}/keepout_filter.cpp": FILTERS["KeepoutFilter"],
    f"{_FILTERS}/speed_filter.cpp": FILTERS["SpeedFilter"],
    f"{_FILTERS}/binary_filter.cpp": FILTERS["BinaryFilter"],
    "nav2_planner/src/planner_server.cpp": PLANNER_SERVER,
    "nav2_planner/src/parameter_handler.cpp": PLANNER_SERVER,
    "nav2_controller/src/controller_server.cpp": CONTROLLER_SERVER,
    "nav2_controller/src/parameter_handler.cpp": CONTROLLER_SERVER,
    "nav2_navfn_planner/src/navfn_planner.cpp": NAVFN,
    f"{_PURSUIT}/regulated_pure_pursuit_controller.cpp": PURSUIT,
    f"{_PURSUIT}/parameter_handler.cpp": PURSUIT,
    "nav2_amcl/src/amcl_node.cpp": AMCL | {*NAV2_NAMES} | ({*BY_NAME} - {*OWN_ROWS}),
})  # fmt: skip
_OF_SOURCES = SOURCE | {*RENAMED}
#: A call of declare_parameter or a related function, up to the name argument, which contains a string.
_CALL = re.compile(
    r'(?:declare\w*_?[pP]arameter\w*|add_parameter)\s*(?:<[^;()]*>)?\s*\((?:\s*\w+\s*,)?\s*([^,;"]*"[^,;]*?)\s*[,)]'
)
_OWN = re.compile(r"(?:plugin_)?(?:name_?)?\s*\+?\s*")  #: prefix of a name of the node or the plugin itself


def declared(text: str) -> Iterator[tuple[str, bool]]:
    """Yield the names of parameters that a C++ source declares, and whether they belong to an observation source.

    Names of plugins that the node only loads are skipped, such as ``default_ids_[i] + ".plugin"``.
    """
    for (argument,) in ((match[1],) for match in _CALL.finditer(text)):
        before = argument.partition('"')[0]
        name = "".join(re.findall(r'"([^"]*)"', argument)).lstrip(".")
        is_of_source = before.strip().startswith("source")
        if is_of_source or _OWN.fullmatch(before):
            yield name, is_of_source


def main(folders: list[str]) -> int:
    """Print the comparison; return 1 if a name is missing."""
    seen, known, lacking = set[str](), set[str](), False
    for folder in map(Path, folders):
        for path, names in SOURCES.items():
            if not (folder / path).is_file():
                print(f"{folder.name}: no {path}")
                continue
            declared_names = list(declared((folder / path).read_text(encoding="utf-8", errors="replace")))
            known |= names | ({*_OF_SOURCES} if any(is_of_source for _, is_of_source in declared_names) else set())
            seen |= {name.partition(".")[0] for name, _ in declared_names}
            more = {
                name for name, is_of_source in declared_names
                if name.partition(".")[0] not in (_OF_SOURCES if is_of_source else names | NODE)
            }  # fmt: skip
            lacking |= bool(more)
            print(f"{folder.name}: {path}: {len(declared_names)} declared, lacking: {' '.join(sorted(more)) or '–'}")
    print(f"known, and declared in none of these: {' '.join(sorted(known - seen)) or '–'}")
    return int(lacking)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
