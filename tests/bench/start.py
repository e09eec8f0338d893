"""Print the seconds from the start of Python to the end of the first kernel call: run as a process of its own."""

import time

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import integrate_scan
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import LaserScan

scan = LaserScan(np.full(180, 5.0, dtype=np.float32), -1.57, 0.0174, 0.05, 80.0)
integrate_scan(OccupancyGrid(GridGeometry(0.05, 64, 64)), scan, (0.0, 0.0, 0.0), MappingConfig())
print(time.time())
