"""Creation of a puzzle's faulty log from a recipe, a history of the lab, or a log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.mapping.parameters import MappingConfig
from mapper.puzzles import RECIPES, Puzzle, Spoiled, puzzle_of, shortened, spoil
from mapper.puzzles.drives import ODOMETRY, TRUE
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from mapper.simulation import Faults
from server.puzzles.spec import AS_IT_IS, LogSpec, WorldSpec
from server.sources.log_recording import first_config
from server.sources.simulation_replay import replayed

MayContinue = Callable[[], bool]
Tell = Callable[[str, float | None], None]
"""Called with the current part of the work and its completed share, None if unknown."""
DRIVING, MAPPING = "Driving through the world", "Mapping the drive"


class PuzzleSource(Protocol):
    """Creates a puzzle on a worker thread."""

    def make(self, limits: Callable[[], Limits], may_continue: MayContinue, tell: Tell) -> Puzzle:
        """Return the puzzle. Raises like the mapper, and ``WorkCancelledError`` once ``may_continue`` returns False."""


def puzzle_config(log: ScanLog) -> MappingConfig:
    """Return the initial parameters of a log's puzzle: hits and misses both count, as when it was created."""
    return first_config(log).with_values({"hit_and_passed": "both_count"})


def _ready(spoiled: Spoiled, cause: str, limits: Callable[[], Limits], may_continue: MayContinue, tell: Tell) -> Puzzle:
    first = puzzle_config(spoiled.reference)
    return puzzle_of(spoiled, cause, first, limits(), may_continue, lambda done: tell(MAPPING, done))


@dataclass(frozen=True, slots=True)
class RecipeSource:
    """A puzzle included in the program."""

    name: str

    def make(self, limits: Callable[[], Limits], may_continue: MayContinue, tell: Tell) -> Puzzle:
        """Return the puzzle."""
        recipe = RECIPES[self.name]

        def step(done: float) -> None:
            tell(DRIVING, done)
            if not may_continue():
                raise WorkCancelledError("puzzle.unwanted", "The making of the puzzle was cancelled.")

        return _ready(recipe.make(step), recipe.cause, limits, may_continue, tell)


@dataclass(frozen=True, slots=True)
class WorldSource:
    """A puzzle of a world of the lab."""

    spec: WorldSpec

    def make(self, limits: Callable[[], Limits], may_continue: MayContinue, tell: Tell) -> Puzzle:
        """Return the puzzle of the recording with the most scans."""
        spec = self.spec
        tell(DRIVING, None)
        history = spec.history
        driven = history.model_copy(update={"faults": {}, "parameters": {}})
        mapper = replayed(driven, limits=limits, may_continue=may_continue)
        clean = _renamed(max(mapper.logs(Faults()), key=lambda log: log.n_scans))
        if spec.fault != AS_IT_IS:
            return _ready(spoil(clean, spec.cause, spec.seed, TRUE), spec.cause, limits, may_continue, tell)
        faults = Faults().with_values(history.faults)
        shown = _renamed(max(mapper.logs(replace(faults, slam=False)), key=lambda log: log.n_scans))
        drifts = faults.drift and not faults.slam
        spoiled = Spoiled(
            shown,
            ODOMETRY if drifts else TRUE,
            clean,
            TRUE,
            history.parameters,
            repair_trajectory=TRUE if drifts else "",
        )
        return _ready(spoiled, spec.cause, limits, may_continue, tell)


@dataclass(frozen=True, slots=True)
class LogSource:
    """A puzzle of a log."""

    spec: LogSpec
    log: ScanLog

    def make(self, limits: Callable[[], Limits], may_continue: MayContinue, tell: Tell) -> Puzzle:
        """Return the puzzle of the log's first scans."""
        if isinstance(self.log, JointLog):
            raise ConfigError("puzzle.sensors", "A puzzle uses one sensor: choose one of the log’s sensors.")
        spec, log = self.spec, shortened(self.log)
        name = spec.view.trajectory or log.default_trajectory
        if spec.fault != AS_IT_IS:
            return _ready(spoil(log, spec.cause, spec.seed, name), spec.cause, limits, may_continue, tell)
        return _ready(Spoiled(log, name, log, name, spec.values), spec.cause, limits, may_continue, tell)


def _renamed(log: ScanLog) -> ScanLog:
    """Return the log of a simulation with the trajectory names and descriptions common to all puzzles."""
    true, odometry = log.trajectory("true"), log.trajectory("odometry")
    if log.n_scans < 2:
        raise ConfigError("puzzle.short", "The robot has hardly moved yet: let it drive first.")
    return replace(
        log,
        trajectories={
            TRUE: replace(true, description="Measured by cameras on the ceiling."),
            ODOMETRY: replace(odometry, description="What the wheels report."),
        },
    )
