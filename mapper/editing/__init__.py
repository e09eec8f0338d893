"""Edit a map by hand: paint cells, mark keepout zones, remove specks, turn, crop, move the origin; recorded as a list.

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
    "operation_dict",
    "parse_operation",
]
