"""All classes that are open, within limits of number and time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from mapper.core.errors import MapperError
from server.classes.classroom import Classroom, Member
from server.classes.codes import new_code, normalised

MAX_CLASSES = 32
MAX_CONNECTIONS = 16  #: of one visitor to one class: pages in several tabs, and those that are lost
LOOK_EVERY_S = 60.0  #: time between two looks for classes that their lecturers have left
LONGEST_ABSENCE_S = 2 * 3600.0  #: without its lecturer, after which a class ends


class ClassNotFoundError(MapperError):
    """There is no class of that code; it may have ended."""


class ClassRightError(MapperError):
    """The class belongs to another visitor, or is locked."""


class ClassBudgetError(MapperError):
    """There is no room for another class, or for another follower."""


class Classes:
    """Opens, finds and ends classes. Used from the event loop only."""

    def __init__(
        self, max_followers: int, prepared: str | None = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """``prepared`` is the code of a class that is open from the start; who opens a class first takes it over."""
        self._max_followers = max_followers
        self._clock = clock
        self._classes: dict[str, Classroom] = {}
        if prepared is not None:
            self._classes[prepared] = Classroom(prepared, None, clock)

    def open(self, owner: str) -> Classroom:
        """Return the class of a visitor, a new one if there is none. Raises :class:`ClassBudgetError`."""
        self.end_abandoned()
        for one in self._classes.values():
            if one.owner in (owner, None):
                one.owner = owner
                one.lecturer_seen = self._clock()
                return one
        if len(self._classes) >= MAX_CLASSES:
            raise ClassBudgetError("class.full", f"{MAX_CLASSES} classes are open, the most there may be.")
        code = new_code()
        while code in self._classes:
            code = new_code()
        made = self._classes[code] = Classroom(code, owner, self._clock)
        return made

    def get(self, code: str) -> Classroom:
        """Return a class. Raises :class:`ClassNotFoundError`."""
        found = self._classes.get(normalised(code))
        if found is None:
            raise ClassNotFoundError("class.unknown", "There is no class with this code; it may have ended.")
        return found

    def joined(self, code: str, visitor: str) -> Classroom | None:
        """Return a class that a visitor is in, or was; None for any other code."""
        found = self._classes.get(normalised(code))
        return found if found is not None and found.knows(visitor) else None

    def owned(self, code: str, visitor: str) -> Classroom:
        """Return a class for its lecturer. Raises :class:`ClassRightError` for another visitor."""
        found = self.get(code)
        if found.owner != visitor:
            raise ClassRightError("class.not_yours", "Only the lecturer who opened the class can do that.")
        return found

    def of(self, owner: str) -> Classroom | None:
        """Return the class of a visitor."""
        return next((one for one in self._classes.values() if one.owner == owner), None)

    def check(self, found: Classroom, visitor: str) -> None:
        """Raise :class:`ClassRightError` or :class:`ClassBudgetError` if a visitor cannot join a class."""
        if found.knows(visitor):
            return
        if found.is_locked:
            raise ClassRightError("class.locked", "The lecturer has locked this class: nobody else can join.")
        if found.present >= self._max_followers or found.is_full:
            raise ClassBudgetError("class.crowded", "As many people as may follow this class already do.")

    def join(self, code: str, visitor: str, *, follows: bool = False) -> tuple[Classroom, Member]:
        """Join a class, ``follows`` as in :meth:`Classroom.join`.

        Raises as :meth:`get` and :meth:`check`, and for too many connections of a visitor.
        """
        found = self.get(code)
        self.check(found, visitor)
        if found.connections_of(visitor) >= MAX_CONNECTIONS:
            raise ClassBudgetError("class.connections", "This browser shows the class on as many pages as it may.")
        return found, found.join(visitor, follows=follows)

    def close(self, found: Classroom) -> None:
        """End a class; everything about it is forgotten."""
        self._classes.pop(found.code, None)
        found.end()

    async def watch(self) -> None:
        """End the classes that their lecturers have left, now and then, until cancelled."""
        while True:
            self.end_abandoned()
            await asyncio.sleep(LOOK_EVERY_S)

    def end_abandoned(self) -> None:
        """End the classes without their lecturer for longer than :data:`LONGEST_ABSENCE_S`."""
        oldest = self._clock() - LONGEST_ABSENCE_S
        for one in [*self._classes.values()]:
            if one.owner is not None and not one.has_lecturer and one.lecturer_seen < oldest:
                self.close(one)
