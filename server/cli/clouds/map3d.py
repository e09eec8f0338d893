"""``map3d``: a map of occupied and free voxels from point clouds, and the contents of an octree file."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from msgspec import Struct, to_builtins

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError, MapperError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.clouds.given_poses import GivenPoses
from mapper.io.clouds.reading import cloud_format
from mapper.volume import OccupancyVolume, Octree, OctreeFile, octree_file, project, write_octree
from mapper.volume.mesh.faces import voxel_mesh
from mapper.volume.occupancy.parameters import VOLUME_PARAMETERS, VolumeConfig
from mapper.volume.octree.files import is_octree, read_octree
from mapper.volume.scans.map_offset import MapOffset, georeferenced, offset_notes
from mapper.volume.scans.sources import Insertion, file_head, insert_all, open_source, refuse_poses
from mapper.volume.surface.parameters import TSDF_PARAMETERS
from server.cli.clouds.surface import MESHES, map_surface, write_mesh_file
from server.cli.commands import app
from server.cli.common import (
    AsJson,
    TfTopic,
    TrajectoryName,
    configured,
    fail,
    given_parameters,
    given_values,
    numbers,
    print_json,
    print_notes,
    progress_bar,
    refusing,
    with_parameter_options,
)
from server.cli.map_files import save

_ROWS = {row.name: row for row in VOLUME_PARAMETERS}
KINDS = (".bt", ".ot")
OF_SURFACES = tuple(row for row in TSDF_PARAMETERS if row.name not in _ROWS)  # the parameters that octrees do not have


@app.command()
@with_parameter_options("time_offset", more=(*VOLUME_PARAMETERS, *OF_SURFACES))
def map3d(
    inputs: Annotated[
        list[Path],
        typer.Argument(
            metavar="INPUT...",
            help="Clouds, scan graphs, folders of depth images and recordings with point clouds; an octree (.bt, .ot) "
            "first is the map to go on with.",
        ),
    ],
    out: Annotated[
        list[Path],
        typer.Option(
            metavar="PREFIX.bt|.ot|.ply|.glb",
            help="Write an octree of OctoMap, or a mesh: of the occupied voxels, or of the surface; may be repeated.",
        ),
    ],
    projection: Annotated[
        Path | None,
        typer.Option("--map", metavar="PREFIX", help="Write PREFIX.yaml and PREFIX.pgm, the map from above."),
    ] = None,
    band: Annotated[
        str | None,
        typer.Option(
            metavar="LOW,HIGH", help="The heights of the map from above (m, m); equal ones are a slice. [all]"
        ),
    ] = None,
    topic: Annotated[
        str | None, typer.Option(metavar="NAME", help="The clouds of a recording that has several.")
    ] = None,
    tf: TfTopic = None,
    trajectory: TrajectoryName = None,
    sensor: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z", help="Where the sensor of a cloud's file was (m, m, m), if the file does not say it."
        ),
    ] = None,
    poses_file: Annotated[
        Path | None,
        typer.Option(
            "--poses",
            metavar="POSES.tum",
            help="Poses of the sensor: one for each cloud's file, in order, whose points are in the sensor's frame; or "
            "those of a recording, by their times.",
        ),
    ] = None,
    tsdf: Annotated[
        bool, typer.Option("--tsdf", help="Fuse a surface of truncated signed distances instead of occupied voxels.")
    ] = False,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - the table's
) -> None:
    """Map point clouds in three dimensions: occupied voxels as OctoMap does, or with --tsdf a surface as a mesh."""
    heights = None if band is None else numbers("--band", "two numbers, LOW,HIGH in metres", 2, band)
    place = None if sensor is None else np.array(numbers("--sensor", "three numbers, X,Y,Z in metres", 3, sensor))
    if poses_file is not None and trajectory is not None:
        fail("--poses and --trajectory are both the poses of a recording; give one of them.")
    poses = None if poses_file is None else _poses(poses_file, inputs, place)
    time_offset = configured(given_parameters({"time_offset": parameters.pop("time_offset")})).time_offset
    typed = {name: value for name, value in parameters.items() if value is not None}
    if tsdf:
        if projection is not None or band is not None:
            fail("--map and --band are of occupied voxels and have no meaning with --tsdf.")
        map_surface(
            inputs,
            out,
            typed,
            topic=topic,
            tf=tf,
            trajectory=trajectory,
            time_offset=time_offset,
            sensor=place,
            poses=poses,
            as_json=as_json,
        )
        return
    endings = (*KINDS, *MESHES)
    for path in out:
        if path.suffix not in endings:
            fail(f"--out must end in {', '.join(endings[:-1])} or {endings[-1]}, not {path.name!r:.80}.")
    for row in OF_SURFACES:
        if row.name in typed:
            fail(f"--{row.name.replace('_', '-')} is of surfaces: it needs --tsdf.")
    values = given_values(_ROWS, typed)
    began = time.process_time()
    read = _first_octree(inputs[0])
    if read is not None:
        values.setdefault("resolution", read.tree.resolution)
    try:
        config = VolumeConfig(**values)
        if read is not None and config.resolution != read.tree.resolution:
            raise ConfigError(
                "volume.resolutions",
                f"The voxels of {inputs[0].name} are of {read.tree.resolution:g} m, not {config.resolution:g} m.",
            )
    except MapperError as error:
        fail(error.message)
    scans, notes = Insertion(), [] if read is None else [*read.notes]
    offset = MapOffset(None if read is None else read.offset)
    rest = inputs if read is None else inputs[1:]
    with refusing(inputs[0]):
        meshes = any(path.suffix in MESHES for path in out)
        # An octree may exceed the size limit of maps.
        from_tree = read is not None and (rest or projection is not None or meshes)
        volume = read.tree.volume(config) if read is not None and from_tree else OccupancyVolume(config)
    posed = 0  # number of clouds so far, each of which uses one of the poses
    for path in rest:
        with refusing(path), progress_bar(f"Mapping {path.name}") as bar:
            source = open_source(
                path,
                topic=topic,
                tf=tf,
                trajectory=trajectory,
                time_offset=time_offset,
                sensor=place,
                poses=poses,
                number=posed,
                offset=offset,
            )
            posed += source.given_poses
            insert_all(volume, source, scans, bar)
        notes += [f"{path.name}: {note}" for note in source.notes]
    tree = read.tree if read is not None and not rest else Octree.of(volume)
    files = [
        write_mesh_file(voxel_mesh(volume), path, offset.value)
        if path.suffix in MESHES
        else _write(path, tree, config, read if not rest else None, offset.value)
        for path in out
    ]
    if projection is not None:
        files += _write_projection(volume, projection, heights, inputs[0], offset.value)
    notes += offset_notes(offset.value)
    facts, cpu_s = TreeFacts.of(tree, config), time.process_time() - began
    if as_json:
        print_json(
            {
                "inputs": [str(path) for path in inputs],
                "scans": scans.scans,
                "points": scans.points,
                "left_out": scans.left_out,
                **to_builtins(facts),
                "cpu_seconds": round(cpu_s, 3),
                "files": [str(path) for path in files],
                "notes": notes,
            }
        )
        return
    if rest:
        typer.echo(
            f"{scans.scans} scan{'s' if scans.scans != 1 else ''}, {scans.points} points"
            + (f", {scans.left_out} left out" if scans.left_out else "")
        )
    else:
        typer.echo(f"{inputs[0].name}: an octree, without scans of its own")
    print_tree(facts)
    typer.echo(f"  {cpu_s:.1f} s of processor time")
    for path in files:
        typer.echo(f"  wrote {path}")
    print_notes(notes)


def _poses(path: Path, inputs: list[Path], place: Float64Array | None) -> GivenPoses:
    """Return the poses of a file, or end the command if their number differs from that of the clouds."""
    if place is not None:
        fail("--sensor is the place of one cloud's sensor, and has no meaning with --poses.")
    with refusing(path):
        poses = GivenPoses.read(path)
    clouds = 0
    for source in inputs:
        with refusing(source):
            head = b"" if source.is_dir() else file_head(source, DEFAULT_LIMITS)
            kind = cloud_format(head)
            if kind == "scan graph":
                refuse_poses(poses, source)
        clouds += kind is not None and not is_octree(head)
    if clouds and clouds != len(poses):
        fail(
            f"The number of poses in {path.name}, {len(poses)}, is not that of the clouds, {clouds}; each needs one, "
            "in this order."
        )
    return poses


def _first_octree(path: Path) -> OctreeFile | None:
    """Return the octree in a file, None for a file of another kind."""
    if not path.is_file():
        return None
    with refusing(path), path.open("rb") as file:
        return read_octree(path) if is_octree(file.read(64)) else None


def _write(
    path: Path, tree: Octree, config: VolumeConfig, read: OctreeFile | None, offset: Float64Array | None
) -> Path:
    """Write a tree. An octree that was read and has the same kind is copied byte for byte."""
    with refusing(path):
        same = read is not None and read.kind == path.suffix
        write_octree(
            read if same and read is not None else octree_file(tree, path.suffix, config, offset), path, config
        )
    return path


def _write_projection(
    volume: OccupancyVolume, prefix: Path, heights: list[float] | None, of: Path, offset: Float64Array | None
) -> list[Path]:
    """Write the map from above in the coordinates of the files, which also apply to ``heights``."""
    with refusing(of):
        base = 0.0 if offset is None else float(offset[2])
        grid = project(volume) if heights is None else project(volume, *(height - base for height in heights))
    return save(georeferenced(grid, offset), prefix, "trinary", "map")


class TreeFacts(Struct):
    """The numbers of an octree: its nodes, the voxels of its leaves, and the corners of their bounding box."""

    resolution: float
    nodes: int
    leaves: int
    occupied: int
    free: int
    low: list[float]
    high: list[float]

    @classmethod
    def of(cls, tree: Octree, config: VolumeConfig) -> TreeFacts:
        """Return the numbers of ``tree``; ``config`` determines which leaves are occupied."""
        keys, depths, values = tree.leaves()
        sides = np.int64(1) << (16 - depths.astype(np.int64))
        occupied = values >= config.log_odds_occupied
        voxels = sides.astype(np.float64) ** 3
        low, high = (keys.min(axis=0), (keys + sides[:, None]).max(axis=0)) if len(keys) else (np.full(3, 32768),) * 2
        return cls(
            resolution=tree.resolution,
            nodes=tree.n_nodes,
            leaves=tree.n_leaves,
            occupied=int(voxels[occupied].sum()),
            free=int(voxels[~occupied].sum()),
            low=[round(float(k - 32768) * tree.resolution, 6) for k in low],
            high=[round(float(k - 32768) * tree.resolution, 6) for k in high],
        )


def print_tree(facts: TreeFacts) -> None:
    """Print the numbers of an octree in words."""
    typer.echo(f"  {facts.nodes} nodes, {facts.leaves} of them leaves, voxels of {facts.resolution:g} m")
    typer.echo(f"  {facts.occupied} voxels occupied, {facts.free} free")
    low, high = (", ".join(f"{value:g}" for value in corner) for corner in (facts.low, facts.high))
    typer.echo(f"  from {low} m to {high} m")


def describe_octree(path: Path, *, as_json: bool) -> bool:
    """Print the contents of an octree file; return whether the file is one."""
    read = _first_octree(path)
    if read is None:
        return False
    with refusing(path):
        config = VolumeConfig()
        facts = TreeFacts.of(read.tree, config)
    kind, notes = f"OctoMap {read.kind}", [*read.notes, *offset_notes(read.offset)]
    if as_json:
        print_json({"name": path.name, "format": kind} | to_builtins(facts) | {"notes": notes})
        return True
    typer.echo(f"{path.name}: {kind}")
    print_tree(facts)
    print_notes(notes)
    return True
