"""Layers combined with each other first, and then with the layers before them (PluginContainerLayer)."""

from __future__ import annotations

from mapper.core.array_types import UInt8Array
from mapper.costmap.costs import name_of_cost
from mapper.costmap.kernels.observation import lay_over
from mapper.costmap.layered import LayeredCostmap
from mapper.costmap.layers import Robot, part_of
from mapper.costmap.parameters import COMBINATIONS
from mapper.grid.cell_box import CellBox


class ContainerLayer:
    """The combined costs of ``inner``, applied as one layer; NO_INFORMATION where none of its layers has information.

    Its inflation spreads around its own obstacles only. Source: nav2_costmap_2d, plugin_container_layer.cpp. There the
    costs are not reset before an update, so with a method that keeps the greater cost they never decrease; here they
    do.
    """

    def __init__(self, inner: LayeredCostmap, combination_method: str, name: str) -> None:
        self.name, self._inner = name, inner
        self._method = COMBINATIONS.index(combination_method)

    @property
    def costs(self) -> UInt8Array:
        """The combined costs (rows, cols) of its layers."""
        return self._inner.costs

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Update its layers; return the box that changed."""
        return self._inner.update(now, None if robot is None else robot.pose)

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Combine the costs with the master by ``combination_method``."""
        lay_over(self.costs[part_of(box)], self._method, master[part_of(box)])

    def why(self, row: int, col: int) -> str:
        """Describe the combined cost of its layers, and the cost of each."""
        reasons = " ".join(f"{cost.layer}: {cost.sentence}" for cost in self._inner.why(row, col))
        return f"Its layers make {name_of_cost(int(self.costs[row, col]))} together. {reasons}"
