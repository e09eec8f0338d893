"""Answers of the HTTP interface about puzzles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from mapper.core.parameter import Values
from mapper.puzzles.scoring import Measures

Measure = Literal["agreement", "entropy", "sharpness"]


@dataclass(frozen=True, slots=True)
class OfferedPuzzle:
    """A puzzle that comes with the program."""

    name: str
    level: int
    title: str
    story: str


@dataclass(frozen=True, slots=True)
class NamedCause:
    """A cause of a spoiled map, and its name for people."""

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
    """Points that a wrong answer and a hint cost."""

    wrong: int
    hint: int


@dataclass(frozen=True, slots=True)
class RepairedWith:
    """What repairs the map, without the values: names of parameters, and whether it is other poses."""

    parameters: list[str]
    poses: bool


@dataclass(frozen=True, slots=True)
class SolutionAnswer:
    """The answer to a puzzle: its cause, what a ``lesson``'s ``section`` says of it, and what repairs the map.

    ``repair`` has the parameters that repair it, ``faulty`` their values at first; ``trajectory`` the poses that repair
    it, null for those at first, ``faulty_trajectory``.
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
    """The state of an attempt, which tells no more than the visitor has found.

    ``measures`` are those that the repair is judged by, ``repair`` the share of the repair of the map that was checked
    last, ``best`` of the best one, and ``enough`` of one that solves the puzzle, 0 to 1.
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
