"""Options for the masks of Nav2's keepout filter and speed filter, for the commands that lay a costmap over a map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from server.cli.common import refusing

if TYPE_CHECKING:
    from mapper.core.array_types import Int8Array, UInt8Array
    from mapper.costmap import Mask
    from mapper.costmap.nav2_costmap import Nav2Costmap

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


class SpeedScale(NamedTuple):
    """Scale of a speed filter's mask: limits in m/s if ``is_absolute``, else in percent."""

    base: float
    multiplier: float
    is_absolute: bool


def with_masks(
    parameters: Nav2Costmap, params: Path | None, frame: str | None, keepout: Path | None, speed: Path | None,
    scale: SpeedScale,
) -> tuple[Nav2Costmap, Mapping[str, Mask]]:  # fmt: skip
    """Return the parameters with a filter for each mask that is given, and the masks of all filters by their names.

    ``params`` is the parameter file, None without one. A file that is no mask ends the command with a sentence.
    """
    from mapper.costmap.build import load_masks  # noqa: PLC0415 - start-up
    from mapper.costmap.nav2_filters import NamedFilter  # noqa: PLC0415 - start-up
    from mapper.costmap.speed_filter import ABSOLUTE, PERCENTAGE  # noqa: PLC0415 - start-up

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
    for path, one in added:
        with refusing(path):
            masks |= load_masks(replace(parameters, filters=(one,)), path.parent, frame)
    return replace(parameters, filters=(*parameters.filters, *(one for _, one in added))), masks


def notes_on_masks(masks: Mapping[str, Mask]) -> list[str]:
    """Return the notes of the readers of the masks' files."""
    return [f"{name}: {note}" for name, mask in masks.items() for note in mask.notes]


def count_unknown_as_free(parameters: Nav2Costmap, values: Int8Array, costs: UInt8Array) -> int:
    """Return how many cells that a map does not know a costmap's costs (rows, cols) have as free, or as near a wall."""
    from mapper.costmap.costs import LETHAL  # noqa: PLC0415 - start-up

    return 0 if parameters.general.track_unknown_space else int(((values < 0) & (costs < LETHAL)).sum())
