"""Writing of costmaps to MCAP as nav2_msgs/Costmap and nav_msgs/OccupancyGrid.

Sources: nav2_msgs, Costmap.msg; nav2_costmap_2d, costmap_2d_publisher.cpp (the costs of an OccupancyGrid).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import IO

import numpy as np
from mcap.writer import CompressionType, Writer

from mapper.core.array_types import Int8Array, UInt8Array
from mapper.core.errors import ConfigError
from mapper.io.costmaps.reading import RecordedCostmap
from mapper.io.export import ros2
from mapper.io.export.topics import Topics


def occupancy_of_costs(costs: UInt8Array) -> Int8Array:
    """Convert costs to nav_msgs/OccupancyGrid values: 0 free, 1 … 98, 99 inscribed, 100 lethal, −1 unknown."""
    table = np.zeros(256, dtype=np.int8)
    table[1:253] = 1 + 97 * np.arange(252) // 251
    table[253], table[254], table[255] = 99, 100, -1
    return table[costs]


def write_costmaps(file: IO[bytes], costmaps: Iterable[RecordedCostmap], topic: str = "/costmap") -> int:
    """Write each costmap to ``topic``_raw as nav2_msgs/Costmap and to ``topic`` as OccupancyGrid, named as in Nav2.

    Return the number written. Raises :class:`ConfigError` for a time before 0 or beyond 32 bits of seconds.
    """
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start("ros2", "gridbloom")
    topics = Topics(writer, frozenset({topic, f"{topic}_raw"}))
    n = 0
    for costmap in costmaps:
        stamp, geometry = costmap.stamp_ns, costmap.geometry
        if not 0 <= stamp <= ros2.LAST_STAMP_NS:
            raise ConfigError("costmap.stamp", f"A costmap’s time must be 0 … 2^31 s, not {stamp} ns.")
        message = ros2.costmap(stamp, costmap.frame, costmap.layer, geometry.resolution, geometry.origin, costmap.costs)
        topics.send(f"{topic}_raw", "nav2_msgs/msg/Costmap", stamp, message)
        values = occupancy_of_costs(costmap.costs)
        message = ros2.occupancy_grid(stamp, costmap.frame, geometry.resolution, geometry.origin, values)
        topics.send(topic, "nav_msgs/msg/OccupancyGrid", stamp, message)
        n += 1
    writer.finish()  # type: ignore[no-untyped-call]
    return n
