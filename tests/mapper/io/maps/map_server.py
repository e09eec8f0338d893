"""nav2's map server in plain Python, one pixel at a time, with independent readers of YAML and images.

Source: nav2_map_server, map_io.cpp (loadMapYaml, loadMapFromFile).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image

FREE, OCCUPIED, UNKNOWN = 0, 100, -1


def served(yaml_path: Path) -> tuple[NDArray[np.int64], dict[str, Any]]:
    """Return the values (rows, cols), row 0 at the smallest y, that map_server publishes for a map, and its yaml."""
    keys = yaml.safe_load(yaml_path.read_text(encoding="utf-8"))
    image = Image.open(yaml_path.parent / keys["image"])
    values = np.empty((image.height, image.width), dtype=int)
    for y in range(image.height):
        for x in range(image.width):
            values[image.height - y - 1, x] = _cell(image, x, y, keys)
    return values, keys


def _cell(image: Image.Image, x: int, y: int, keys: dict[str, Any]) -> int:
    mode = keys.get("mode", "trinary")
    alpha = 1.0
    if image.mode.startswith("I"):
        shades = [float(np.asarray(image)[y, x]) / 65535.0]
    else:
        pixel = image.convert("RGBA").getpixel((x, y))
        assert isinstance(pixel, tuple)
        *shades, alpha = (channel / 255.0 for channel in pixel)
        if image.has_transparency_data and mode == "trinary":
            shades.append(alpha)  # "to preserve existing behavior"
    shade = sum(shades) / len(shades)
    occupancy = shade if keys["negate"] else 1.0 - shade
    if mode == "raw":
        stated = round(shade * 255.0)
        return stated if FREE <= stated <= OCCUPIED else UNKNOWN
    if mode == "scale" and alpha < 1.0:
        return UNKNOWN
    if occupancy > keys["occupied_thresh"]:
        return OCCUPIED
    if occupancy < keys["free_thresh"]:
        return FREE
    if mode == "trinary":
        return UNKNOWN
    return int(np.rint((occupancy - keys["free_thresh"]) / (keys["occupied_thresh"] - keys["free_thresh"]) * 100.0))
