"""The puzzle that a class solves: how far each follower is, by number."""

from __future__ import annotations

from typing import Any

from server.stream.class_messages import ClassPuzzle, ClassSolver

BINS = 10  #: parts of the points, 0 to 100, in the results


class RoomPuzzle:
    """A puzzle that is given to a class. ``key`` says which it is; followers do not learn it."""

    def __init__(self, key: str, title: str) -> None:
        self.key = key
        self.title = title
        self.solvers: dict[int, ClassSolver] = {}
        self.progress: dict[int, Any] = {}  #: by number, the ``server.puzzles.game.Progress`` of all attempts

    def message(self, *, lecturer: bool) -> ClassPuzzle:
        """Return the puzzle as the lecturer or a follower sees it."""
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
