"""Map files written by commands, and statistics of a map."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from mapper.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from mapper.grid.metrics import map_metrics
from mapper.io.logs.foreign import MAP, not_a_log
from mapper.io.maps import load_map, save_map
from mapper.sensors.georeference import NO_OFFSET, Offset
from server.cli.common import fail, print_json, print_notes, refusing

MODES = ("trinary", "scale", "raw")
MapMode = Annotated[str, typer.Option("--mode", metavar="|".join(MODES), help="Kind of map file.")]
MOST_HEAD = 1 << 16  #: bytes of a yaml that are searched for its keys
OUT_HELP = "Write PREFIX.yaml and its image, PREFIX.pgm (in mode scale PREFIX.png)."


def check_mode(mode: str) -> None:
    """End the command with an error for an unknown kind of map file."""
    if mode not in MODES:
        fail(f"--mode must be trinary, scale or raw, not {mode!r:.40}.")


def save(
    grid: OccupancyGrid,
    prefix: Path,
    mode: Any,  # noqa: ANN401 - checked by the caller
    frame: str | None = None,
    offset: Offset = NO_OFFSET,
) -> list[Path]:
    """Write a map, with the name of its frame if it is known; return the paths of its image and its yaml.

    ``offset`` (x, y) is added to its origin.
    """
    with refusing(prefix):
        yaml_path, image_path = save_map(grid, prefix, mode, frame=frame, offset=offset)
    return [image_path, yaml_path]


def states(grid: OccupancyGrid) -> dict[str, float]:
    """Return the number of cells in each state, and the information of the map in bits."""
    metrics = map_metrics(grid)
    return {
        "occupied": metrics.occupied,
        "free": metrics.free,
        "unknown": metrics.unknown,
        "entropy_bits": round(metrics.entropy_bits, 1),
        "information_gain_bits": round(metrics.information_gain_bits, 1),
    }


def describe_map(path: Path, *, as_json: bool) -> bool:
    """Print the properties of the map that a yaml describes; return whether the file is such a yaml."""
    if path.suffix.lower() not in {".yaml", ".yml"} or not path.is_file():
        return False

    with refusing(path):
        with path.open("rb") as file:
            is_map = not_a_log(file.read(MOST_HEAD)).code == MAP
        if not is_map:
            return False
        loaded = load_map(path)
    description, geometry, values = loaded.description, loaded.grid.geometry, loaded.values
    counts = {"occupied": values == OCCUPIED, "free": values == FREE, "unknown": values == UNKNOWN}
    n_cells = {name: int(cells.sum()) for name, cells in counts.items()}
    n_cells["between"] = values.size - sum(n_cells.values())
    facts: dict[str, object] = {
        "name": path.name,
        "format": f"map, {description.mode}",
        "image": description.image,
        "width": geometry.cols,
        "height": geometry.rows,
        "resolution": geometry.resolution,
        "origin": list(geometry.origin),
        "negate": description.negate,
        "occupied_thresh": description.occupied_thresh,
        "free_thresh": description.free_thresh,
        "frame": description.frame,
        **n_cells,
        "notes": list(loaded.notes),
    }
    if as_json:
        print_json(facts)
        return True
    wide, high = geometry.cols * geometry.resolution, geometry.rows * geometry.resolution
    typer.echo(f"{path.name}: {facts['format']}, of the image {description.image}")
    typer.echo(f"  {geometry.size_text} cells of {geometry.resolution:g} m: {wide:.2f} × {high:.2f} m")
    place = ", ".join(f"{value:.10g}" for value in geometry.origin)
    typer.echo(f"  origin {place} (m, m, rad)" + ("" if description.frame is None else f", frame {description.frame}"))
    typer.echo(
        f"  occupied above {description.occupied_thresh:g}, free below {description.free_thresh:g}"
        + (", negated: dark is free" if description.negate else "")
    )
    shares = [f"{n} {name} ({100.0 * n / values.size:.1f} %)" for name, n in n_cells.items() if n or name != "between"]
    typer.echo(f"  {', '.join(shares)}")
    print_notes(loaded.notes)
    return True
