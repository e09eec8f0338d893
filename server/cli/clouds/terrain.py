"""``terrain``: which points of a cloud are ground, and where a robot may drive on it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from mapper.core.array_types import BoolArray
from mapper.core.errors import ConfigError, MapperError
from mapper.io.clouds import read_cloud
from mapper.sensors.point_cloud import PointCloud
from mapper.terrain import Patches, Terrain, agreement, assess, find_ground, fitted
from mapper.terrain.parameters import GROUND_PARAMETERS, PATCH_PARAMETERS, GroundConfig, PatchConfig
from mapper.terrain.patches import UNKNOWN
from server.cli.commands import app
from server.cli.common import (
    AsJson,
    fail,
    given_values,
    output_file,
    print_json,
    print_notes,
    refusing,
    with_parameter_options,
)
from server.cli.map_files import save

MANY_UNKNOWN = 0.5  #: share of the patches with points above which it is reported
_ROWS = {row.name: row for row in (*GROUND_PARAMETERS, *PATCH_PARAMETERS)}


@app.command()
@with_parameter_options(more=(*GROUND_PARAMETERS, *PATCH_PARAMETERS))
def terrain(
    cloud: Annotated[Path, typer.Argument(metavar="CLOUD", help="A point cloud in metres, z up.")],
    out: Annotated[
        Path,
        typer.Option(
            metavar="PREFIX",
            help="Write PREFIX.npy (uint8 for each point in the file's order, 1 is ground) and the map PREFIX.yaml, "
            "PREFIX.pgm: safe patches free, unsafe ones occupied.",
        ),
    ],
    truth: Annotated[
        Path | None,
        typer.Option(metavar="GROUND.pcd", help="The points that are ground, to compare with: kappa and errors."),
    ] = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - the tables'
) -> None:
    """Find the ground in a point cloud by SMRF, fit planes to its patches, and say which are safe to drive on."""
    values = given_values(_ROWS, parameters)
    try:
        ground_config = GroundConfig(**{row.name: values[row.name] for row in GROUND_PARAMETERS if row.name in values})
        config = PatchConfig(**{row.name: values[row.name] for row in PATCH_PARAMETERS if row.name in values})
    except MapperError as error:
        fail(error.message)
    with refusing(cloud):
        read = read_cloud(cloud)
        began = time.process_time()
        ground = find_ground(read.points, ground_config)
        every = Patches.of(read.points, config.patch)
        points = read.points[ground.is_ground]
        used = points[fitted(points, every, config)]
        terrain = assess(every.emptied().with_points(used), config, occupied=every)
        took = time.process_time() - began
    right = None
    if truth is not None:
        with refusing(truth):
            right = agreement(ground.is_ground, _points_in(read, read_cloud(truth)))
    files = _write(out, ground.is_ground, terrain)
    notes = [*read.notes, *_unknown_patches(every, terrain, config)]
    facts: dict[str, object] = {
        "cloud": str(cloud),
        "points": len(read),
        "ground": int(ground.is_ground.sum()),
        "unsure": int(ground.is_unsure.sum()),
        "left_out": ground.left_out,
        **terrain.counts(),
        **({} if right is None else {name: round(value, 2) for name, value in right.items()}),
        "cpu_seconds": round(took, 3),
        "files": [str(path) for path in files],
        "notes": notes,
    }
    if as_json:
        print_json(facts)
        return
    left_out = f", {ground.left_out} not finite" if ground.left_out else ""
    typer.echo(f"{facts['points']} points, {facts['ground']} of them ground{left_out}; {facts['unsure']} are unsure")
    typer.echo(
        f"  patches of {config.patch:g} m: {facts['safe']} safe, {facts['unsafe']} unsafe, {facts['unknown']} unknown"
    )
    if right is not None:
        typer.echo(
            f"  kappa {right['kappa']:.1f} %, total error {right['total_error']:.1f} %, "
            f"type I {right['type_1']:.1f} %, type II {right['type_2']:.1f} %"
        )
    typer.echo(f"  {took:.2f} s of processor time")
    for path in files:
        typer.echo(f"  wrote {path}")
    print_notes(notes)


def _unknown_patches(every: Patches, terrain: Terrain, config: PatchConfig) -> list[str]:
    """Return a sentence if many of the patches with points are unknown; ``every`` has the points of all."""
    unknown = terrain.classes[every.moments[..., 0] > 0.0] == UNKNOWN
    if unknown.mean() <= MANY_UNKNOWN:
        return []
    sentence = (
        f"{unknown.sum()} of the {len(unknown)} patches with points are unknown: they have fewer than "
        f"{config.min_points:g} points on the ground. Patches longer than {config.patch:g} m (--patch) have more."
    )
    return [sentence]


def _points_in(cloud: PointCloud, truth: PointCloud) -> BoolArray:
    """Return which points (n,) of a cloud are in ``truth``, by equal coordinates."""
    places = {place.tobytes() for place in truth.points.astype(np.float32)}
    is_inside = np.array([place.tobytes() in places for place in cloud.points.astype(np.float32)], dtype=np.bool_)
    if not is_inside.any():
        raise ConfigError("terrain.truth", "None of its points is a point of the cloud.")
    return is_inside


def _write(prefix: Path, is_ground: BoolArray, terrain: Terrain) -> list[Path]:
    files = save(terrain.grid(), prefix, "trinary", "map")
    path = prefix.with_name(prefix.name + ".npy")
    with output_file(path) as file:
        np.save(file, is_ground.astype(np.uint8))
    return [path, *files]
