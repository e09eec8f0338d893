"""Sessions being created, with their progress and whether they were cancelled."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from server.work.scheduler import checkpoint


@dataclass(slots=True, eq=False)
class Making:
    """A session being created. The fields may be read from any thread."""

    fraction: float = 0.0  #: completed share of the work, 0 to 1
    watched: Callable[[], tuple[str, float | None]] | None = None  #: the current part of the work, see :meth:`progress`
    is_wanted: bool = True
    began: float = field(default_factory=time.monotonic)

    def may_continue(self) -> bool:
        """Yield to other sessions (worker thread), and return whether the session is still needed."""
        checkpoint()
        return self.is_wanted

    def report(self, fraction: float) -> None:
        """Set the completed share of the work."""
        self.fraction = fraction

    def progress(self) -> tuple[str | None, float | None]:
        """Return the current part of the work (None: the request itself) and its completed share, None if unknown."""
        return (None, self.fraction) if self.watched is None else self.watched()


class UnderWay:
    """The sessions being created, by visitor and by the name that the page chose."""

    def __init__(self) -> None:
        self._all: set[Making] = set()
        self._named: dict[tuple[str, str], Making] = {}

    @contextmanager
    def making(self, visitor: str, name: str | None) -> Iterator[Making]:
        """Return a context with a new entry, listed under ``name`` inside the context and cancelled at its end."""
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
        """Whether no session is being created."""
        return not self._all

    def end(self) -> None:
        """Cancel all of them, when the service ends."""
        for making in self._all:
            making.is_wanted = False

    def get(self, visitor: str, name: str) -> Making | None:
        """Return the entry of that name, None if it does not exist."""
        return self._named.get((visitor, name))
