"""16-bit PNGs of depths along the optical axis."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mapper.core.errors import ConfigError, ReadError
from mapper.core.limits import Limits
from mapper.sensors.camera import Intrinsics

NO_DEPTH = (0, 65535)  #: values without a depth: 0 of TUM and of most cameras, 65535 of 7-Scenes


def image_size(path: Path) -> tuple[int, int]:
    """Return the width and height of a depth image, from its header. Raises :class:`ReadError`."""
    try:
        with Image.open(path, formats=("PNG",)) as image:
            return image.size
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise ReadError("depth.image", f"{path.name} is no PNG image.") from error


def read_depth(path: Path, camera: Intrinsics, unit: float, limits: Limits) -> NDArray[np.float32]:
    """Return the depths (height, width), metres, of which each step in the file is ``unit``; NaN where there is none.

    Raises :class:`ReadError` for a file that is no 16-bit grey PNG, ends early, or is of another size than the camera's
    images.
    """
    width, height = image_size(path)
    if width * height > limits.max_depth_pixels:
        raise ReadError(
            "depth.size", f"{path.name} has {width} × {height} pixels, more than {limits.max_depth_pixels}."
        )
    try:
        with Image.open(path, formats=("PNG",)) as image:
            mode = image.mode
            raw = np.asarray(image)
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise ReadError("depth.image", f"{path.name} is damaged: its pixels cannot be unpacked.") from error
    if not mode.startswith("I") or raw.ndim != 2:
        raise ReadError(
            "depth.image", f"{path.name} is no depth image: it must be grey with 16 bits a pixel, not {mode}."
        )
    try:
        camera.check_size(raw, "intrinsics")
    except ConfigError as error:
        raise ReadError("depth.size", f"{path.name}: {error.message}.") from error
    depths = raw.astype(np.float32) * np.float32(unit)
    for value in NO_DEPTH:
        depths[raw == value] = np.nan
    return depths
