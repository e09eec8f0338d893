"""Answers of the HTTP interface about puzzles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from mapper.core.parameter import Values
from mapper.puzzles.scoring import Measures

Measure = Literal["agreement", "entropy", "sharpness"]


@dataclass(frozen=True, slots=True)
class OfferedPuzzle:
    """A puzzle included in the program."""

    name: str
    level: int
    title: str
    story: str


@dataclass(frozen=True, slots=True)
class NamedCause:
    """A cause of a faulty map, and its displayed name."""

    name: str
    label: str


@dataclass(frozen=True, slots=True)
class OfferedCause:
    """A cause to choose; ``lesson`` is a sentence of the lecture about it, once it was a wrong answer."""

    name: str
    label: str
    lesson: str | None


@dataclass(frozen=True, slots=True)
class Costs:
    """Points deducted for a wrong answer and a hint."""

    wrong: int
    hint: int


@dataclass(frozen=True, slots=True)
class RepairedWith:
    """What repairs the map, without the values: names of parameters, and whether other poses are needed."""

    parameters: list[str]
    poses: bool


@dataclass(frozen=True, slots=True)
class SolutionAnswer:
    """The answer to a puzzle: its cause, a ``lesson`` about it from a ``section``, and the repair of the map.

    ``repair`` has the parameters that repair it, ``faulty`` their initial values; ``trajectory`` the poses that repair
    it, null for the initial ones, ``faulty_trajectory``.
    """

    cause: str
    label: str
    explanation: str
    lesson: str
    section: str
    repair: Values
    trajectory: str | None
    faulty: Values
    faulty_trajectory: str


@dataclass(frozen=True, slots=True)
class Attempt:
    """The state of an attempt, limited to what the visitor has found.

    ``measures`` determine the score of the repair, ``repair`` is the score of the map checked last, ``best`` of the
    best one, and ``enough`` the score that solves the puzzle, 0 to 1.
    """

    title: str
    story: str
    level: int
    causes: list[OfferedCause]
    is_named: bool
    wrong: list[str]
    hints: list[str]
    hints_left: int
    costs: Costs
    first: Measures
    goal: Measures
    now: Measures | None
    measures: list[Measure]
    repair: float | None
    best: float
    enough: float
    can_repair: bool | None
    repaired_with: RepairedWith | None
    points: int
    is_solved: bool
    gave_up: bool
    answer: SolutionAnswer | None
