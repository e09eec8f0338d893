"""A second map of the same recording, with other parameters; and how both forget what was removed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mapper.grid import CellBox, OccupancyGrid
from mapper.mapping.integrate import Change
from mapper.mapping.parameters import MappingConfig
from mapper.simulation.edits import gone
from mapper.simulation.forgetting import Forgetting, cells_of
from mapper.simulation.worlds import World


@dataclass(slots=True)
class SecondMap:
    """A map with other ``values`` than the first, of true poses and readings, or ``with_faults`` of the first."""

    values: dict[str, Any]
    with_faults: bool
    config: MappingConfig
    grid: OccupancyGrid
    box: CellBox | None = None  #: what changed since the last call of :meth:`changed`; None: nothing
    is_new: bool = True  #: whether everything may have changed since then

    def config_for(self, config: MappingConfig) -> MappingConfig:
        """Return this map's parameters when the first one's are ``config``. Raises as ``with_values`` does."""
        return config.with_values(self.values)

    def begin(self, config: MappingConfig, grid: OccupancyGrid) -> None:
        """Go on with a map that was made again."""
        self.config, self.grid, self.is_new = config, grid, True

    def add(self, change: Change) -> None:
        """Take up what a scan changed."""
        self.is_new |= change.geometry_changed
        if change.box is not None:
            self.box = change.box if self.box is None else self.box | change.box

    def changed(self) -> tuple[bool, CellBox | None]:
        """Return whether all, and else which box, changed since the last call."""
        result = (self.is_new, self.box)
        self.is_new, self.box = False, None
        return result


@dataclass(slots=True)
class Vanishing:
    """Two maps, one clamped and one not, while they forget the same thing."""

    clamped_first: bool  #: whether the session's own map is the clamped one
    first: Forgetting
    second: Forgetting

    @classmethod
    def of(cls, grid: OccupancyGrid, config: MappingConfig, before: World, after: World) -> Vanishing:
        """Begin to watch the cells of what ``after`` lacks. Raises :class:`ConfigError` where the map holds none."""
        cells = cells_of(grid, gone(before, after), config.resolution + 0.5 * config.window)
        places = grid.geometry.cell_to_world(cells).reshape(-1, 2)
        return cls(config.clamp, Forgetting(places), Forgetting(places))

    def look(self, first: OccupancyGrid, second: OccupancyGrid) -> None:
        """Record the share of free cells of both maps after one more scan."""
        self.first.look(first)
        self.second.look(second)


def forgetting_message(vanishing: Vanishing | None) -> dict[str, Any]:
    """Return a ``forgetting`` message; without cells where nothing is watched."""
    message: dict[str, Any] = {"type": "forgetting", "cells": 0, "scans": 0, "with_clamp": None, "without_clamp": None}
    if vanishing is None:
        return message | {"free_with_clamp": 0.0, "free_without_clamp": 0.0}
    pair = (vanishing.first, vanishing.second)
    for name, one in zip(("with_clamp", "without_clamp"), pair if vanishing.clamped_first else pair[::-1], strict=True):
        message |= {name: one.after, f"free_{name}": round(one.free[-1], 4) if one.free else 0.0}
    return message | {"cells": len(vanishing.first.places), "scans": len(vanishing.first.free)}
