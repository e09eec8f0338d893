"""The stream's commands and messages of a 3D map."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from server.stream.message_parts import (
    CellState,
    ColourScale,
    Number,
    Parameter,
    Place,
    SurfaceUpdate,
    Table,
    UncheckedValues,
    Values,
    VolumeChanges,
    VoxelPoint,
    VoxelUpdate,
)


class Map3dCommand(Struct, tag_field="type", tag="map3d"):
    """Simulations: begin a 3D map from the robot's 3D sensor, change it, or end it."""

    value: Annotated[bool, Meta(description="whether there is one")] = True
    values: Annotated[
        UncheckedValues, Meta(description="parameters of the sensor and the map to change; the others stay")
    ] = {}


class VolumeLookCommand(Struct, tag_field="type", tag="volume_look"):
    """Sessions in 3D: change the display options."""

    values: Annotated[UncheckedValues, Meta(description="new values; the others stay")]


class SurfaceCommand(Struct, tag_field="type", tag="surface"):
    """Sessions in 3D: change parameters of the surface, which is then recomputed."""

    values: Annotated[UncheckedValues, Meta(description="new values; the others stay")]


class VoxelCommand(Struct, tag_field="type", tag="voxel"):
    """Sessions in 3D: ask why the voxel at a place has its state; answered with `voxel`. Null: choose none."""

    x: Annotated[Number | None, Meta(description="x in the map frame, m")] = None
    y: Annotated[Number | None, Meta(description="y in the map frame, m")] = None
    z: Annotated[Number | None, Meta(description="z in the map frame, m")] = None


class VoxelRayCommand(Struct, tag_field="type", tag="voxel_ray"):
    """Sessions in 3D: ask for the first voxel that a line of sight meets; answered with `voxel`."""

    origin: Annotated[tuple[Number, Number, Number], Meta(description="where it begins, m")]
    direction: Annotated[tuple[Number, Number, Number], Meta(description="where it goes")]


class VolumeKeepCommand(Struct, tag_field="type", tag="volume_keep"):
    """Sessions in 3D: keep the current map to compare later ones with it, or end the comparison."""

    value: Annotated[bool, Meta(description="whether to compare")] = True


class Map3dMessage(Struct, tag_field="type", tag="map3d"):
    """The 3D map of a simulation. Cells that are only in this map are in the layer `only_in_3d`."""

    is_on: Annotated[bool, Meta(description="whether there is one")]
    values: Annotated[Values, Meta(description="parameters of the 3D sensor and the map")]
    scans: Annotated[int, Meta(description="scans in the map")]
    taken: Annotated[int, Meta(description="scans that are recorded; more than `scans` while the map is made again")]
    only_in_3d: Annotated[int, Meta(description="cells of its projection that are occupied, and are not in the 2D map")]
    problem: Annotated[str | None, Meta(description="why it does not grow any more; null: it does")]
    known: Annotated[int, Meta(description="free and occupied voxels")]
    nodes: Annotated[int, Meta(description="nodes of its octree, whose equal leaves are joined")]
    leaves: Annotated[int, Meta(description="those without children")]
    octree_bytes: Annotated[int, Meta(description="the octree: log-odds and children of each node")]
    block_bytes: Annotated[int, Meta(description="the map as it is kept: blocks of 8 × 8 × 8 voxels, and their hash")]
    dense_bytes: Annotated[int, Meta(description="a dense grid of the world, 4 bytes for each voxel")]


class VolumeMessage(Struct, tag_field="type", tag="volume"):
    """Sessions in 3D: the contents of the map and its display options. Sent at the start and after changes."""

    look: Annotated[Table, Meta(description="what is shown, and how")]
    low: Annotated[Place, Meta(description="least coordinates of the map, m")]
    high: Annotated[Place, Meta(description="greatest coordinates of the map, m")]
    has_scans: Annotated[bool, Meta(description="whether it is made of scans; else it is an octree")]
    has_free: Annotated[bool, Meta(description="whether it is known where the sensor was, so that space is free")]
    up: Annotated[str, Meta(description="the axis of the file that is z here")]
    points: Annotated[int, Meta(description="points of the scans in the map; leaves of an octree")]
    left_out: Annotated[int, Meta(description="points that were left out: beyond the lattice")]
    occupied: Annotated[int, Meta(description="voxels")]
    free: Annotated[int, Meta(description="voxels")]
    bytes: Annotated[int, Meta(description="memory of the map in blocks of 8³ voxels")]
    dense_bytes: Annotated[float, Meta(description="memory of a dense grid of the same box, 4 bytes a voxel")]
    nodes: Annotated[int | None, Meta(description="nodes of the pruned octree; null while the map changes")]
    chunks: Annotated[int, Meta(description="chunks of 32³ voxels that are drawn")]
    quads: Annotated[int, Meta(description="rectangles that are drawn")]
    pending: Annotated[int, Meta(description="chunks that are still to be drawn again")]
    colours: Annotated[list[str], Meta(description="what the points can be coloured by")]
    scale: Annotated[
        ColourScale | None, Meta(description="of the colours by intensity, time or difference; null: not known, others")
    ]
    compared: Annotated[VolumeChanges | None, Meta(description="the comparison with another map; null: there is none")]


class VoxelMessage(Struct, tag_field="type", tag="voxel"):
    """Answer to `voxel` and to a click in 3D, for all clients: why a voxel has its state. Null: none is chosen."""

    centre: Annotated[Place | None, Meta(description="its centre, m")]
    size: Annotated[float, Meta(description="its side, m")]
    log_odds: Annotated[float | None, Meta(description="log-odds of being occupied; null: unknown")]
    state: Annotated[CellState, Meta(description="state by the map's threshold")]
    index: Annotated[int, Meta(description="scans in the map")]
    total: Annotated[int, Meta(description="scans that updated it")]
    hits: Annotated[int, Meta(description="those of which a beam ended in it")]
    updates: Annotated[list[VoxelUpdate], Meta(description="at most the last 200, oldest first")]
    point: Annotated[VoxelPoint | None, Meta(description="a point in it; null: it has none")] = None


class SurfaceMessage(Struct, tag_field="type", tag="surface"):
    """Sessions in 3D: the surface from truncated signed distances. Sent at the start and after changes.

    A simulation sends it while its surface is shown; its parameters are those of the 3D map.
    """

    table: Annotated[list[Parameter], Meta(description="its parameters; empty where no surface can be made")]
    values: Annotated[Values, Meta(description="their present values")]
    truncation: Annotated[float, Meta(description="truncation that is used, m")]
    index: Annotated[int, Meta(description="scans in the surface")]
    blocks: Annotated[int, Meta(description="blocks of 8³ voxels")]
    bytes: Annotated[int, Meta(description="memory of the blocks")]
    triangles: Annotated[int, Meta(description="triangles that are drawn")]
    chunks: Annotated[int, Meta(description="chunks of 32³ voxels that have triangles")]
    pending: Annotated[int, Meta(description="chunks that are still to be meshed again")]
    snapshots: Annotated[list[int], Meta(description="scans after which the surface is kept, to go back to")]
    problem: Annotated[str | None, Meta(description="why it is not drawn; null: it is")]


class SurfaceVoxelMessage(Struct, tag_field="type", tag="surface_voxel"):
    """Answer to `voxel` and to a click in 3D while the surface is shown, for all clients. Null: none is chosen."""

    centre: Annotated[Place | None, Meta(description="its centre, m")]
    size: Annotated[float, Meta(description="its side, m")]
    distance: Annotated[float | None, Meta(description="mean signed distance, m, positive before; null: unknown")]
    weight: Annotated[float, Meta(description="weight of the mean")]
    index: Annotated[int, Meta(description="scans in the surface")]
    total: Annotated[int, Meta(description="scans that measured it")]
    updates: Annotated[list[SurfaceUpdate], Meta(description="at most the last 200, oldest first")]


COMMANDS = (Map3dCommand, VolumeLookCommand, SurfaceCommand, VoxelCommand, VoxelRayCommand, VolumeKeepCommand)
MESSAGES = (Map3dMessage, VolumeMessage, SurfaceMessage, SurfaceVoxelMessage, VoxelMessage)
