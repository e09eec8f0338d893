"""Scans of several sensors that are added by turns, as updates take them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mapper.mapping.kernels.types import Scans
from mapper.mapping.scan_batch import part_of
from mapper.mapping.update_plan import UpdatePlan

Run = tuple[int, int, int]  #: a sensor's number, and its scans [first, stop)


@dataclass(frozen=True, slots=True)
class Turns:
    """The scans of each of ``sensors``, with the plan of their update, and in which ``runs`` they follow one another.

    The scans of a sensor come in their order, each once.
    """

    sensors: Sequence[tuple[Scans, UpdatePlan]]
    runs: Sequence[Run]

    @classmethod
    def of_one(cls, scans: Scans, plan: UpdatePlan) -> Turns:
        """Return the scans of one sensor."""
        return cls([(scans, plan)], [(0, 0, len(scans.ranges))])

    @property
    def readings(self) -> int:
        """Number of readings."""
        return sum(scans.ranges.size for scans, _ in self.sensors)

    @property
    def pieces(self) -> list[tuple[Scans, UpdatePlan]]:
        """The scans of each run, with their plan."""
        return [(part_of(self.sensors[k][0], first, stop), self.sensors[k][1]) for k, first, stop in self.runs]
