"""One class: its members, what the lecturer shows, and the current question.

As in the hub of a session there is no queue: each member has a set of the unsent messages in their newest form. A
message is encoded once for all. Followers are identified by the visitor's cookie while the class lasts, so that a phone
that reconnects keeps its number and its answer. Nothing else is stored about them, except how many numbers each network
address was given.
"""

from __future__ import annotations

import asyncio
import re
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import msgspec

from mapper.core.errors import ConfigError
from server.classes.questions import Question
from server.stream.class_messages import (
    AnswerCommand,
    AskCommand,
    ClassCommand,
    ClassError,
    ClassExplained,
    ClassPuzzle,
    ClassSolver,
    ClassState,
    ClassView,
    ClassViewMessage,
    ClassWelcome,
    CloseCommand,
    CountCommand,
    ExplainCommand,
    HandCommand,
    LockCommand,
    RaiseCommand,
    RevealCommand,
    ShowCommand,
    StopCommand,
)

BINS = 10  #: number of parts of the points, 0 to 100, in the results


class RoomPuzzle:
    """A puzzle assigned to a class. ``key`` identifies it; followers do not receive it."""

    def __init__(self, key: str, title: str) -> None:
        self.key = key
        self.title = title
        self.solvers: dict[int, ClassSolver] = {}
        self.progress: dict[int, Any] = {}  #: by number, the ``server.puzzles.game.Progress`` of all attempts

    def message(self, *, lecturer: bool) -> ClassPuzzle:
        """Return the puzzle as seen by the lecturer or a follower."""
        solvers = sorted(self.solvers.values(), key=lambda solver: solver.number)
        solved = sum(solver.is_solved for solver in solvers)
        return ClassPuzzle(self.title, len(solvers), solved, solvers if lecturer else [])

    @property
    def counts(self) -> list[int]:
        """The number of followers in each of :data:`BINS` equal parts of the points, the last one with 100."""
        counts = [0] * BINS
        for solver in self.solvers.values():
            counts[min(BINS - 1, solver.points * BINS // 100)] += 1
        return counts


STATE_EVERY_S = 0.2  #: least time between two messages of the state
AWAY_AFTER_S = 3.0  #: without a page of the lecturer; changing pages takes less
MAX_QUESTIONS = 200
MAX_NUMBERS = 10_000  #: of followers while the class lasts; a follower who drops the cookie gets another number
#: Commands with which a follower may drive the robot that was handed over.
DRIVERS_COMMANDS = frozenset({"drive", "teleport", "auto"})
#: The part of the lecturer's page address that followers receive.
_PLACE = re.compile(r"(\?present)?(#[A-Za-z0-9_-]{0,100}(/[0-9]{1,4})?)?")
_encoder = msgspec.json.Encoder()


class Member:
    """One connection of the lecturer or of a follower."""

    def __init__(self, number: int, address: str = "") -> None:
        self.number = number  #: 0 for the lecturer
        self.address = address  #: of its network
        self.wake = asyncio.Event()
        self.unsent: set[str] = set()
        self.answers: list[str] = []

    def send(self, message: ClassWelcome | ClassError) -> None:
        """Send a message to this member only."""
        self.answers.append(_encoder.encode(message).decode())
        self.wake.set()


class Classroom:
    """A class. Used from the event loop only."""

    def __init__(self, code: str, owner: str | None, clock: Callable[[], float] = time.monotonic) -> None:
        self.code = code
        self.owner = owner  #: the lecturer's visitor id; None until someone takes the class over
        self.place = ""  #: the key by which a reverse proxy chose this service when the class was opened
        self.session: str | None = None  #: id of the shown session
        self.stage = 0  #: number of that session, from 1
        self.stage_over = asyncio.Event()  #: set once that session is no longer shown
        self.view = ClassView("other")
        self.is_locked = self.has_ended = self.counts_joined_only = False
        self.has_moved = False  #: whether another process now has this class
        self.driver: int | None = None
        self.questions: list[Question] = []
        self.asked: Question | None = None
        self._asked_on: set[str] = set()  #: pages or slides on which a question was asked and revealed
        self.puzzles: list[RoomPuzzle] = []
        self.puzzle: RoomPuzzle | None = None  #: the current one
        self.members: set[Member] = set()
        self.lecturer_seen = clock()
        self._clock = clock
        self._numbers: dict[str, int] = {}  #: by visitor
        self._given: Counter[str] = Counter()  #: numbers, by address
        self._watching: Counter[str] = Counter()  #: connections to the shown session, by address
        self._hands: set[int] = set()
        self._slots: dict[tuple[str, bool], str] = {}
        self._state_at = -STATE_EVERY_S
        self._state_timer: asyncio.TimerHandle | None = None
        self._away_timer: asyncio.TimerHandle | None = None
        self._set("view", ClassViewMessage(self.view, 0))
        self._set("explained", ClassExplained(None))
        self._publish_state()

    # -- members --------------------------------------------------------------------------------------------------

    @property
    def present(self) -> int:
        """Number of connected followers."""
        return len({member.number for member in self.members if member.number})

    def present_of(self, address: str) -> int:
        """Return the number of followers connected from an address."""
        return len({member.number for member in self.members if member.number and member.address == address})

    def given_to(self, address: str) -> int:
        """Return how many numbers were given to followers from an address."""
        return self._given[address]

    def places_taken(self, most_of_address: int) -> int:
        """Return :attr:`present` with at most ``most_of_address`` per address, so that members can return."""
        count = Counter(
            address for _, address in {(member.number, member.address) for member in self.members if member.number}
        )
        return self.present - sum(max(0, number - most_of_address) for number in count.values())

    def watching_from(self, address: str) -> int:
        """Return the number of connections from an address to the shown session."""
        return self._watching[address]

    @contextmanager
    def watching(self, address: str) -> Iterator[None]:
        """Count a connection to the shown session."""
        self._watching[address] += 1
        try:
            yield
        finally:
            self._watching[address] -= 1

    @property
    def is_full(self) -> bool:
        """Whether no further visitor can get a number."""
        return len(self._numbers) >= MAX_NUMBERS

    def connections_of(self, visitor: str) -> int:
        """Return the number of a visitor's connections."""
        numbers = {self._numbers.get(visitor), 0 if visitor == self.owner else None}
        return sum(member.number in numbers for member in self.members)

    def knows(self, visitor: str) -> bool:
        """Return whether a visitor has joined before."""
        return visitor == self.owner or visitor in self._numbers

    def join(self, visitor: str, address: str = "", *, follows: bool = False) -> Member:
        """Return a new connection of the lecturer or a follower, which will receive the complete state.

        A page in the lecturer's browser that ``follows`` the class counts as a follower.
        """
        number = self._follower(visitor, address) if follows else self.number_of(visitor, address)
        member = Member(number, address)
        member.send(ClassWelcome("follower" if number else "lecturer", number, self.counted_answer(member)))
        member.unsent = {"class", "view", "explained"} if number else {"class"}
        self.members.add(member)
        self._changed()
        return member

    def counted_answer(self, member: Member) -> float | None:
        """Return a follower's answer to the current question; None without one."""
        return None if self.asked is None else self.asked.answers.get(member.number)

    def leave(self, member: Member) -> None:
        """Remove a connection."""
        self.members.discard(member)
        if not member.number:
            self.lecturer_seen = self._clock()
            self._look_for_lecturer()
        elif not any(other.number == member.number for other in self.members):
            self._hands.discard(member.number)
        self._changed()

    @property
    def has_lecturer(self) -> bool:
        """Whether the lecturer is connected."""
        return any(not member.number for member in self.members)

    @property
    def is_lecturer_away(self) -> bool:
        """Whether the lecturer has not been connected for :data:`AWAY_AFTER_S`."""
        return not self.has_lecturer and self._clock() - self.lecturer_seen >= AWAY_AFTER_S

    def _look_for_lecturer(self) -> None:
        """Report to the followers that the lecturer is away, once that is the case."""
        if self._away_timer is not None:
            self._away_timer.cancel()
            self._away_timer = None
        left_s = AWAY_AFTER_S - (self._clock() - self.lecturer_seen)
        if self.has_ended or self.has_lecturer:
            return
        if left_s > 0.0:
            self._away_timer = asyncio.get_running_loop().call_later(left_s, self._look_for_lecturer)
        else:
            self._changed()

    def take(self, member: Member) -> list[str]:
        """Return the messages to send to a member now."""
        out = [*member.answers, *(self._slots[kind, not member.number] for kind in sorted(member.unsent))]
        member.answers.clear()
        member.unsent.clear()
        return out

    def may_drive(self, visitor: str, command: str) -> bool:
        """Return whether a follower may send a command to the shown session."""
        return command in DRIVERS_COMMANDS and self.driver is not None and self._numbers.get(visitor) == self.driver

    # -- commands -------------------------------------------------------------------------------------------------

    def handle(self, member: Member, command: ClassCommand) -> None:
        """Carry out a command. Raises :class:`ConfigError` if that is impossible."""
        match command:
            case AnswerCommand(question=number, value=value):
                if self.asked is None or self.asked.id != number or not member.number:
                    raise ConfigError("class.answer", "That question is closed.")
                self.asked.answer(member.number, value)
            case RaiseCommand(value=value):
                (self._hands.add if value and member.number else self._hands.discard)(member.number)
            case _ if member.number:
                raise ConfigError("class.lecturer", "Only the lecturer can do that.")
            case ShowCommand(view=view, session=session):
                self._show(view, session)
                return
            case ExplainCommand(why=why):
                self._set("explained", ClassExplained(why))
                return
            case AskCommand():
                self._ask(command)
            case RevealCommand(right=right):
                if self.asked is None:
                    raise ConfigError("class.question", "No question is asked.")
                self.asked.reveal(right)
                self._asked_on.add(_page_of(self.view))
            case StopCommand(value=value):
                if self.asked is None:
                    raise ConfigError("class.question", "No question is asked.")
                self.asked.stop(value)
                if not value:
                    self._asked_on.add(_page_of(self.view))
            case CloseCommand():
                self.asked = None
            case LockCommand(value=value):
                self.is_locked = value
            case CountCommand(joined_only=value):
                self.counts_joined_only = value
                for question in self.questions:
                    question.joined_only = value
            case HandCommand(number=number):
                self._hand(number)
        self._changed()

    def _show(self, view: ClassView, session: str | None) -> None:
        if session != self.session:
            self.session = session
            self.stage = self.stage + 1
            self.stage_over.set()
            self.stage_over = asyncio.Event()
            self._hand(None)
        self.view = view = _for_followers(view)
        if self.asked is not None and _page_of(view) not in self._asked_on:
            if self.asked.is_revealed:
                self.asked = None  # its result would cover what is shown next
                self._changed()
            elif not self.asked.is_closed:
                self.asked.is_closed = True  # what is shown next may contain the answer
                self._changed()
        self._set("view", ClassViewMessage(view, self.stage if session is not None else 0))

    def _ask(self, asked: AskCommand) -> None:
        if len(self.questions) >= MAX_QUESTIONS:
            raise ConfigError("class.questions", f"A class has at most {MAX_QUESTIONS} questions.")
        number, newest = len(self.questions) + 1, len(self._numbers)
        self.asked = Question.of(number, asked, newest, joined_only=self.counts_joined_only)
        self.questions.append(self.asked)
        self._asked_on = {_page_of(self.view)}

    def give_puzzle(self, key: str, title: str) -> None:
        """Assign a puzzle to the class. Raises :class:`ConfigError` if there are too many."""
        if len(self.puzzles) >= MAX_QUESTIONS:
            raise ConfigError("class.puzzles", f"A class has at most {MAX_QUESTIONS} puzzles.")
        self.puzzle = RoomPuzzle(key, title)
        self.puzzles.append(self.puzzle)
        self._changed()

    def close_puzzle(self) -> None:
        """Remove the puzzle. Its results are kept until the class ends."""
        self.puzzle = None
        self._changed()

    def solver_moved(self, puzzle: RoomPuzzle, solver: ClassSolver) -> None:
        """Update the progress of a follower."""
        puzzle.solvers[solver.number] = solver
        self._changed()

    def number_of(self, visitor: str, address: str = "") -> int:
        """Return the number of a follower, a new one if necessary; 0 for the lecturer."""
        return 0 if visitor == self.owner else self._follower(visitor, address)

    def _follower(self, visitor: str, address: str) -> int:
        if visitor not in self._numbers:
            self._given[address] += 1
            self._numbers[visitor] = len(self._numbers) + 1
        return self._numbers[visitor]

    def _hand(self, number: int | None) -> None:
        if number is not None and not any(member.number == number > 0 for member in self.members):
            raise ConfigError("class.number", f"Follower {number} is not here.")
        self.driver = number
        self._hands.discard(number or 0)
        self._changed()

    def end(self) -> None:
        """End the class: notify all members and close the connections."""
        self.has_ended = True
        self._look_for_lecturer()
        self.driver = None
        self.stage_over.set()
        self._publish_state()

    def move(self) -> None:
        """Close the connections, so that their pages connect to the process that has the class."""
        self.has_moved = True
        for member in self.members:
            member.wake.set()

    # -- messages -------------------------------------------------------------------------------------------------

    def _set(self, kind: str, message: ClassViewMessage | ClassExplained) -> None:
        """Set a message for the followers."""
        self._slots[kind, False] = _encoder.encode(message).decode()
        self._tell(kind, to_lecturer=False)

    def _tell(self, kind: str, *, to_lecturer: bool) -> None:
        for member in self.members:
            if member.number or to_lecturer:
                member.unsent.add(kind)
                member.wake.set()

    def _changed(self) -> None:
        """Send the state, now or once the last one is :data:`STATE_EVERY_S` old."""
        wait = self._state_at + STATE_EVERY_S - self._clock()
        if wait <= 0.0:
            self._publish_state()
        elif self._state_timer is None:
            self._state_timer = asyncio.get_running_loop().call_later(wait, self._publish_state)

    def _publish_state(self) -> None:
        if self._state_timer is not None:
            self._state_timer.cancel()
            self._state_timer = None
        self._state_at = self._clock()
        for lecturer in (False, True):
            state = ClassState(
                self.code,
                self.present,
                self.is_locked,
                self.has_ended,
                sorted(self._hands) if lecturer else [],
                self.driver,
                None if self.asked is None else self.asked.message(lecturer=lecturer),
                None if self.puzzle is None else self.puzzle.message(lecturer=lecturer),
                self.is_lecturer_away,
                self.counts_joined_only,
            )
            self._slots["class", lecturer] = _encoder.encode(state).decode()
        self._tell("class", to_lecturer=True)


def _for_followers(view: ClassView) -> ClassView:
    """Return a view whose address contains only the section, or the slide and its step.

    The address of a lecturer's older page contains its deck, with notes, hidden slides and later slides.
    """
    place, slide = _PLACE.match(view.hash), view.slide
    if slide is not None and slide.address is not None and not slide.address.startswith("/shared/"):
        # Anyone with the id of a session, which may be in the address of the lab or of a log, can control it.
        slide = msgspec.structs.replace(slide, address=None)
    return msgspec.structs.replace(view, hash=place[0] if place else "", slide=slide)


def _page_of(view: ClassView) -> str:
    """Return the page of a view; for the lecture as slides, the slide without its step and deck."""
    hash_ = view.hash.partition("&")[0].partition("/")[0]
    return f"{view.page}{hash_}" if hash_.startswith("?present") else view.page
