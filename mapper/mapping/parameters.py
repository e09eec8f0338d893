"""The one table of mapping parameters: the command line, the server, viser's panel and the pages all read it.

Each row names the parameter, its unit, its first value, its bounds, the step of its slider and one sentence.
:class:`MappingConfig` holds one value for each row and validates itself against the table.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter, check_fields, check_names, check_table
from mapper.grid import probability
from mapper.mapping.sensor_model import (
    BeamModel,
    FixedIncrements,
    HitCounting,
    MoravecElfes,
    SmoothRamp,
    SonarCone,
    StepWindow,
)

Statistics = Literal["none", "counts", "certainties"]


@dataclass(frozen=True, slots=True)
class ModelStrategy:
    """The parts of the algorithm that differ between the values of ``model``.

    ``build`` makes the inverse sensor model. With ``cone`` a beam is a cone of ``opening`` radians, otherwise a thin
    line. With ``smooth`` the evidence changes continuously in a hit window that widens with the range. ``statistics``
    are the numbers that are kept for each cell: none (the map is a sum of log-odds), counts of hits and misses, or
    certainties of occupied and empty. ``per_scan`` says whether the per-scan update exists for the model.
    """

    name: str
    build: Callable[[MappingConfig], BeamModel]
    cone: bool = False
    smooth: bool = False
    statistics: Statistics = "none"
    per_scan: bool = True


def _sonar_cone(config: MappingConfig) -> SonarCone:
    profile: Literal["flat", "gaussian"] = "gaussian" if config.cone_profile == "gaussian" else "flat"
    return SonarCone(config.log_odds_miss, config.log_odds_hit, config.cone_window, config.opening, profile)


STRATEGIES: Mapping[str, ModelStrategy] = {
    strategy.name: strategy
    for strategy in (
        ModelStrategy("fixed_increments", lambda c: FixedIncrements(c.log_odds_miss, c.log_odds_hit, c.window)),
        ModelStrategy("step_window", lambda c: StepWindow(c.p_free, c.p_prior, c.p_occ, c.window)),
        ModelStrategy(
            "smooth_ramp",
            lambda c: SmoothRamp(c.log_odds_miss, c.log_odds_hit, c.sigma, c.sigma_growth),
            smooth=True,
        ),
        ModelStrategy("sonar_cone", _sonar_cone, cone=True),
        ModelStrategy(
            "moravec_elfes",
            lambda c: MoravecElfes(c.cone_window, c.opening),
            cone=True,
            statistics="certainties",
            per_scan=False,
        ),
        ModelStrategy("hit_counting", lambda c: HitCounting(c.prior_weight, c.p_prior, c.window), statistics="counts"),
    )
}
MODELS = tuple(STRATEGIES)  #: values of ``model``
CONES = tuple(name for name, strategy in STRATEGIES.items() if strategy.cone)
_STEPPED = tuple(name for name, strategy in STRATEGIES.items() if not strategy.smooth)
_THIN = tuple(name for name, strategy in STRATEGIES.items() if not strategy.cone)
_PER_SCAN = tuple(name for name, strategy in STRATEGIES.items() if strategy.per_scan)

PARAMETERS: tuple[Parameter, ...] = (
    Parameter(
        "model", "Inverse sensor model", "model", "choice", "fixed_increments",
        "How a reading becomes evidence: along a thin beam, all over a sonar's cone, or by counting hits and visits.",
        choices=MODELS,
    ),
    Parameter(
        "range_max", "Max range", "model", "number", 30.0,
        "A reading beyond this distance counts as no return.",
        unit="m", low=0.5, high=100.0, step=0.1,
    ),
    Parameter(
        "window", "Hit window", "model", "number", 0.0,
        "Width w of the zone around the reading that counts as hit: at 0 its own cell alone, in a cone a cell's width.",
        unit="m", low=0.0, high=2.0, step=0.05, only_for=_STEPPED,
    ),
    Parameter(
        "log_odds_hit", "Hit increment", "model", "number", 0.85,
        "Evidence that a cell gets when a beam ends in it, or in the window around it.",
        low=0.0, high=3.0, step=0.05, only_for=("fixed_increments", "smooth_ramp", "sonar_cone"),
    ),
    Parameter(
        "log_odds_miss", "Miss increment", "model", "number", -0.4,
        "Evidence that a cell gets when a beam passes through it: below 0 it is evidence for free.",
        low=-3.0, high=0.0, step=0.05, only_for=("fixed_increments", "smooth_ramp", "sonar_cone"),
    ),
    Parameter(
        "p_free", "p of a cell passed", "model", "number", 0.4,
        "Probability that a cell before the window is occupied; below the prior it is evidence for free.",
        low=0.01, high=0.99, step=0.01, only_for=("step_window",),
    ),
    Parameter(
        "p_occ", "p of a cell hit", "model", "number", 0.7,
        "Probability that a cell within the window is occupied.",
        low=0.01, high=0.99, step=0.01, only_for=("step_window",),
    ),
    Parameter(
        "sigma", "Spread σ₀", "model", "number", 0.03,
        "Standard deviation of a reading at no distance; the ramp reaches two of them to either side.",
        unit="m", low=0.005, high=0.5, step=0.005, only_for=("smooth_ramp",),
    ),
    Parameter(
        "sigma_growth", "Growth of σ", "model", "number", 0.01,
        "By how much σ grows with each metre of range.",
        unit="m/m", low=0.0, high=0.2, step=0.005, only_for=("smooth_ramp",),
    ),
    Parameter(
        "opening", "Opening angle", "model", "number", 0.52,
        "Angle of the cone, from edge to edge, in which the echo may have arisen.",
        unit="rad", low=0.01, high=1.57, step=0.01, only_for=CONES,
    ),
    Parameter(
        "cone_profile", "Cone profile", "model", "choice", "flat",
        "The same evidence all over the cone, or weaker off the axis (a Gaussian) and with the range (a quadratic).",
        choices=("flat", "gaussian"), only_for=("sonar_cone",),
    ),
    Parameter(
        "prior_weight", "Weight of the prior", "model", "number", 2.0,
        "How many visits the prior counts for; 2 is Laplace's rule of succession.",
        low=0.1, high=50.0, step=0.1, only_for=("hit_counting",),
    ),
    Parameter(
        "update", "Update", "update", "choice", "per_beam",
        "Per beam, each beam adds its evidence; per scan, each cell in view is updated once, by its nearest beam.",
        choices=("per_beam", "per_scan"), only_for=_PER_SCAN,
    ),
    Parameter(
        "traversal", "Traversal", "update", "choice", "bresenham",
        "Which cells a beam crosses: those of Bresenham's thin line, or exactly all that it touches (Amanatides–Woo).",
        choices=("bresenham", "amanatides_woo"), only_for=_THIN,
    ),
    Parameter(
        "no_return", "No return", "update", "choice", "ignore",
        "What a beam without echo says: nothing; that all is free up to the max range; or, a mistake, a hit there.",
        choices=("ignore", "free", "hit"),
    ),
    Parameter(
        "deskew", "Deskew", "update", "choice", "auto",
        "Place each beam where the sensor was at its time, per beam only; auto: where poses are at most 0.5 s apart.",
        choices=("auto", "on", "off"), only_for=_PER_SCAN,
    ),
    Parameter(
        "clamp", "Clamp", "update", "flag", True,
        "Keep each cell's log-odds between the two limits, so that the map can still change.",
    ),
    Parameter(
        "log_odds_min", "Lower clamp", "update", "number", -2.0,
        "The most free a cell can become.",
        low=-10.0, high=0.0, step=0.1,
    ),
    Parameter(
        "log_odds_max", "Upper clamp", "update", "number", 3.5,
        "The most occupied a cell can become.",
        low=0.0, high=10.0, step=0.1,
    ),
    Parameter(
        "log_odds_prior", "Prior ℓ₀", "map", "number", 0.0,
        "Belief about a cell before any reading: 0 is fifty-fifty.",
        low=-2.0, high=2.0, step=0.05,
    ),
    Parameter(
        "resolution", "Resolution", "map", "number", 0.05,
        "Side of a cell.",
        unit="m", low=0.01, high=1.0, step=0.01,
    ),
    Parameter(
        "mount_x", "Mount forward", "mount", "number", 0.0,
        "Correction of the sensor's place on the robot, forward.",
        unit="m", low=-2.0, high=2.0, step=0.01,
    ),
    Parameter(
        "mount_y", "Mount left", "mount", "number", 0.0,
        "Correction of the sensor's place on the robot, to the left.",
        unit="m", low=-2.0, high=2.0, step=0.01,
    ),
    Parameter(
        "mount_yaw", "Mount yaw", "mount", "number", 0.0,
        "Correction of the sensor's heading on the robot, counter-clockwise.",
        unit="rad", low=-3.1416, high=3.1416, step=0.01,
    ),
    Parameter(
        "mount_upside_down", "Mount turned over", "mount", "flag", False,
        "Turn the sensor over, z axis down: its beams sweep in the opposite direction.",
    ),
    Parameter(
        "time_offset", "Time offset", "mount", "number", 0.0,
        "Correction of the sensor's clock, added to the scans' times; scans outside the poses' times are left out.",
        unit="s", low=-2.0, high=2.0, step=0.01,
    ),
)  # fmt: skip

LOG_ONLY = frozenset({"deskew", "time_offset"})  #: parameters that need the robot's poses at other times than a scan's

BY_NAME: Mapping[str, Parameter] = {row.name: row for row in PARAMETERS}


@dataclass(frozen=True, slots=True)
class MappingConfig:
    """One value for each row of :data:`PARAMETERS`; units and meanings are in the table.

    ``mount_*`` is added to the mount that the log or the simulated robot states: ``T_base_laser`` becomes
    ``T_base_laser ∘ (mount_x, mount_y, mount_yaw)``, turned over with ``mount_upside_down``.
    ``deskew`` and ``time_offset`` concern scans of a log, which has the robot's poses at other times too.
    Raises :class:`ConfigError` naming the field that is refused.
    """

    model: str = "fixed_increments"
    range_max: float = 30.0
    window: float = 0.0
    log_odds_hit: float = 0.85
    log_odds_miss: float = -0.4
    p_free: float = 0.4
    p_occ: float = 0.7
    sigma: float = 0.03
    sigma_growth: float = 0.01
    opening: float = 0.52
    cone_profile: str = "flat"
    prior_weight: float = 2.0
    update: str = "per_beam"
    traversal: str = "bresenham"
    no_return: str = "ignore"
    deskew: str = "auto"
    clamp: bool = True
    log_odds_min: float = -2.0
    log_odds_max: float = 3.5
    log_odds_prior: float = 0.0
    resolution: float = 0.05
    mount_x: float = 0.0
    mount_y: float = 0.0
    mount_yaw: float = 0.0
    mount_upside_down: bool = False
    time_offset: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self, PARAMETERS)
        if self.log_odds_min >= self.log_odds_max:
            raise ConfigError("parameter.clamp", "The lower clamp must be below the upper clamp.")
        self.beam_model()  # the models check what concerns two parameters at once

    @property
    def strategy(self) -> ModelStrategy:
        """The row of :data:`STRATEGIES` that ``model`` names."""
        return STRATEGIES[self.model]

    def beam_model(self) -> BeamModel:
        """Return the inverse sensor model that the parameters describe."""
        return self.strategy.build(self)

    @property
    def p_prior(self) -> float:
        """The prior as a probability."""
        return float(probability(self.log_odds_prior))

    @property
    def cone_window(self) -> float:
        """The hit window of a cone, metres: at least one cell, as a thinner arc would miss the cells' centres."""
        return max(self.window, self.resolution)

    @property
    def clamp_limits(self) -> tuple[float, float]:
        """The clamp (ℓ_min, ℓ_max), (−inf, inf) when it is off."""
        return (self.log_odds_min, self.log_odds_max) if self.clamp else (-np.inf, np.inf)

    @property
    def mount(self) -> tuple[float, float, float]:
        """The correction of the sensor mount as a pose."""
        return (self.mount_x, self.mount_y, self.mount_yaw)

    def with_values(self, values: Mapping[str, Any]) -> MappingConfig:
        """Return a copy with some values replaced; raise :class:`ConfigError` for an unknown name or a bad value."""
        check_names(values, PARAMETERS)
        return MappingConfig(**(asdict(self) | dict(values)))


check_table(MappingConfig, PARAMETERS)
