"""Maps in three dimensions: occupied, free and unknown voxels in hashed blocks of 8³, and their octree.

Source: Hornung, Wurm, Bennewitz, Stachniss & Burgard, OctoMap: an efficient probabilistic 3D mapping framework based on
octrees, Autonomous Robots 34, 2013.
"""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import attributes_from

if TYPE_CHECKING:
    from mapper.volume.blocks import BlockHash
    from mapper.volume.changes import Changes, changes_between
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
    "changes_between",
    "distance_to_obstacle",
    "octree_file",
    "project",
    "read_octree",
    "voxels_in_box",
    "write_octree",
]

# The command imports only the parameters, for its options.
__getattr__ = attributes_from(
    __name__,
    {
        "BlockHash": "mapper.volume.blocks",
        "Casts": "mapper.volume.queries",
        "Changes": "mapper.volume.changes",
        "Inserted": "mapper.volume.occupancy",
        "OccupancyVolume": "mapper.volume.occupancy",
        "Octree": "mapper.volume.octree",
        "OctreeFile": "mapper.volume.octree_files",
        "VOLUME_PARAMETERS": "mapper.volume.parameters",
        "VolumeConfig": "mapper.volume.parameters",
        "cast": "mapper.volume.queries",
        "changes_between": "mapper.volume.changes",
        "distance_to_obstacle": "mapper.volume.queries",
        "octree_file": "mapper.volume.octree_files",
        "project": "mapper.volume.queries",
        "read_octree": "mapper.volume.octree_files",
        "voxels_in_box": "mapper.volume.queries",
        "write_octree": "mapper.volume.octree_files",
    },
)
