"""Maps in three dimensions: occupied, free and unknown voxels in hashed blocks of 8³, and their octree.

Source: Hornung, Wurm, Bennewitz, Stachniss & Burgard, OctoMap: an efficient probabilistic 3D mapping framework based on
octrees, Autonomous Robots 34, 2013.
"""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import attributes_from

if TYPE_CHECKING:
    from mapper.volume.blocks import BlockHash
    from mapper.volume.changes import Changes, changes_between
    from mapper.volume.mesh import Mesh
    from mapper.volume.meshing import surface_mesh
    from mapper.volume.occupancy import Inserted, OccupancyVolume
    from mapper.volume.octree import Octree
    from mapper.volume.octree_files import OctreeFile, octree_file, read_octree, write_octree
    from mapper.volume.parameters import VOLUME_PARAMETERS, VolumeConfig
    from mapper.volume.queries import Casts, cast, distance_to_obstacle, project, voxels_in_box
    from mapper.volume.tsdf import Fused, TsdfVolume
    from mapper.volume.tsdf_parameters import TSDF_PARAMETERS, TsdfConfig

__all__ = [
    "TSDF_PARAMETERS",
    "VOLUME_PARAMETERS",
    "BlockHash",
    "Casts",
    "Changes",
    "Fused",
    "Inserted",
    "Mesh",
    "OccupancyVolume",
    "Octree",
    "OctreeFile",
    "TsdfConfig",
    "TsdfVolume",
    "VolumeConfig",
    "cast",
    "changes_between",
    "distance_to_obstacle",
    "octree_file",
    "project",
    "read_octree",
    "surface_mesh",
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
        "Fused": "mapper.volume.tsdf",
        "Inserted": "mapper.volume.occupancy",
        "OccupancyVolume": "mapper.volume.occupancy",
        "Mesh": "mapper.volume.mesh",
        "Octree": "mapper.volume.octree",
        "OctreeFile": "mapper.volume.octree_files",
        "TSDF_PARAMETERS": "mapper.volume.tsdf_parameters",
        "TsdfConfig": "mapper.volume.tsdf_parameters",
        "TsdfVolume": "mapper.volume.tsdf",
        "VOLUME_PARAMETERS": "mapper.volume.parameters",
        "VolumeConfig": "mapper.volume.parameters",
        "cast": "mapper.volume.queries",
        "changes_between": "mapper.volume.changes",
        "distance_to_obstacle": "mapper.volume.queries",
        "octree_file": "mapper.volume.octree_files",
        "project": "mapper.volume.queries",
        "read_octree": "mapper.volume.octree_files",
        "surface_mesh": "mapper.volume.meshing",
        "voxels_in_box": "mapper.volume.queries",
        "write_octree": "mapper.volume.octree_files",
    },
)
