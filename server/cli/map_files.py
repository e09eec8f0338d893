"""Map files that commands write, and statistics of a map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mapper.sensors.georeference import NO_OFFSET, Offset
from server.cli.common import fail, refusing

if TYPE_CHECKING:
    from mapper.grid import OccupancyGrid

MODES = ("trinary", "scale", "raw")
MapMode = Annotated[str, typer.Option("--mode", metavar="|".join(MODES), help="Kind of map file.")]
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
    """Write a map, with the name of its frame where that is known; return the paths of its image and its yaml.

    ``offset`` (x, y) is added to its origin.
    """
    from mapper.io.maps import save_map  # noqa: PLC0415 - start-up

    with refusing(prefix):
        yaml_path, image_path = save_map(grid, prefix, mode, frame=frame, offset=offset)
    return [image_path, yaml_path]


def states(grid: OccupancyGrid) -> dict[str, float]:
    """Return how many cells are in which state, and what is known of them in bits."""
    from mapper.grid.metrics import map_metrics  # noqa: PLC0415 - start-up

    found = map_metrics(grid)
    return {
        "occupied": found.occupied,
        "free": found.free,
        "unknown": found.unknown,
        "entropy_bits": round(found.entropy_bits, 1),
        "information_gain_bits": round(found.information_gain_bits, 1),
    }
