"""Map files as read and written by ROS map servers: a yaml that describes an image."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later
from mapper.io.maps.pixels import occupancy_values
from mapper.io.maps.writing import Mode, pgm_bytes, png_bytes, save_map, yaml_text

if TYPE_CHECKING:
    from mapper.io.maps.reading import LoadedMap, load_map

__all__ = [
    "LoadedMap",
    "Mode",
    "load_map",
    "occupancy_values",
    "pgm_bytes",
    "png_bytes",
    "save_map",
    "yaml_text",
]

# The reader imports Pillow and PyYAML, which writing does not need.
__getattr__ = imported_later(__name__, __file__)
