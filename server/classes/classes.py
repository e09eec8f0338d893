"""All open classes, within limits of number and time."""

from __future__ import annotations

import asyncio
import math
import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from mapper.core.errors import MapperError
from server.classes.classroom import MAX_NUMBERS, Classroom, Member

#: Consonants, so that no words arise, without those that are easily confused.
LETTERS = "BCDFGHJKLMNPQRSTVWXZ"
LENGTH = 6
MAX_CLASSES = 32
MAX_CONNECTIONS = 16  #: of one visitor to one class: pages in several tabs, and lost connections
#: Share of a class's places, and of its numbers, that one network address can use. A lecture hall behind one router has
#: one address, so this suffices for a whole hall: 300 of 400 places. The rest is reserved for other addresses, so that
#: someone who knows the code and opens pages endlessly from one address locks out nobody on another, such as mobile
#: data.
ADDRESS_SHARE = 0.75
LOOK_EVERY_S = 60.0  #: interval of checking for classes that their lecturers have left
LONGEST_ABSENCE_S = 2 * 3600.0  #: a class ends after this time without its lecturer
LOOK_FOR_PREPARED_S = 0.5  #: interval of checking whether another process has the prepared class


def new_code() -> str:
    """Return a random code, one of 64 million."""
    return "".join(secrets.choice(LETTERS) for _ in range(LENGTH))


def normalised(code: str) -> str:
    """Return a code in its canonical form. The typed code may have small letters, blanks and dashes."""
    return code.replace(" ", "").replace("-", "").upper()[:32]


class Prepared(Protocol):
    """Holder of a class that is open from the start (``gridbloom serve --class``), in one process or among several.

    The first visitor who opens a class takes it over.
    """

    code: str

    @property
    def waits_here(self) -> bool:
        """Whether nobody has taken the class over, and requests with its code reach this process."""

    def take_over(self) -> bool:
        """Take the class over for a visitor of this process; return False if it was taken before."""


class PreparedHere:
    """The prepared class of a service with one process."""

    def __init__(self, code: str) -> None:
        self.code = code
        self.waits_here = True

    def take_over(self) -> bool:
        """Take the class over; return False if it was taken before."""
        waited, self.waits_here = self.waits_here, False
        return waited


class ClassNotFoundError(MapperError):
    """There is no class with that code; it may have ended."""


class ClassRightError(MapperError):
    """The class is locked, or its lecturer has signed out."""


class ClassBudgetError(MapperError):
    """There is no room for another class, or for another follower."""


class Classes:
    """Opens, finds and ends classes. Used from the event loop only."""

    def __init__(
        self,
        max_followers: int,
        prepared: Prepared | None = None,
        clock: Callable[[], float] = time.monotonic,
        is_own: Callable[[str], bool] = lambda _: True,
    ) -> None:
        """``prepared`` is a class that is open from the start; the first visitor who opens a class takes it over.

        ``is_own`` returns whether requests with a code reach this process.
        """
        self._max_followers = max_followers
        self._is_own = is_own
        self._clock = clock
        self._classes: dict[str, Classroom] = {}
        self._prepared = prepared
        self.find_prepared()

    @property
    def most_of_address(self) -> int:
        """Maximum number of followers of a class from one address."""
        return math.ceil(ADDRESS_SHARE * self._max_followers)

    def open(self, owner: str) -> Classroom:
        """Return the class of a visitor, a new one if there is none. Raises :class:`ClassBudgetError`."""
        self.end_abandoned()
        own = self.of(owner)
        if own is None and self._prepared is not None and self._prepared.take_over():
            own = self._classes.setdefault(self._prepared.code, Classroom(self._prepared.code, None, self._clock))
        if own is not None:
            own.owner = owner
            own.lecturer_seen = self._clock()
            return own
        if len(self._classes) >= MAX_CLASSES:
            raise ClassBudgetError("class.full", f"{MAX_CLASSES} classes are open, the maximum.")
        code = new_code()
        while code in self._classes or not self._is_own(code):
            code = new_code()
        classroom = self._classes[code] = Classroom(code, owner, self._clock)
        return classroom

    def find(self, code: str) -> Classroom | None:
        """Return a class, None if there is none."""
        return self._classes.get(normalised(code))

    def get(self, code: str) -> Classroom:
        """Return a class. Raises :class:`ClassNotFoundError`."""
        classroom = self.find(code)
        if classroom is None:
            raise unknown_class()
        return classroom

    def joined(self, code: str, visitor: str) -> Classroom | None:
        """Return a class that a visitor has joined; None for any other code."""
        classroom = self.find(code)
        return classroom if classroom is not None and classroom.knows(visitor) else None

    def owned(self, code: str, visitor: str) -> Classroom | None:
        """Return a class to its lecturer; None for any other code, and for anyone else."""
        classroom = self.find(code)
        return classroom if classroom is not None and classroom.owner == visitor else None

    def of(self, owner: str) -> Classroom | None:
        """Return the class of a visitor."""
        return next((class_ for class_ in self._classes.values() if class_.owner == owner), None)

    def check(self, classroom: Classroom, visitor: str, address: str = "") -> None:
        """Raise :class:`ClassRightError` or :class:`ClassBudgetError` if a visitor cannot join a class.

        ``address`` is that of the visitor's network, empty if unknown. Earlier members can return.
        """
        if classroom.knows(visitor):
            return
        if classroom.is_locked:
            raise ClassRightError("class.locked", "The lecturer has locked this class: nobody else can join.")
        if classroom.places_taken(self.most_of_address) >= self._max_followers or classroom.is_full:
            raise ClassBudgetError("class.crowded", "This class is full.")
        is_greedy = classroom.given_to(address) >= ADDRESS_SHARE * MAX_NUMBERS
        if classroom.present_of(address) >= self.most_of_address or is_greedy:
            raise _crowded_address()

    @contextmanager
    def watching(self, classroom: Classroom, address: str) -> Iterator[None]:
        """Count a connection to the session that a class shows.

        Raises :class:`ClassBudgetError` if an address has as many connections as it may have followers.
        """
        if classroom.watching_from(address) >= self.most_of_address:
            raise _crowded_address()
        with classroom.watching(address):
            yield

    def join(self, code: str, visitor: str, address: str = "", *, follows: bool = False) -> tuple[Classroom, Member]:
        """Join a class; ``follows`` is as in :meth:`Classroom.join`.

        Raises like :meth:`get` and :meth:`check`, and for too many connections of a visitor.
        """
        classroom = self.get(code)
        self.check(classroom, visitor, address)
        if classroom.connections_of(visitor) >= MAX_CONNECTIONS:
            raise ClassBudgetError("class.connections", "This browser follows the class in too many pages: close one.")
        return classroom, classroom.join(visitor, address, follows=follows)

    def close(self, classroom: Classroom) -> None:
        """End a class, and delete all of its data."""
        self._classes.pop(classroom.code, None)
        classroom.end()

    async def watch(self) -> None:
        """Periodically end the classes that their lecturers have left, until cancelled."""
        while True:
            self.end_abandoned()
            await asyncio.sleep(LOOK_EVERY_S)

    async def watch_prepared(self) -> None:
        """Periodically check where the prepared class is, because another process may have taken it over."""
        while True:
            self.find_prepared()
            await asyncio.sleep(LOOK_FOR_PREPARED_S)

    def find_prepared(self) -> None:
        """Hold the prepared class while it waits here for its lecturer; otherwise redirect its followers."""
        if self._prepared is None:
            return
        code = self._prepared.code
        if self._prepared.waits_here:
            self._classes.setdefault(code, Classroom(code, None, self._clock))
        elif (classroom := self._classes.get(code)) is not None and classroom.owner is None:
            self._classes.pop(code).move()

    def end_abandoned(self) -> None:
        """End the classes that were without their lecturer for longer than :data:`LONGEST_ABSENCE_S`."""
        oldest = self._clock() - LONGEST_ABSENCE_S
        for class_ in [*self._classes.values()]:
            if class_.owner is not None and not class_.has_lecturer and class_.lecturer_seen < oldest:
                self.close(class_)


def unknown_class() -> ClassNotFoundError:
    """Return the error for an unknown code, and for a class that is not the visitor's."""
    return ClassNotFoundError("class.unknown", "There is no class with this code; it may have ended.")


def _crowded_address() -> ClassBudgetError:
    return ClassBudgetError(
        "class.crowded_address",
        "This class has no more room for your network. Another network, such as mobile data, may have room.",
    )
