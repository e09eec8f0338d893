"""Edit a map by hand: paint cells, keepout zones, speed limits, remove specks, turn, crop, move the origin; recorded.

Each operation is in the map's coordinates as the operations before left them, so that a list can be carried out again
on the same map.
"""

from mapper.editing.edited_map import EditedMap
from mapper.editing.operations import (
    Crop,
    Despeckle,
    Fill,
    Keepout,
    Operation,
    Origin,
    Paint,
    Rotate,
    Speed,
    operation_dict,
    parse_operation,
)

__all__ = [
    "Crop",
    "Despeckle",
    "EditedMap",
    "Fill",
    "Keepout",
    "Operation",
    "Origin",
    "Paint",
    "Rotate",
    "Speed",
    "operation_dict",
    "parse_operation",
]
