"""Sessions that are being made: how far each is, and whether anybody still waits for it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from mapper.core.errors import MapperError
from server.work.scheduler import checkpoint


@dataclass(slots=True, eq=False)
class Making:
    """A session that is being made. The fields may be read from any thread."""

    fraction: float = 0.0  #: share of the work that is done
    is_wanted: bool = True
    began: float = field(default_factory=time.monotonic)

    def may_continue(self) -> bool:
        """Let others have their turn (worker thread), and return whether anybody still waits for the session."""
        checkpoint()
        return self.is_wanted

    def report(self, fraction: float) -> None:
        """Note how much of the work is done."""
        self.fraction = fraction


class UnderWay:
    """The sessions that are being made, by their visitor and the name that the visitor's page gave each."""

    def __init__(self) -> None:
        self._all: set[Making] = set()
        self._named: dict[tuple[str, str], Making] = {}

    @contextmanager
    def making(self, visitor: str, name: str | None) -> Iterator[Making]:
        """Return a new one, which can be found under its ``name`` while the block runs, and is unwanted after it."""
        making = Making()
        self._all.add(making)
        if name is not None:
            self._named[visitor, name] = making
        try:
            yield making
        finally:
            making.is_wanted = False
            self._all.discard(making)
            if name is not None and self._named.get((visitor, name)) is making:
                del self._named[visitor, name]

    @property
    def is_empty(self) -> bool:
        """Whether none is being made."""
        return not self._all

    def end(self) -> None:
        """Let all of them end soon: the service does."""
        for making in self._all:
            making.is_wanted = False

    def get(self, visitor: str, name: str) -> Making:
        """Return what is being made. Raises :class:`MapperError` where nothing is under that name."""
        making = self._named.get((visitor, name))
        if making is None:
            raise MapperError("session.not_making", "No session of that name is being made.")
        return making
