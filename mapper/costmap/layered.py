"""Layered costmap: an update passes through the layers, only for the cells that changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError
from mapper.costmap.costs import FREE, NO_INFORMATION
from mapper.costmap.denoise_layer import DenoiseLayer
from mapper.costmap.footprint import Footprint
from mapper.costmap.layers import InflationLayer, Layer, Robot
from mapper.costmap.parameters import CostmapConfig
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry


@dataclass(frozen=True, slots=True)
class CellReason:
    """Contribution of one layer to a cell: its own cost, the costmap's cost after it, and the reason."""

    layer: str
    cost: int
    master: int
    sentence: str


class LayeredCostmap:
    """Costs (rows, cols) uint8 over the cells of ``geometry``, computed from layers.

    ``below`` are combined bottom first; ``inflation`` adds costs around their obstacles; ``above`` are applied to the
    result and not inflated. Source: nav2_costmap_2d, layered_costmap.cpp. Raises :class:`ConfigError` for a layer of
    another shape.
    """

    def __init__(
        self,
        geometry: GridGeometry,
        general: CostmapConfig,
        footprint: Footprint,
        below: Sequence[Layer],
        inflation: InflationLayer | None = None,
        above: Sequence[Layer] = (),
    ) -> None:
        shapes = [(layer.name, layer.costs.shape) for layer in (*below, *above)]
        if inflation is not None:
            shapes.append((inflation.name, inflation.costs.shape))
        for name, shape in shapes:
            if shape != geometry.shape:
                raise ConfigError(
                    "costmap.shape", f"The layer {name!r} has {shape} cells, but the costmap {geometry.shape}."
                )
        self.geometry, self.footprint = geometry, footprint
        self.below, self.inflation, self.above = tuple(below), inflation, tuple(above)
        self._first = NO_INFORMATION if general.track_unknown_space else FREE
        self._under: UInt8Array = np.full(geometry.shape, self._first, dtype=np.uint8)
        self.costs: UInt8Array = self._under.copy()
        self._is_new = True
        denoising = [layer for layer in (*below, *above) if isinstance(layer, DenoiseLayer)]
        self._reach = sum(layer.reach for layer in denoising)  #: cells around a change in which costs may change

    def update(self, now: float = 0.0, pose: tuple[float, float, float] | None = None) -> CellBox | None:
        """Update the costs; return the box of cells that may have changed, or None.

        The first update covers the whole map, even if the layers were used before. ``now`` is in seconds, on the clock
        of the observations. ``pose`` (x, y, yaw) is the robot's in the map; without it no footprint is cleared.
        """
        robot = None if pose is None else Robot(pose, self.footprint)
        boxes = [box for layer in (*self.below, *self.above) if (box := layer.changed(now, robot)) is not None]
        if self._is_new:
            boxes, self._is_new = [CellBox(0, self.geometry.rows, 0, self.geometry.cols)], False
        if not boxes:
            return None
        box = boxes[0]
        for other in boxes[1:]:
            box |= other
        box = box.padded(self._reach, *self.geometry.shape)
        self._under[_part(box)] = self._first
        for layer in self.below:
            layer.lay(self._under, box)
        if self.inflation is not None:
            box = box.padded(self.inflation.radius, *self.geometry.shape)
            self.inflation.spread(self._under, box)
            self.costs[_part(box)] = self.inflation.costs[_part(box)]
        else:
            self.costs[_part(box)] = self._under[_part(box)]
        for layer in self.above:
            layer.lay(self.costs, box)
        return box

    def why(self, row: int, col: int) -> list[CellReason]:
        """Return the contribution of each layer to a cell, bottom first. Raises :class:`ConfigError` for a cell
        outside.
        """
        rows, cols = self.geometry.shape
        if not (0 <= row < rows and 0 <= col < cols):
            raise ConfigError("costmap.cell", f"The cell ({row}, {col}) is not in the costmap of {rows} rows.")
        box = CellBox(row, row + 1, col, col + 1)
        master = np.full(self.geometry.shape, self._first, dtype=np.uint8)
        reasons = []

        def add(layer: Layer | InflationLayer) -> None:
            cost, after = int(layer.costs[row, col]), int(master[row, col])
            reasons.append(CellReason(layer.name, cost, after, layer.why(row, col)))

        for layer in self.below:
            layer.lay(master, box)
            add(layer)
        if self.inflation is not None:
            master[row, col] = self.inflation.costs[row, col]
            add(self.inflation)
        for layer in self.above:
            layer.lay(master, box)
            add(layer)
        return reasons


def _part(box: CellBox) -> tuple[slice, slice]:
    return slice(box.row0, box.row1), slice(box.col0, box.col1)
