"""``costmap``: the costs of Nav2's layers over a map file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import typer

from mapper.core.array_types import Int8Array, UInt8Array
from mapper.costmap import Mask
from mapper.costmap.build import DEFAULT, build_costmap, load_masks
from mapper.costmap.costs import INSCRIBED, LETHAL, NO_INFORMATION
from mapper.costmap.files import save_costmap, save_costmap_mcap
from mapper.costmap.nav2.costmap import Nav2Costmap
from mapper.costmap.nav2.filters import NamedFilter
from mapper.costmap.nav2.reading import parse_nav2_costmap
from mapper.costmap.speed_filter import ABSOLUTE, PERCENTAGE
from mapper.io.maps import load_map
from mapper.io.ros_parameters import read_parameter_file
from server.cli.commands import app
from server.cli.common import AsJson, print_json, print_notes, refusing

KeepoutMask = Annotated[
    Path | None,
    typer.Option("--keepout", metavar="MASK.yaml", help="Mask of a keepout filter, besides those of the parameters."),
]
SpeedMask = Annotated[
    Path | None,
    typer.Option("--speed", metavar="MASK.yaml", help="Mask of a speed filter, besides those of the parameters."),
]
SpeedBase = Annotated[
    float, typer.Option("--speed-base", help="A speed limit is base + multiplier · value of the mask.")
]
SpeedMultiplier = Annotated[float, typer.Option("--speed-multiplier", help="See --speed-base.")]
SpeedAbsolute = Annotated[
    bool, typer.Option("--speed-absolute/--speed-percentage", help="Whether speed limits are m/s, or % of the speed.")
]
UNKNOWN_AS_FREE = "{} cells are unknown in the map and count as free: track_unknown_space is off"


@app.command()
def costmap(
    map_yaml: Annotated[Path, typer.Argument(metavar="MAP.yaml", help="A map file.")],
    out: Annotated[Path, typer.Option(metavar="PREFIX", help="Write PREFIX.pgm (costs 0 … 255) and PREFIX.yaml.")],
    params: Annotated[
        Path | None, typer.Option(metavar="NAV2.yaml", help="Nav2 parameter file; Nav2's defaults without it.")
    ] = None,
    node: Annotated[
        str | None, typer.Option(metavar="NAME", help="Which costmap of the file: global_costmap or local_costmap.")
    ] = None,
    mcap: Annotated[
        Path | None,
        typer.Option(metavar="FILE.mcap", help="Also write nav2_msgs/Costmap and nav_msgs/OccupancyGrid messages."),
    ] = None,
    keepout: KeepoutMask = None,
    speed: SpeedMask = None,
    speed_base: SpeedBase = 0.0,
    speed_multiplier: SpeedMultiplier = 1.0,
    speed_absolute: SpeedAbsolute = False,
    as_json: AsJson = False,
) -> None:
    """Lay Nav2's costmap layers over a map: static layer, inflation, and the robot's footprint."""
    parameters = DEFAULT
    if params is not None:
        with refusing(params):
            parameters = parse_nav2_costmap(read_parameter_file(params), node)
    with refusing(map_yaml):
        loaded = load_map(map_yaml)
    scale = SpeedScale(speed_base, speed_multiplier, speed_absolute)
    parameters, masks = with_masks(parameters, params, loaded.description.frame, keepout, speed, scale)
    with refusing(map_yaml):
        built = build_costmap(loaded.grid.geometry, loaded.values, parameters, masks=masks)
        built.costmap.update()
    costs = built.costmap.costs
    with refusing(out):
        yaml_path, image_path = save_costmap(costs, loaded.grid.geometry, out, loaded.description.frame)
        files = [image_path, yaml_path]
        if mcap is not None:
            save_costmap_mcap(costs, loaded.grid.geometry, mcap, loaded.description.frame)
            files.append(mcap)
    counts = np.bincount(costs.ravel(), minlength=256)
    outline = built.costmap.footprint
    unknown_as_free = count_unknown_as_free(parameters, loaded.values, costs)
    layers = [layer.name for layer in parameters.all_layers()]
    notes = [*loaded.notes, *parameters.notes, *notes_on_masks(masks)]
    facts: dict[str, object] = {
        "map": str(map_yaml),
        "node": parameters.node,
        "layers": layers,
        "inscribed_radius": round(outline.inscribed_radius, 6),
        "circumscribed_radius": round(outline.circumscribed_radius, 6),
        "lethal": int(counts[LETHAL]),
        "inscribed": int(counts[INSCRIBED]),
        "inflated": int(counts[1:INSCRIBED].sum()),
        "free": int(counts[0]),
        "no_information": int(counts[NO_INFORMATION]),
        "unknown_as_free": unknown_as_free,
        "without_effect": list(parameters.unused),
        "filters": [filter_.name for filter_ in parameters.filters],
        "without_mask": list(built.unmasked),
        "speed_limited": sum(int((filter_.mask.on(loaded.grid.geometry) > 0).sum()) for filter_ in built.speed),
        "without_costs": list(built.given),
        "without_readings": list(built.observed),
        "notes": notes,
        "files": [str(path) for path in files],
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{parameters.node}: {', '.join(layers)}")
    typer.echo(
        f"  inscribed radius {facts['inscribed_radius']:.3f} m, "
        f"circumscribed radius {facts['circumscribed_radius']:.3f} m"
    )
    typer.echo(
        f"  {facts['lethal']} lethal, {facts['inscribed']} inscribed, {facts['inflated']} inflated, "
        f"{facts['free']} free, {facts['no_information']} no information"
    )
    if unknown_as_free:
        typer.echo(f"  {UNKNOWN_AS_FREE.format(unknown_as_free)}")
    if parameters.unused:
        typer.echo(f"  parameters that change no cost here: {', '.join(parameters.unused)}")
    if built.speed:
        typer.echo(f"  speed limits in {facts['speed_limited']} cells; they change no cost")
    if built.unmasked:
        typer.echo(f"  filters without a mask: {', '.join(built.unmasked)}")
    if built.given:
        typer.echo(f"  layers without costs, which a terrain gives on the page: {', '.join(built.given)}")
    if built.observed:
        typer.echo(f"  layers without effect here, which take the readings of sensors: {', '.join(built.observed)}")
    for path in files:
        typer.echo(f"  wrote {path}")
    print_notes(notes)


class SpeedScale(NamedTuple):
    """Scale of a speed filter's mask: limits in m/s if ``is_absolute``, otherwise in percent."""

    base: float
    multiplier: float
    is_absolute: bool


def with_masks(
    parameters: Nav2Costmap, params: Path | None, frame: str | None, keepout: Path | None, speed: Path | None,
    scale: SpeedScale,
) -> tuple[Nav2Costmap, Mapping[str, Mask]]:  # fmt: skip
    """Return the parameters with a filter for each given mask, and the masks of all filters by name.

    ``params`` is the parameter file, None without one. A file that is not a mask ends the command with a sentence.
    """
    masks: dict[str, Mask] = {}
    if params is not None:
        with refusing(params):
            masks |= load_masks(parameters, params.parent, frame)
    added = []
    if keepout is not None:
        added.append((keepout, NamedFilter("keepout_mask", "keepout", keepout.name)))
    if speed is not None:
        kind = ABSOLUTE if scale.is_absolute else PERCENTAGE
        added.append((speed, NamedFilter("speed_mask", "speed", speed.name, kind, scale.base, scale.multiplier)))
    for path, filter_ in added:
        with refusing(path):
            masks |= load_masks(replace(parameters, filters=(filter_,)), path.parent, frame)
    return replace(parameters, filters=(*parameters.filters, *(filter_ for _, filter_ in added))), masks


def notes_on_masks(masks: Mapping[str, Mask]) -> list[str]:
    """Return the notes of the readers of the masks' files."""
    return [f"{name}: {note}" for name, mask in masks.items() for note in mask.notes]


def count_unknown_as_free(parameters: Nav2Costmap, values: Int8Array, costs: UInt8Array) -> int:
    """Return how many unknown cells of a map have costs (rows, cols) of free cells or of cells near a wall."""
    return 0 if parameters.general.track_unknown_space else int(((values < 0) & (costs < LETHAL)).sum())
