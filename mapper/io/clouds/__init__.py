"""Point clouds of files, scan graphs and depth folders, and streams of clouds in recordings."""

from mapper.io.clouds.depth_folder import read_depth_folder
from mapper.io.clouds.posed import PosedClouds, open_posed_clouds
from mapper.io.clouds.reading import open_clouds, read_cloud, read_scan_graph
from mapper.sensors.depth_image import DepthFolder, DepthFrame
from mapper.sensors.point_cloud import PointCloud, PosedCloud

__all__ = [
    "DepthFolder",
    "DepthFrame",
    "PointCloud",
    "PosedCloud",
    "PosedClouds",
    "open_clouds",
    "open_posed_clouds",
    "read_cloud",
    "read_depth_folder",
    "read_scan_graph",
]
