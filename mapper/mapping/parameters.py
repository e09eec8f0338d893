"""Table of mapping parameters, shared by the command line, the server, viser's panel and the pages.

Each row has the parameter's name, unit, initial value, bounds, slider step and a one-sentence description.
:class:`MappingConfig` holds one value for each row and validates itself against the table.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter, Value, Values, check_fields, choice, flag, number, table_of, with_values
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
from mapper.sensors.corrections import corrected_log
from mapper.sensors.scan import ScanLog

Statistics = Literal["none", "counts", "certainties"]


@dataclass(frozen=True, slots=True)
class ModelStrategy:
    """The properties in which the values of ``model`` differ.

    ``build`` creates the inverse sensor model. With ``cone`` a beam is a cone of ``opening`` radians, otherwise a thin
    line. With ``smooth`` the evidence changes continuously in a hit window that widens with the range. ``statistics``
    is what is kept for each cell: nothing (the map is a sum of log-odds), counts of hits and misses, or certainties of
    occupied and empty. ``per_scan`` says whether the per-scan update exists for the model.
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
#: Log-odds models in which a thin beam either hits a cell or passes it. A ramp has no border between the two, cones
#: overlap by their width, and a counting model estimates the fraction of beams that passed.
HIT_OR_PASSED = tuple(name for name in _THIN if name in _STEPPED and STRATEGIES[name].statistics == "none")
_PER_SCAN = tuple(name for name, strategy in STRATEGIES.items() if strategy.per_scan)


LOG_ONLY = frozenset({"deskew", "time_offset"})  #: parameters that need the robot's poses between the scans


@dataclass(frozen=True, slots=True)
class MappingConfig:
    """Values of all rows of :data:`PARAMETERS`. Each field states its unit and meaning.

    ``mount_*`` is composed onto the mount given by the log or the simulated robot: ``T_base_laser`` becomes
    ``T_base_laser ∘ (mount_x, mount_y, mount_yaw)``, flipped if ``mount_upside_down`` is set. ``deskew`` and
    ``time_offset`` apply to logs only, because they need the robot's poses between the scans. Raises
    :class:`ConfigError` naming the invalid field.
    """

    # fmt: off
    model: str = choice(
        "Inverse sensor model", "model", "fixed_increments",
        "How a reading becomes evidence: along a thin beam, all over a sonar’s cone, or by counting hits and visits.",
        MODELS,
    )
    range_max: float = number(
        "Max range", "model", 30.0, "A reading beyond this distance counts as no return.", "m", 0.5, 100.0, 0.1,
    )
    window: float = number(
        "Hit window", "model", 0.0,
        "Width w of the zone around the reading that counts as hit: at 0 its own cell alone, in a cone a cell’s width.",
        "m", 0.0, 2.0, 0.05, only_for=_STEPPED,
    )
    log_odds_hit: float = number(
        "Hit increment", "model", 0.85, "Evidence that a cell gets when a beam ends in it, or in the window around it.",
        "", 0.0, 3.0, 0.05, only_for=("fixed_increments", "smooth_ramp", "sonar_cone"),
    )
    log_odds_miss: float = number(
        "Miss increment", "model", -0.4,
        "Evidence that a cell gets when a beam passes through it: below 0 it is evidence for free.",
        "", -3.0, 0.0, 0.05, only_for=("fixed_increments", "smooth_ramp", "sonar_cone"),
    )
    p_free: float = number(
        "p of a passed cell", "model", 0.4,
        "Probability that a cell before the window is occupied; below the prior it is evidence for free.",
        "", 0.01, 0.99, 0.01, only_for=("step_window",),
    )
    p_occ: float = number(
        "p of a hit cell", "model", 0.7, "Probability that a cell within the window is occupied.",
        "", 0.01, 0.99, 0.01, only_for=("step_window",),
    )
    sigma: float = number(
        "Spread σ₀", "model", 0.03,
        "Standard deviation of a reading at range 0; the ramp is two of them wide on either side.",
        "m", 0.005, 0.5, 0.005, only_for=("smooth_ramp",),
    )
    sigma_growth: float = number(
        "Growth of σ", "model", 0.01, "By how much σ grows with each metre of range.",
        "m/m", 0.0, 0.2, 0.005, only_for=("smooth_ramp",),
    )
    opening: float = number(
        "Opening angle", "model", 0.52, "Angle of the cone, from edge to edge, in which the echo may have arisen.",
        "rad", 0.01, 1.57, 0.01, only_for=CONES,
    )
    cone_profile: str = choice(
        "Cone profile", "model", "flat",
        "The same evidence all over the cone, or weaker off the axis (a Gaussian) and with the range (a quadratic).",
        ("flat", "gaussian"), only_for=("sonar_cone",),
    )
    prior_weight: float = number(
        "Prior weight", "model", 2.0, "How many visits the prior counts for; 2 is Laplace’s rule of succession.",
        "", 0.1, 50.0, 0.1, only_for=("hit_counting",),
    )
    update: str = choice(
        "Update", "update", "per_beam",
        "Per beam, each beam adds its evidence; per scan, each cell in view is updated once, by its nearest beam.",
        ("per_beam", "per_scan"), only_for=_PER_SCAN,
    )
    hit_and_passed: str = choice(
        "Hit and passed", "update", "both_count",
        "A cell that some beams of one scan hit and others pass: both count, or only the hits. Per beam only.",
        ("both_count", "only_hits"), only_for=HIT_OR_PASSED,
    )
    traversal: str = choice(
        "Traversal", "update", "bresenham",
        "Which cells a beam crosses: those of Bresenham’s thin line, or exactly all that it touches (Amanatides–Woo).",
        ("bresenham", "amanatides_woo"), only_for=_THIN,
    )
    no_return: str = choice(
        "No return", "update", "ignore",
        "What a beam without an echo means: nothing; free space up to the max range; or, wrongly, a hit there.",
        ("ignore", "free", "hit"),
    )
    deskew: str = choice(
        "Deskew", "update", "auto",
        "Place each beam where the sensor was at its time, per beam only; auto: where poses are at most 0.5 s apart.",
        ("auto", "on", "off"), only_for=_PER_SCAN,
    )
    clamp: bool = flag(
        "Clamp", "update", True, "Keep each cell’s log-odds between the two limits, so that the map can still change.",
    )
    log_odds_min: float = number(
        "Lower clamp", "update", -2.0, "Lower limit of the log-odds of a cell.", "", -10.0, 0.0, 0.1,
    )
    log_odds_max: float = number(
        "Upper clamp", "update", 3.5, "Upper limit of the log-odds of a cell.", "", 0.0, 10.0, 0.1,
    )
    log_odds_prior: float = number(
        "Prior ℓ₀", "map", 0.0, "Belief about a cell before any reading: 0 is fifty-fifty.", "", -2.0, 2.0, 0.05,
    )
    resolution: float = number("Resolution", "map", 0.05, "Side of a cell.", "m", 0.01, 1.0, 0.01)
    mount_x: float = number(
        "Mount forward", "mount", 0.0, "Correction of the sensor’s place on the robot, forward.", "m", -2.0, 2.0, 0.01,
    )
    mount_y: float = number(
        "Mount left", "mount", 0.0, "Correction of the sensor’s place on the robot, to the left.", "m", -2.0, 2.0, 0.01,
    )
    mount_yaw: float = number(
        "Mount yaw", "mount", 0.0, "Correction of the sensor’s heading on the robot, counter-clockwise.",
        "rad", -3.1416, 3.1416, 0.01,
    )
    mount_upside_down: bool = flag(
        "Mount turned over", "mount", False,
        "Turn the sensor over, z axis down: its beams sweep in the opposite direction.",
    )
    time_offset: float = number(
        "Time offset", "mount", 0.0,
        "Correction of the sensor’s clock, added to the scans’ times; scans outside the poses’ times are left out.",
        "s", -2.0, 2.0, 0.01,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)
        if self.log_odds_min >= self.log_odds_max:
            raise ConfigError("parameter.clamp", "The lower clamp must be below the upper clamp.")
        self.beam_model()  # the models check constraints between two parameters

    @property
    def strategy(self) -> ModelStrategy:
        """The row of :data:`STRATEGIES` for ``model``."""
        return STRATEGIES[self.model]

    def beam_model(self) -> BeamModel:
        """Return the inverse sensor model for the parameters."""
        return self.strategy.build(self)

    @property
    def only_hits(self) -> bool:
        """Whether the misses of a scan are ignored in the cells that it hits."""
        return self.hit_and_passed == "only_hits" and self.model in HIT_OR_PASSED and self.update == "per_beam"

    @property
    def p_prior(self) -> float:
        """The prior as a probability."""
        return float(probability(self.log_odds_prior))

    @property
    def cone_window(self) -> float:
        """The hit window of a cone, metres: at least one cell, because a thinner arc would miss cell centres."""
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
        """Return a copy with some values replaced. Raise :class:`ConfigError` for an unknown name or invalid value."""
        return with_values(self, values)


PARAMETERS = table_of(MappingConfig)
BY_NAME: Mapping[str, Parameter] = {row.name: row for row in PARAMETERS}


def as_mapped(log: ScanLog, config: MappingConfig) -> ScanLog:
    """Return ``log`` with the corrections of ``config`` applied, as used before estimating poses for its map.

    See :func:`mapper.sensors.corrections.corrected_log`.
    """
    return corrected_log(log, config.mount, turned_over=config.mount_upside_down, time_offset=config.time_offset)


SONAR_WINDOW = 0.2  #: metres: assumed thickness of the arc of a sonar echo


def sensor_defaults(beam_width: float, values: Mapping[str, Any] | None = None) -> Values:
    """Return ``values`` of :data:`mapper.mapping.parameters.PARAMETERS` completed with the defaults for a sensor.

    Sensors with a ``beam_width`` > 0 (radians) use the sonar cone model. If ``values`` names a model, the other
    parameters keep the defaults of the table.
    """
    values = values or {}
    if beam_width <= 0.0:
        return dict(values)
    row = BY_NAME["opening"]
    opening = float(np.clip(beam_width, row.low, row.high))
    defaults: Values = {"opening": opening}
    if "model" not in values:
        defaults |= {"model": "sonar_cone", "window": SONAR_WINDOW}
    return defaults | dict(values)


#: Defaults for recordings, whose maps should keep thin walls; a simulated world starts with the literature's values.
RECORDED: Mapping[str, Value] = {"hit_and_passed": "only_hits"}


def recorded_defaults(beam_width: float, values: Mapping[str, Any] | None = None) -> Values:
    """Return :func:`sensor_defaults` with :data:`RECORDED` for a recording."""
    return {**RECORDED, **sensor_defaults(beam_width, values)}
