"""Map files, as ROS map servers write and read them: a yaml that describes an image."""

from mapper.io.maps.pixels import occupancy_values
from mapper.io.maps.reading import LoadedMap, load_map
from mapper.io.maps.writing import Mode, pgm_bytes, png_bytes, save_map, yaml_text

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
