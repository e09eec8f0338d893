"""Manual map editing: paint cells, keepout zones, speed limits, remove specks, rotate, crop, move the origin; recorded.

Each operation is in the map's coordinates after the operations before it, so that a list can be replayed on the same
map.
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
