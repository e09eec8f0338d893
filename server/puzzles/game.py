"""One attempt at a puzzle: its answers, repairs and hints. The page receives the cause only at the end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import get_args

from mapper.core.errors import ConfigError
from mapper.puzzles import CAUSES, Cause, Puzzle, points
from mapper.puzzles.scoring import HINT_POINTS, REPAIRED, WRONG_POINTS, Measures
from server.puzzles.answers import Attempt, Costs, Measure, OfferedCause, RepairedWith, SolutionAnswer


@dataclass(slots=True)
class Progress:
    """Progress on a puzzle. If a class solves the puzzle, it outlasts the session of an attempt."""

    is_named: bool = False
    hints: int = 0
    best: float = 0.0  #: score of the best repair so far
    gave_up: bool = False
    wrong: set[str] = field(default_factory=set)  #: wrong answers


@dataclass(slots=True)
class Game:
    """An attempt at ``puzzle``. Used from the event loop only. ``changed`` is called after each step.

    ``choices`` are the possible causes.
    """

    title: str
    story: str
    level: int
    puzzle: Puzzle
    choices: tuple[str, ...] = tuple(CAUSES)
    changed: Callable[[], None] = lambda: None
    progress: Progress = field(default_factory=Progress)
    now: Measures | None = None  #: of the map checked last

    @property
    def can_repair(self) -> bool:
        """Whether there is anything to repair."""
        return self.puzzle.can_repair

    @property
    def is_solved(self) -> bool:
        """Whether the cause is named and, if possible, the map repaired."""
        progress = self.progress
        return progress.is_named and (not self.can_repair or progress.best >= REPAIRED)

    @property
    def is_over(self) -> bool:
        """Whether the answer is shown."""
        return self.is_solved or self.progress.gave_up

    @property
    def points(self) -> int:
        """The points so far, 0 to 100; 0 if the answer was shown on request."""
        progress = self.progress
        if progress.gave_up:
            return 0
        return points(
            is_named=progress.is_named,
            repair=1.0 if self.is_solved else progress.best,
            wrong=len(progress.wrong),
            hints=progress.hints,
            can_repair=self.can_repair,
        )

    def answer(self, cause: str) -> bool:
        """Check an answer; return whether it is right. Raises :class:`ConfigError` for an unknown cause."""
        if cause not in self.choices:
            raise ConfigError("puzzle.cause", f"There is no cause {cause!r:.80} to choose.")
        self._check_open()
        if cause == self.puzzle.cause:
            self.progress.is_named = True
        elif not self.progress.is_named:
            self.progress.wrong.add(cause)
        self.changed()
        return cause == self.puzzle.cause

    def hint(self) -> None:
        """Show one more hint. Raises :class:`ConfigError` if all are shown."""
        self._check_open()
        if self.progress.hints >= len(CAUSES[self.puzzle.cause].hints):
            raise ConfigError("puzzle.hints", "There are no more hints.")
        self.progress.hints += 1
        self.changed()

    def check(self, now: Measures) -> None:
        """Record the measures of the current map."""
        self.now = now
        if not self.is_over:
            self.progress.best = max(self.progress.best, self.puzzle.share(now) if self.can_repair else 0.0)
        self.changed()

    def give_up(self) -> None:
        """Show the answer."""
        self._check_open()
        self.progress.gave_up = True
        self.changed()

    def _check_open(self) -> None:
        if self.is_over:
            raise ConfigError("puzzle.over", "This attempt is over: its answer was shown.")

    def public(self) -> Attempt:
        """Return the state that the page may receive now."""
        puzzle, cause, progress = self.puzzle, CAUSES[self.puzzle.cause], self.progress
        shares = puzzle.shares(puzzle.spoiled)
        return Attempt(
            title=self.title,
            story=self.story,
            level=self.level,
            causes=[self._offered(CAUSES[name]) for name in CAUSES if name in self.choices],
            is_named=progress.is_named,
            wrong=sorted(progress.wrong),
            hints=list(cause.hints[: progress.hints]),
            hints_left=len(cause.hints) - progress.hints,
            costs=Costs(WRONG_POINTS, HINT_POINTS),
            first=puzzle.spoiled,
            goal=puzzle.repaired,
            now=self.now,
            measures=[measure for measure in get_args(Measure) if measure in shares or not shares],
            repair=None if self.now is None else puzzle.share(self.now),
            best=progress.best,
            enough=REPAIRED,
            can_repair=self.can_repair if progress.is_named else None,
            repaired_with=self._repaired_with() if progress.is_named else None,
            points=self.points,
            is_solved=self.is_solved,
            gave_up=progress.gave_up,
            answer=self._answer() if self.is_over else None,
        )

    def _offered(self, cause: Cause) -> OfferedCause:
        return OfferedCause(cause.name, cause.label, cause.lesson if cause.name in self.progress.wrong else None)

    def _repaired_with(self) -> RepairedWith:
        return RepairedWith(list(self.puzzle.repair), bool(self.puzzle.repair_trajectory))

    def _answer(self) -> SolutionAnswer:
        cause, trajectory = CAUSES[self.puzzle.cause], self.puzzle.repair_trajectory or None
        start = asdict(self.puzzle.start)
        return SolutionAnswer(
            cause.name,
            cause.label,
            cause.explanation,
            cause.lesson,
            cause.section,
            dict(self.puzzle.repair),
            trajectory,
            {name: start[name] for name in self.puzzle.repair},
            self.puzzle.trajectory,
        )
