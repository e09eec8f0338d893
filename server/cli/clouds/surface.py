"""``map3d --tsdf``: a surface of truncated signed distances as a mesh; and the contents of a mesh file."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import typer
from msgspec import Struct, to_builtins
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import MapperError, ReadError
from mapper.io.clouds.given_poses import GivenPoses
from mapper.io.clouds.ply import NOT_TRIANGLES, has_faces, read_ply_mesh
from mapper.volume import Mesh, TsdfVolume, surface_mesh
from mapper.volume.mesh.files import write_mesh
from mapper.volume.scans.map_offset import MapOffset, offset_notes
from mapper.volume.surface.parameters import TSDF_PARAMETERS, TsdfConfig
from mapper.volume.surface.sources import Fusions, fuse_all
from server.cli.common import fail, given_values, print_json, print_notes, progress_bar, refusing

ROWS = {row.name: row for row in TSDF_PARAMETERS}
MESHES = (".ply", ".glb")  #: endings of the files


def map_surface(
    inputs: list[Path],
    out: list[Path],
    values: dict[str, object],
    *,
    topic: str | None,
    tf: str | None,
    trajectory: str | None,
    time_offset: float,
    sensor: NDArray[Any] | None,
    poses: GivenPoses | None,
    as_json: bool,
) -> None:
    """Fuse the contents of the inputs, write the surface and print a summary."""
    others = sorted(values.keys() - ROWS.keys())
    if others:
        fail(f"--{others[0].replace('_', '-')} is of occupied voxels and has no meaning with --tsdf.")
    for path in out:
        if path.suffix not in MESHES:
            fail(f"--out must end in {' or '.join(MESHES)} with --tsdf, not {path.name!r:.80}.")
    began = time.process_time()
    try:
        config = TsdfConfig(**given_values(ROWS, values))
    except MapperError as error:
        fail(error.message)
    volume, did, notes, offset = TsdfVolume(config), Fusions(), [], MapOffset()
    for path in inputs:
        with refusing(path), progress_bar(f"Fusing {path.name}") as bar:
            fuse_all(
                volume,
                path,
                did,
                topic=topic,
                tf=tf,
                trajectory=trajectory,
                time_offset=time_offset,
                sensor=sensor,
                poses=poses,
                offset=offset,
                progress=bar,
            )
        notes += [f"{path.name}: {note}" for note in did.notes]
        did.notes.clear()
    mesh = surface_mesh(volume)
    notes += offset_notes(offset.value)
    facts, files = MeshFacts.of(mesh), [str(write_mesh_file(mesh, path, offset.value)) for path in out]
    cpu_s = time.process_time() - began
    if as_json:
        print_json(
            {
                "inputs": [str(path) for path in inputs],
                "scans": did.scans,
                "used": did.used,
                "resolution": config.resolution,
                "truncation": round(float(config.band), 6),
                "blocks": volume.blocks.count,
                **to_builtins(facts),
                "files": files,
                "cpu_seconds": round(cpu_s, 3),
                "notes": notes,
            }
        )
        return
    typer.echo(f"{did.scans} scans, {did.used} depths used")
    blocks, band = volume.blocks.count, round(float(config.band), 6)
    typer.echo(f"  {blocks} blocks of voxels of {config.resolution:g} m, truncation {band:g} m")
    print_mesh(facts)
    typer.echo(f"  {cpu_s:.1f} s of processor time")
    for name in files:
        typer.echo(f"  wrote {name}")
    print_notes(notes)


def write_mesh_file(mesh: Mesh, path: Path, offset: Float64Array | None = None) -> Path:
    """Write a mesh, or end the command with an error."""
    with refusing(path):
        write_mesh(mesh, path, offset)
    return path


class MeshFacts(Struct):
    """The numbers of a mesh: vertices, triangles, their area, and the corners of its bounding box in metres."""

    vertices: int
    triangles: int
    area_m2: float
    low: list[float] | None
    high: list[float] | None

    @classmethod
    def of(cls, mesh: Mesh) -> MeshFacts:
        """Return the numbers of ``mesh``; without vertices it has no corners."""
        corners = (mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) if len(mesh.vertices) else ()
        low, high = ([round(float(v), 6) for v in corner] for corner in corners) if corners else (None, None)
        return cls(len(mesh.vertices), len(mesh.triangles), round(mesh.area, 4), low, high)


def print_mesh(facts: MeshFacts) -> None:
    """Print the numbers of a mesh in words."""
    typer.echo(f"  {facts.triangles} triangles of {facts.vertices} vertices, {facts.area_m2:.2f} m²")
    if facts.low is not None and facts.high is not None:
        low, high = (", ".join(f"{value:.2f}" for value in corner) for corner in (facts.low, facts.high))
        typer.echo(f"  from {low} m to {high} m")


def describe_mesh(path: Path, *, as_json: bool) -> bool:
    """Print the contents of a PLY file with faces; return whether the file is one."""
    if not path.is_file():
        return False
    with refusing(path):
        if not has_faces(path):
            return False
    with refusing(path):
        try:
            vertices, normals, triangles = read_ply_mesh(path)
        except ReadError as error:
            if error.code == NOT_TRIANGLES:  # its vertices are described as a cloud
                return False
            raise
    facts = MeshFacts.of(Mesh(vertices, vertices if normals is None else normals, triangles))
    if as_json:
        named = {"name": path.name, "format": "PLY mesh", "normals": normals is not None}
        print_json(named | to_builtins(facts))
        return True
    typer.echo(f"{path.name}: PLY mesh" + ("" if normals is None else " with normals"))
    print_mesh(facts)
    return True
