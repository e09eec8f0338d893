"""Costmaps in recordings: reading and writing of nav2_msgs/Costmap messages."""

from mapper.io.costmaps.reading import CostmapStream, RecordedCostmap, open_costmaps
from mapper.io.costmaps.writing import occupancy_of_costs, write_costmaps

__all__ = ["CostmapStream", "RecordedCostmap", "occupancy_of_costs", "open_costmaps", "write_costmaps"]
