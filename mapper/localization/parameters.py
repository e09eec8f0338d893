"""The one table of parameters of localization, and one value for each row.

Names and first values are those of Nav2's AMCL (docs.nav2.org, "AMCL"), of which ``laser_max_beams`` is called
``max_beams`` there. Rows of the groups "global start" and "recovery" that AMCL lacks are this project's own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter, check_fields, check_names, check_table

SENSOR_MODELS = ("likelihood_field", "likelihood_field_prob", "beam")
MOTION_MODELS = ("differential", "omni")


def _alpha(number: int, sentence: str) -> Parameter:
    return Parameter(f"alpha{number}", f"α{number}", "motion", "number", 0.2, sentence, "", 0.0, 10.0, 0.01)


def _mix(name: str, initial: float, sentence: str) -> Parameter:
    return Parameter(name, name, "sensor", "number", initial, sentence, "", 0.0, 1.0, 0.005)


PARAMETERS: tuple[Parameter, ...] = (
    Parameter(
        "laser_model_type", "Sensor model", "sensor", "choice", "likelihood_field_prob",
        "likelihood_field_prob: the product over the beams of table 6.3 of Probabilistic Robotics; likelihood_field: "
        "AMCL's 1 + Σ p³ of the same field, whose weights differ less; beam: the beam model of table 6.1.",
        choices=SENSOR_MODELS,
    ),
    Parameter(
        "laser_max_beams", "Beams", "sensor", "number", 60, "So many beams of each scan, evenly spread, are used.",
        "", 2, 2000, 1,
    ),
    Parameter(
        "independent_beams", "Independent beams", "sensor", "number", 10,
        "Beams beside one another see the same things, and people hide many at once: the product over the beams counts "
        "as that of at most this many independent ones; 0: as that of all beams. likelihood_field does not use it.",
        "", 0, 2000, 1,
    ),
    Parameter(
        "laser_min_range", "Shortest range", "sensor", "number", -1.0,
        "Shorter readings are not used; -1: the sensor's own limit.", "m", -1.0, 1000.0, 0.1,
    ),
    Parameter(
        "laser_max_range", "Longest range", "sensor", "number", 100.0,
        "Readings of this range and more are not used, or are no return to the beam model; -1: the sensor's own limit.",
        "m", -1.0, 1000.0, 0.5,
    ),
    _mix("z_hit", 0.5, "Share of readings of what the map has."),
    _mix("z_short", 0.005, "Share of readings of what stands before it; the beam model uses it."),
    _mix("z_max", 0.05, "Share of readings without return; the beam model uses it."),
    _mix("z_rand", 0.5, "Share of readings of any range."),
    Parameter(
        "sigma_hit", "σ of a reading", "sensor", "number", 0.2, "Standard deviation of readings of what the map has.",
        "m", 0.005, 5.0, 0.005,
    ),
    Parameter(
        "lambda_short", "λ of short readings", "sensor", "number", 0.1,
        "How fast the likelihood of what stands before falls with the range; the beam model uses it.",
        "1/m", 0.001, 10.0, 0.01,
    ),
    Parameter(
        "laser_likelihood_max_dist", "Reach of the field", "sensor", "number", 2.0,
        "End points farther than this from anything occupied count as if they were so far.", "m", 0.05, 50.0, 0.05,
    ),
    Parameter(
        "robot_model_type", "Motion model", "motion", "choice", "differential",
        "differential: turns and drives straight on; omni: moves sideways too.", choices=MOTION_MODELS,
    ),
    _alpha(1, "Variance of a turn for each squared radian of turning."),
    _alpha(2, "Variance of a turn, rad², for each squared metre of driving."),
    _alpha(3, "Variance of a distance for each squared metre of driving."),
    _alpha(4, "Variance of a distance, m², for each squared radian of turning."),
    _alpha(5, "Variance of a sideways distance for each squared metre of driving; omni uses it."),
    Parameter(
        "update_min_d", "Distance of updates", "filter", "number", 0.25,
        "A scan is used once the robot drove so far since the last one that was used, or turned by update_min_a.",
        "m", 0.0, 10.0, 0.01,
    ),
    Parameter(
        "update_min_a", "Turn of updates", "filter", "number", 0.2, "The same for turns.", "rad", 0.0, 3.15, 0.01,
    ),
    Parameter(
        "min_particles", "Fewest particles", "filter", "number", 500, "Never fewer.", "", 10, 1_000_000, 10,
    ),
    Parameter(
        "max_particles", "Most particles", "filter", "number", 2000, "Never more once the filter has converged.",
        "", 10, 1_000_000, 100,
    ),
    Parameter(
        "pf_err", "KLD error", "filter", "number", 0.05,
        "Largest Kullback-Leibler distance of the particles from the belief that they stand for.",
        "", 0.001, 1.0, 0.005,
    ),
    Parameter(
        "pf_z", "KLD quantile", "filter", "number", 0.99,
        "Quantile of the standard normal distribution, itself, as AMCL has it, at which the distance is below pf_err.",
        "", 0.0, 6.0, 0.01,
    ),
    Parameter(
        "resample_interval", "Updates per resampling", "filter", "number", 1, "Particles are resampled each n-th.",
        "", 1, 100, 1,
    ),
    Parameter(
        "selective_resampling", "Selective resampling", "filter", "flag", False,
        "Particles are resampled only where the effective number N_eff is below half of theirs.",
    ),
    Parameter(
        "annealing_stages", "Stages of a scan", "filter", "number", 4,
        "Where likelihoods are scaled down (least_effective), a converged filter takes the rest of the likelihood in "
        "further stages, at most this many in all, and spreads the particles slightly between; 1: no further stages.",
        "", 1, 20, 1,
    ),
    Parameter(
        "recovery_alpha_slow", "α slow", "recovery", "number", 0.0,
        "Rate of the slow average of the weights (augmented MCL); 0: no random particles. AMCL suggests 0.001.",
        "", 0.0, 1.0, 0.001,
    ),
    Parameter(
        "recovery_alpha_fast", "α fast", "recovery", "number", 0.0,
        "Rate of the fast average of the weights (augmented MCL); 0: no random particles. AMCL suggests 0.1.",
        "", 0.0, 1.0, 0.01,
    ),
    Parameter(
        "global_particles", "Particles without a hint", "global start", "number", 50_000,
        "The number at a start without a hint, and the greatest number until the filter has converged.",
        "", 100, 1_000_000, 1000,
    ),
    Parameter(
        "least_effective", "Least share of N_eff", "global start", "number", 0.1,
        "Where a scan would leave a smaller share of effective particles, its log-likelihoods are scaled down until it "
        "does not; 0: never.",
        "", 0.0, 0.9, 0.01,
    ),
    Parameter(
        "reset_below", "Reset below", "recovery", "number", 0.85,
        "Where scans fit worse than this share of how well they fit at the best of many poses all over the map, "
        "particles are added that are drawn from the likelihood of a scan (sensor resetting), as are a few until the "
        "robot is found; 0: never, and no second filter (rival) is tested at other places.",
        "", 0.0, 1.0, 0.01,
    ),
)  # fmt: skip
BY_NAME: Mapping[str, Parameter] = {row.name: row for row in PARAMETERS}
_WHOLE = (
    "laser_max_beams", "min_particles", "max_particles", "resample_interval", "global_particles",
    "annealing_stages", "independent_beams",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class LocalizationConfig:
    """One value for each row of :data:`PARAMETERS`; units and meanings are in the table.

    Raises :class:`ConfigError` naming the parameter that is refused.
    """

    laser_model_type: str = "likelihood_field_prob"
    laser_max_beams: float = 60
    independent_beams: float = 10
    laser_min_range: float = -1.0
    laser_max_range: float = 100.0
    z_hit: float = 0.5
    z_short: float = 0.005
    z_max: float = 0.05
    z_rand: float = 0.5
    sigma_hit: float = 0.2
    lambda_short: float = 0.1
    laser_likelihood_max_dist: float = 2.0
    robot_model_type: str = "differential"
    alpha1: float = 0.2
    alpha2: float = 0.2
    alpha3: float = 0.2
    alpha4: float = 0.2
    alpha5: float = 0.2
    update_min_d: float = 0.25
    update_min_a: float = 0.2
    min_particles: float = 500
    max_particles: float = 2000
    pf_err: float = 0.05
    pf_z: float = 0.99
    resample_interval: float = 1
    selective_resampling: bool = False
    annealing_stages: float = 4
    recovery_alpha_slow: float = 0.0
    recovery_alpha_fast: float = 0.0
    global_particles: float = 50_000
    least_effective: float = 0.1
    reset_below: float = 0.85

    def __post_init__(self) -> None:
        check_fields(self, PARAMETERS)
        for name in _WHOLE:
            value = getattr(self, name)
            if value != int(value):
                raise ConfigError(
                    f"parameter.{name}", f"{BY_NAME[name].label} ({name}) must be a whole number, not {value!r}."
                )
        if self.min_particles > self.max_particles:
            raise ConfigError(
                "parameter.min_particles",
                f"min_particles, {self.min_particles:g}, must be at most max_particles, {self.max_particles:g}.",
            )
        for name in ("laser_min_range", "laser_max_range"):
            value = getattr(self, name)
            if value < 0.0 and value != -1.0:
                raise ConfigError(f"parameter.{name}", f"{name} must be -1 or 0 and more, not {value:g} m.")
        if 0.0 <= self.laser_max_range <= self.laser_min_range:
            raise ConfigError(
                "parameter.laser_max_range",
                f"laser_max_range, {self.laser_max_range:g} m, must be above laser_min_range, "
                f"{self.laser_min_range:g} m.",
            )
        if self.z_hit + self.z_rand <= 0.0:
            raise ConfigError("parameter.z_hit", "z_hit and z_rand must not both be 0: every pose would fit alike.")
        if (self.recovery_alpha_slow > 0.0) != (self.recovery_alpha_fast > 0.0) or (
            self.recovery_alpha_slow >= self.recovery_alpha_fast > 0.0
        ):
            raise ConfigError(
                "parameter.recovery_alpha_slow",
                "recovery_alpha_slow and recovery_alpha_fast must satisfy 0 < slow < fast, or both be 0, not "
                f"{self.recovery_alpha_slow:g} and {self.recovery_alpha_fast:g}.",
            )

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name."""
        return asdict(self)

    def with_values(self, values: Mapping[str, Any]) -> LocalizationConfig:
        """Return the config with these values replaced. Raises :class:`ConfigError` for a name or a value."""
        check_names(values, PARAMETERS, "localization parameter")
        return LocalizationConfig(**{**asdict(self), **values})


check_table(LocalizationConfig, PARAMETERS)
