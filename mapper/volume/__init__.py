"""Maps in three dimensions: occupied, free and unknown voxels in hashed blocks of 8³, and their octree.

Source: Hornung, Wurm, Bennewitz, Stachniss & Burgard, OctoMap: an efficient probabilistic 3D mapping framework based on
octrees, Autonomous Robots 34, 2013.
"""

from mapper.volume.blocks import BlockHash
from mapper.volume.changes import Changes, changes
from mapper.volume.occupancy import Inserted, OccupancyVolume
from mapper.volume.octree import Octree
from mapper.volume.octree_files import OctreeFile, octree_file, read_octree, write_octree
from mapper.volume.parameters import VOLUME_PARAMETERS, VolumeConfig
from mapper.volume.queries import Casts, cast, distance_to_obstacle, project, voxels_in_box

__all__ = [
    "VOLUME_PARAMETERS",
    "BlockHash",
    "Casts",
    "Changes",
    "Inserted",
    "OccupancyVolume",
    "Octree",
    "OctreeFile",
    "VolumeConfig",
    "cast",
    "changes",
    "distance_to_obstacle",
    "octree_file",
    "project",
    "read_octree",
    "voxels_in_box",
    "write_octree",
]
