"""One attempt at a puzzle: what was answered, repaired and asked for. The page learns the cause at its end only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

from mapper.core.errors import ConfigError
from mapper.puzzles import CAUSES, Puzzle, points
from mapper.puzzles.scoring import HINT_POINTS, REPAIRED, WRONG_POINTS, Measures


@dataclass(slots=True)
class Game:
    """An attempt at ``puzzle``. Used from the event loop only; ``changed`` is called after each step."""

    title: str
    story: str
    level: int
    puzzle: Puzzle
    changed: Callable[[], None] = lambda: None
    is_named: bool = False
    hints: int = 0
    best: float = 0.0  #: share of the repair of the best map so far
    now: Measures | None = None  #: of the map that was checked last
    gave_up: bool = False
    wrong: set[str] = field(default_factory=set)  #: wrong answers

    @property
    def can_repair(self) -> bool:
        """Whether there is anything to repair."""
        return self.puzzle.can_repair

    @property
    def is_solved(self) -> bool:
        """Whether the cause is named and, where that is possible, the map repaired."""
        return self.is_named and (not self.can_repair or self.best >= REPAIRED)

    @property
    def is_over(self) -> bool:
        """Whether the answer is shown."""
        return self.is_solved or self.gave_up

    @property
    def points(self) -> int:
        """The points so far, 0 … 100; 0 for who had the answer shown."""
        if self.gave_up:
            return 0
        return points(
            is_named=self.is_named,
            repair=1.0 if self.is_solved else self.best,
            wrong=len(self.wrong),
            hints=self.hints,
            can_repair=self.can_repair,
        )

    def answer(self, cause: str) -> bool:
        """Take an answer; return whether it is right. Raises :class:`ConfigError` for a cause that there is not."""
        if cause not in CAUSES:
            raise ConfigError("puzzle.cause", f"There is no cause {cause!r:.80} to choose.")
        self._check_open()
        if cause == self.puzzle.cause:
            self.is_named = True
        elif not self.is_named:
            self.wrong.add(cause)
        self.changed()
        return cause == self.puzzle.cause

    def hint(self) -> None:
        """Show one more hint. Raises :class:`ConfigError` where all are shown."""
        self._check_open()
        if self.hints >= len(CAUSES[self.puzzle.cause].hints):
            raise ConfigError("puzzle.hints", "There are no more hints.")
        self.hints += 1
        self.changed()

    def check(self, now: Measures) -> None:
        """Take what was measured of the map as it is now."""
        self.now = now
        if not self.is_over:
            self.best = max(self.best, self.puzzle.share(now) if self.can_repair else 0.0)
        self.changed()

    def give_up(self) -> None:
        """Show the answer."""
        self._check_open()
        self.gave_up = True
        self.changed()

    def _check_open(self) -> None:
        if self.is_over:
            raise ConfigError("puzzle.over", "This puzzle is over: its answer is shown.")

    def public(self) -> dict[str, Any]:
        """Return what the page may know now."""
        puzzle, cause = self.puzzle, CAUSES[self.puzzle.cause]
        return {
            "title": self.title,
            "story": self.story,
            "level": self.level,
            "causes": [{"name": one.name, "label": one.label} for one in CAUSES.values()],
            "is_named": self.is_named,
            "wrong": sorted(self.wrong),
            "hints": list(cause.hints[: self.hints]),
            "hints_left": len(cause.hints) - self.hints,
            "costs": {"wrong": WRONG_POINTS, "hint": HINT_POINTS},
            "first": asdict(puzzle.spoiled),
            "goal": asdict(puzzle.repaired),
            "now": None if self.now is None else asdict(self.now),
            "measures": sorted(puzzle.shares(puzzle.spoiled)) or sorted(asdict(puzzle.spoiled)),
            "repair": None if self.now is None else puzzle.share(self.now),
            "best": self.best,
            "enough": REPAIRED,
            "can_repair": self.can_repair if self.is_named else None,
            "points": self.points,
            "is_solved": self.is_solved,
            "gave_up": self.gave_up,
            "answer": self._answer() if self.is_over else None,
        }

    def _answer(self) -> dict[str, Any]:
        cause = CAUSES[self.puzzle.cause]
        return {
            "cause": cause.name,
            "label": cause.label,
            "explanation": cause.explanation,
            "section": cause.section,
            "repair": dict(self.puzzle.repair),
            "trajectory": self.puzzle.repair_trajectory or None,
        }
