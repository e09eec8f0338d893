"""A class that is open from the start, ``gridbloom serve --class``: who opens a class first takes it over."""

from __future__ import annotations

from typing import Protocol


class Prepared(Protocol):
    """Who has a prepared class, in one process or among several."""

    code: str

    @property
    def waits_here(self) -> bool:
        """Whether nobody has taken the class over, and requests with its code reach this process."""

    def take_over(self) -> bool:
        """Take the class over for a visitor of this process; return False where somebody has done so before."""


class PreparedHere:
    """A prepared class of a service of one process."""

    def __init__(self, code: str) -> None:
        self.code = code
        self.waits_here = True

    def take_over(self) -> bool:
        """Take the class over; return False where somebody has done so before."""
        waited, self.waits_here = self.waits_here, False
        return waited
