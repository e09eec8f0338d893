"""Export of a costmap as map files, raw costs, and ROS 2 messages."""

from __future__ import annotations

import io
import os
from pathlib import Path

import numpy as np

from mapper.core.array_types import Int8Array, UInt8Array
from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError
from mapper.grid.occupancy_grid import GridGeometry
from mapper.io.costmaps import RecordedCostmap, write_costmaps
from mapper.io.maps import yaml_text
from mapper.io.maps.images import pgm_header


def costmap_pgm(costs: UInt8Array) -> bytes:
    """Return a PGM with the costs (rows, cols), 0 to 255, as pixels; its top row is the row of the greatest y."""
    return pgm_header(costs.shape) + GridGeometry.to_image(costs).tobytes()


def mask_pgm(mask: Int8Array) -> bytes:
    """Return a PGM of a filter's mask (rows, cols) int8, for mode raw: grey values 0 to 100, 0 where nothing is
    painted.
    """
    return costmap_pgm(mask.clip(0).astype(np.uint8))


def costmap_mcap(costmap: RecordedCostmap) -> bytes:
    """Return an MCAP file with a costmap, as written by :func:`save_costmap_mcap`."""
    file = io.BytesIO()
    write_costmaps(file, [costmap])
    return file.getvalue()


def save_costmap(
    costs: UInt8Array, geometry: GridGeometry, prefix: str | os.PathLike[str], frame: str | None = None
) -> tuple[Path, Path]:
    """Write ``prefix.yaml`` and ``prefix.pgm`` with the costs 0 to 255 as pixels; return both paths.

    The image's top row is the row of the greatest y. Each file is written atomically. Raises :class:`ConfigError` if a
    file cannot be written.
    """
    base = Path(prefix)
    if not base.name:
        raise ConfigError("map.prefix", f"A costmap needs a file name, which {str(prefix)!r} lacks.")
    image_path, yaml_path = base.with_name(base.name + ".pgm"), base.with_name(base.name + ".yaml")
    try:
        base.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(image_path) as file:
            file.write(costmap_pgm(costs))
        with atomic_write(yaml_path) as file:
            file.write(yaml_text(geometry, image_path.name, "raw", frame=frame).encode())
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigError("map.unwritable", f"The costmap {base.name!r} cannot be written: {reason}.") from error
    return yaml_path, image_path


def save_costmap_mcap(
    costs: UInt8Array,
    geometry: GridGeometry,
    path: str | os.PathLike[str],
    frame: str | None = None,
    stamp_ns: int = 0,
) -> None:
    """Write an MCAP file with the costs on ``/costmap_raw`` (nav2_msgs/Costmap) and ``/costmap`` (OccupancyGrid).

    The file is written atomically. Raises :class:`ConfigError` if it cannot be written.
    """
    costmap = RecordedCostmap(stamp_ns, stamp_ns, frame or "map", "master", geometry, costs)
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(target) as file:
            write_costmaps(file, [costmap])
    except OSError as error:
        message = f"The file {target.name!r} cannot be written: {error.strerror}."
        raise ConfigError("costmap.unwritable", message) from error
