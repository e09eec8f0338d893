"""Table of localization parameters, and a config with one value for each row.

Names and initial values are those of Nav2's AMCL (docs.nav2.org, "AMCL"), where ``laser_max_beams`` is called
``max_beams``. Rows of the groups "global start" and "recovery" that AMCL lacks are specific to this project.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter, check_fields, choice, flag, number, table_of, with_values

SENSOR_MODELS = ("likelihood_field", "likelihood_field_prob", "beam")
MOTION_MODELS = ("differential", "omni")


def _alpha(label: str, sentence: str) -> float:
    return number(label, "motion", 0.2, sentence, "", 0.0, 10.0, 0.01)


def _mix(label: str, initial: float, sentence: str) -> float:
    return number(label, "sensor", initial, sentence, "", 0.0, 1.0, 0.005)


_WHOLE = (
    "laser_max_beams", "min_particles", "max_particles", "resample_interval", "global_particles",
    "annealing_stages", "independent_beams",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class LocalizationConfig:
    """Values of all rows of :data:`PARAMETERS`; each field states its unit and meaning.

    Raises :class:`ConfigError` naming the invalid parameter.
    """

    # fmt: off
    laser_model_type: str = choice(
        "Sensor model", "sensor", "likelihood_field_prob",
        "likelihood_field_prob: the product over the beams of table 6.3 of Probabilistic Robotics; likelihood_field: "
        "AMCL’s 1 + Σ p³ of the same field, whose weights differ less; beam: the beam model of table 6.1.",
        SENSOR_MODELS,
    )
    laser_max_beams: float = number(
        "Beams", "sensor", 60, "Number of beams of each scan that are used, evenly spread.", "", 2, 2000, 1,
    )
    independent_beams: float = number(
        "Independent beams", "sensor", 10,
        "Beams beside one another see the same things, and people hide many at once: the product over the beams counts "
        "as that of at most this many independent ones; 0: as that of all beams. likelihood_field does not use it.",
        "", 0, 2000, 1,
    )
    laser_min_range: float = number(
        "Minimum range", "sensor", -1.0, "Shorter readings are not used; -1: the sensor’s own limit.",
        "m", -1.0, 1000.0, 0.1,
    )
    laser_max_range: float = number(
        "Maximum range", "sensor", 100.0,
        "Readings of this range and more are not used, or are no return to the beam model; -1: the sensor’s own limit.",
        "m", -1.0, 1000.0, 0.5,
    )
    z_hit: float = _mix("z_hit", 0.5, "Share of readings from surfaces that are in the map.")
    z_short: float = _mix(
        "z_short", 0.005, "Share of readings from things before the expected surface; the beam model uses it.",
    )
    z_max: float = _mix("z_max", 0.05, "Share of readings without return; the beam model uses it.")
    z_rand: float = _mix("z_rand", 0.5, "Share of readings of any range.")
    sigma_hit: float = number(
        "σ of a reading", "sensor", 0.2, "Standard deviation of readings from surfaces that are in the map.",
        "m", 0.005, 5.0, 0.005,
    )
    lambda_short: float = number(
        "λ of short readings", "sensor", 0.1,
        "How fast the likelihood of unexpected short readings falls with the range; the beam model uses it.",
        "1/m", 0.001, 10.0, 0.01,
    )
    laser_likelihood_max_dist: float = number(
        "Likelihood field distance", "sensor", 2.0,
        "Larger distances from an end point to the nearest occupied cell count as this distance.",
        "m", 0.05, 50.0, 0.05,
    )
    robot_model_type: str = choice(
        "Motion model", "motion", "differential",
        "differential: turns and drives straight on; omni: moves sideways too.", MOTION_MODELS,
    )
    alpha1: float = _alpha("α1", "Variance of a turn for each squared radian of turning.")
    alpha2: float = _alpha("α2", "Variance of a turn, rad², for each squared metre of driving.")
    alpha3: float = _alpha("α3", "Variance of a distance for each squared metre of driving.")
    alpha4: float = _alpha("α4", "Variance of a distance, m², for each squared radian of turning.")
    alpha5: float = _alpha("α5", "Variance of a sideways distance for each squared metre of driving; omni uses it.")
    update_min_d: float = number(
        "Update distance", "filter", 0.25,
        "A scan is used once the robot has driven this far since the last used one, or turned by update_min_a.",
        "m", 0.0, 10.0, 0.01,
    )
    update_min_a: float = number(
        "Update rotation", "filter", 0.2,
        "A scan is used once the robot has turned this far since the last used one, or driven by update_min_d.",
        "rad", 0.0, 3.15, 0.01,
    )
    min_particles: float = number(
        "Minimum particles", "filter", 500, "The filter never has fewer particles.", "", 10, 1_000_000, 10,
    )
    max_particles: float = number(
        "Maximum particles", "filter", 2000, "The filter never has more particles once it has converged.",
        "", 10, 1_000_000, 100,
    )
    pf_err: float = number(
        "KLD error", "filter", 0.05,
        "Largest Kullback-Leibler distance between the particles and the belief that they represent.",
        "", 0.001, 1.0, 0.005,
    )
    pf_z: float = number(
        "KLD quantile", "filter", 0.99,
        "Quantile of the standard normal distribution itself, as in AMCL: 0.99 means 84 %, 2.33 means 99 %.",
        "", 0.0, 6.0, 0.01,
    )
    resample_interval: float = number(
        "Resample interval", "filter", 1, "Particles are resampled at every n-th update.", "", 1, 100, 1,
    )
    selective_resampling: bool = flag(
        "Selective resampling", "filter", False,
        "Particles are resampled only where N_eff, their effective number, is below half of their number.",
    )
    annealing_stages: float = number(
        "Stages per scan", "filter", 4,
        "Where likelihoods are scaled down (least_effective), a converged filter takes the rest of the likelihood in "
        "further stages, at most this many in all, and spreads the particles slightly between; 1: no further stages.",
        "", 1, 20, 1,
    )
    recovery_alpha_slow: float = number(
        "α slow", "recovery", 0.0,
        "Rate of the slow average of the weights (augmented MCL); 0: no random particles. AMCL suggests 0.001.",
        "", 0.0, 1.0, 0.001,
    )
    recovery_alpha_fast: float = number(
        "α fast", "recovery", 0.0,
        "Rate of the fast average of the weights (augmented MCL); 0: no random particles. AMCL suggests 0.1.",
        "", 0.0, 1.0, 0.01,
    )
    global_particles: float = number(
        "Particles without a hint", "global start", 50_000,
        "The number at a start without a hint, and the greatest number until the filter has converged.",
        "", 100, 1_000_000, 1000,
    )
    least_effective: float = number(
        "Minimum share of N_eff", "global start", 0.1,
        "Where a scan would leave a smaller share of effective particles, its log-likelihoods are scaled down until it "
        "does not; 0: never.", "", 0.0, 0.9, 0.01,
    )
    reset_below: float = number(
        "Reset threshold", "recovery", 0.85,
        "Where scans fit worse than this share of how well they fit at the best of many poses all over the map, "
        "particles are added that are drawn from the likelihood of a scan (sensor resetting), as are a few until the "
        "robot is found; 0: never, and no second filter is tested at other places.", "", 0.0, 1.0, 0.01,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)
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
            raise ConfigError(
                "parameter.z_hit", "z_hit and z_rand must not both be 0: every pose would fit equally well."
            )
        if (self.recovery_alpha_slow > 0.0) != (self.recovery_alpha_fast > 0.0) or (
            self.recovery_alpha_slow >= self.recovery_alpha_fast > 0.0
        ):
            raise ConfigError(
                "parameter.recovery_alpha_slow",
                "recovery_alpha_slow and recovery_alpha_fast must satisfy 0 < slow < fast, or both be 0, not "
                f"{self.recovery_alpha_slow:g} and {self.recovery_alpha_fast:g}.",
            )

    def with_values(self, values: Mapping[str, Any]) -> LocalizationConfig:
        """Return the config with these values replaced. Raises :class:`ConfigError` for an invalid name or value."""
        return with_values(self, values, "localization parameter")


PARAMETERS = table_of(LocalizationConfig)
BY_NAME: Mapping[str, Parameter] = {row.name: row for row in PARAMETERS}
