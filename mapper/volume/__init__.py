"""Maps in three dimensions: occupied, free and unknown voxels in hashed blocks of 8³, and their octree.

Source: Hornung, Wurm, Bennewitz, Stachniss & Burgard, OctoMap: an efficient probabilistic 3D mapping framework based on
octrees, Autonomous Robots 34, 2013.
"""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later

if TYPE_CHECKING:
    from mapper.volume.blocks import BlockHash
    from mapper.volume.mesh.mesh import Mesh
    from mapper.volume.mesh.meshing import surface_mesh
    from mapper.volume.occupancy.changes import Changes, changes_between
    from mapper.volume.occupancy.parameters import VOLUME_PARAMETERS, VolumeConfig
    from mapper.volume.occupancy.queries import Casts, cast, distance_to_obstacle, project, voxels_in_box
    from mapper.volume.occupancy.volume import Inserted, OccupancyVolume
    from mapper.volume.octree.files import OctreeFile, octree_file, read_octree, write_octree
    from mapper.volume.octree.octree import Octree
    from mapper.volume.surface.parameters import TSDF_PARAMETERS, TsdfConfig
    from mapper.volume.surface.tsdf import Fused, TsdfVolume

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
__getattr__ = imported_later(__name__, __file__)
