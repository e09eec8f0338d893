"""Inverse sensor models: the evidence of a reading z for a cell at distance r and angle φ from the beam's axis.

Each model is a frozen dataclass; :meth:`increment` is its profile, ``inverse_sensor_model(r, φ) − ℓ₀`` in log-odds,
which the pages plot and :mod:`mapper.mapping.textbook` adds to a map. Metres and radians. Sources: Thrun, Burgard &
Fox, Probabilistic Robotics, table 9.2 (``inverse_range_sensor_model``); Moravec & Elfes, High resolution maps from wide
angle sonar, ICRA 1985; and those named by the models.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.errors import ConfigError
from mapper.grid import log_odds

NoReturn = Literal["ignore", "free", "hit"]


class BeamModel(Protocol):
    """Base of all models: free before the reading, occupied near it, unknown beyond.

    ``log_odds_miss`` and ``log_odds_hit`` are the strongest evidence for free and for occupied.
    """

    @property
    def log_odds_miss(self) -> float: ...  # noqa: D102 - the class says it

    @property
    def log_odds_hit(self) -> float: ...  # noqa: D102 - the class says it

    def half_window(self, z: float) -> float:
        """Return the greatest |r − z|, metres, at which a cell counts as hit by a reading ``z``."""
        ...

    def increment(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the evidence of a measured ``z`` at distances ``r`` and angles ``theta`` (shapes that broadcast)."""
        ...


class InverseSensorModel(Protocol):
    """User-defined sensor model for :func:`mapper.mapping.integrate.integrate_scan`: thin beams, updated per beam.

    ``reach`` is how far behind a reading there is evidence, metres: the model is evaluated for cells up to r = z +
    reach.
    """

    @property
    def reach(self) -> float: ...  # noqa: D102 - the class says it

    def increments(self, r: NDArray[np.float64], z: NDArray[np.float64], range_max: float) -> ArrayLike:
        """Return the increments (m,), ``inverse_sensor_model − ℓ₀`` in log-odds, finite.

        There is one entry for each cell that a beam of the scan crosses. ``r`` (m,) is the distance from the sensor to
        the cell's centre, and exactly z for the cell that holds the endpoint; with a ``reach`` of 0 it is below z for
        all others. ``z`` (m,) is the beam's reading, +inf for no return; such beams are included only with
        ``no_return`` "free". ``range_max`` is the maximum range that counts. All in metres.
        """
        ...


def beam_profile(
    model: BeamModel, z: float, r: ArrayLike, range_max: float = np.inf, *, no_return: NoReturn = "ignore"
) -> NDArray[np.float64]:
    """Return the increment of a reading ``z`` at distances ``r`` (any shape) along its beam, in log-odds.

    Metres in, ``inverse_sensor_model(r) − ℓ₀`` out. A ``z`` beyond ``range_max`` is no return: 0 everywhere, the miss
    increment up to ``range_max`` with ``no_return`` "free", or the profile of a reading of ``range_max`` with "hit". A
    ``z`` that is NaN or not positive is invalid: 0 everywhere.
    """
    distance = np.asarray(r, dtype=np.float64)
    if np.isnan(z) or z <= 0.0:
        return np.zeros_like(distance)
    if z > range_max and no_return != "hit":
        miss = model.log_odds_miss if no_return == "free" else 0.0
        return np.where((distance >= 0.0) & (distance <= range_max), miss, 0.0)
    return np.where(distance >= 0.0, model.increment(distance, min(z, range_max)), 0.0)


def _step(r: ArrayLike, z: float, half: float, miss: float, hit: float) -> NDArray[np.float64]:
    """Return miss for r < z − half, hit for |r − z| ≤ half, 0 beyond."""
    distance = np.asarray(r, dtype=np.float64)
    return np.where(distance < z - half, miss, np.where(distance <= z + half, hit, 0.0))


def _check_window(window: float) -> None:
    if not (np.isfinite(window) and window >= 0.0):
        raise ConfigError("model.window", f"The hit window must be a finite width in metres, not {window!r}.")


def _check_increments(miss: float, hit: float) -> None:
    if not (np.isfinite(miss) and miss <= 0.0):
        raise ConfigError("model.miss", f"The miss increment must be finite and at most 0, not {miss!r}.")
    if not (np.isfinite(hit) and hit >= 0.0):
        raise ConfigError("model.hit", f"The hit increment must be finite and at least 0, not {hit!r}.")


def _check_opening(opening: float) -> None:
    if not 0.0 < opening < np.pi:
        raise ConfigError("model.opening", f"A cone’s opening angle must be between 0 and π radians, not {opening!r}.")


@dataclass(frozen=True, slots=True)
class FixedIncrements:
    """Fixed evidence: ``log_odds_miss`` for a cell that a beam passes, ``log_odds_hit`` for one in which it ends.

    With ``window`` w > 0 metres every cell within w/2 of the reading is a hit; with w = 0 only the cell that holds the
    endpoint is. Source: OctoMap (Hornung et al. 2013, section 5.1: −0.4, +0.85).
    """

    log_odds_miss: float = -0.4
    log_odds_hit: float = 0.85
    window: float = 0.0

    def __post_init__(self) -> None:
        _check_increments(self.log_odds_miss, self.log_odds_hit)
        _check_window(self.window)

    def half_window(self, z: float) -> float:  # noqa: ARG002, D102 - as the protocol says
        return self.window / 2.0

    def increment(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:  # noqa: ARG002, D102
        return _step(r, z, self.half_window(z), self.log_odds_miss, self.log_odds_hit)


@dataclass(frozen=True, slots=True)
class StepWindow:
    """The step window in probabilities: ``p_free`` for r < z − w/2, ``p_occ`` within the window, ``p_prior`` beyond.

    ``window`` is w in metres. As evidence: log-odds of each, minus the log-odds of the prior.
    Source: Probabilistic Robotics, table 9.2 with α = w.
    """

    p_free: float = 0.4
    p_prior: float = 0.5
    p_occ: float = 0.7
    window: float = 0.2

    def __post_init__(self) -> None:
        if not 0.0 < self.p_free <= self.p_prior <= self.p_occ < 1.0:
            raise ConfigError(
                "model.probabilities",
                "The step window needs 0 < p_free ≤ p_prior ≤ p_occ < 1, not "
                f"p_free {self.p_free!r}, p_prior {self.p_prior!r}, p_occ {self.p_occ!r}.",
            )
        _check_window(self.window)

    @property
    def log_odds_miss(self) -> float:
        """Evidence before the window: log-odds of ``p_free`` minus those of the prior."""
        return float(log_odds(self.p_free) - log_odds(self.p_prior))

    @property
    def log_odds_hit(self) -> float:
        """Evidence in the window: log-odds of ``p_occ`` minus those of the prior."""
        return float(log_odds(self.p_occ) - log_odds(self.p_prior))

    def half_window(self, z: float) -> float:  # noqa: ARG002, D102 - as the protocol says
        return self.window / 2.0

    def increment(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:  # noqa: ARG002, D102
        return _step(r, z, self.half_window(z), self.log_odds_miss, self.log_odds_hit)


@dataclass(frozen=True, slots=True)
class SmoothRamp:
    """A smooth ramp that widens with the uncertainty of the reading, σ(z) = ``sigma`` + ``sigma_growth`` · z, metres.

    Evidence rises from ``log_odds_miss`` at r = z − 2σ to ``log_odds_hit`` at r = z and falls to 0 at r = z + 2σ, both
    along the cubic 3t² − 2t³, so that value and slope are continuous. The cell that holds the endpoint gets the full
    ``log_odds_hit``. The shape is that of Elfes, Using occupancy grids for mobile robot perception and navigation,
    Computer 1989 (a profile computed from a Gaussian sensor), with a cubic in place of the integral.
    """

    log_odds_miss: float = -0.4
    log_odds_hit: float = 0.85
    sigma: float = 0.03
    sigma_growth: float = 0.01

    def __post_init__(self) -> None:
        _check_increments(self.log_odds_miss, self.log_odds_hit)
        if not (np.isfinite(self.sigma) and self.sigma > 0.0):
            raise ConfigError("model.sigma", f"The spread σ must be a positive number of metres, not {self.sigma!r}.")
        if not (np.isfinite(self.sigma_growth) and self.sigma_growth >= 0.0):
            raise ConfigError(
                "model.sigma_growth", f"The growth of σ must be finite and at least 0, not {self.sigma_growth!r}."
            )

    def half_window(self, z: float) -> float:
        """Return 2σ(z), metres."""
        return 2.0 * (self.sigma + self.sigma_growth * z)

    def increment(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:  # noqa: ARG002, D102
        t = (np.asarray(r, dtype=np.float64) - z) / self.half_window(z)
        rise, fall = _smoothstep(t + 1.0), _smoothstep(1.0 - t)
        return np.where(
            t <= 0.0, self.log_odds_miss + (self.log_odds_hit - self.log_odds_miss) * rise, self.log_odds_hit * fall
        )


def _smoothstep(t: NDArray[np.float64]) -> NDArray[np.float64]:
    clipped = np.clip(t, 0.0, 1.0)
    return np.asarray(clipped * clipped * (3.0 - 2.0 * clipped))


@dataclass(frozen=True, slots=True)
class SonarCone:
    """A cone of ``opening`` radians: ``log_odds_hit`` near the range, ``log_odds_miss`` closer, 0 elsewhere.

    Near the range is |r − z| ≤ w/2 with w = ``window`` metres. ``profile`` "flat" uses the same evidence for every
    cell, which is table 9.2 of Probabilistic Robotics with the opening angle β; "gaussian" weights the evidence by
    exp(−φ²/2σ²) with σ = opening/4 in angle, and in range by 1 − (r/(z − w/2))² before the window and 1 − ((r −
    z)/(w/2))² in it: the profiles of Moravec & Elfes 1985 with the Gaussian of Elfes 1989 in angle.
    """

    log_odds_miss: float = -0.4
    log_odds_hit: float = 0.85
    window: float = 0.2
    opening: float = np.pi / 6.0
    profile: Literal["flat", "gaussian"] = "flat"

    def __post_init__(self) -> None:
        _check_increments(self.log_odds_miss, self.log_odds_hit)
        _check_window(self.window)
        _check_opening(self.opening)
        if self.profile not in ("flat", "gaussian"):
            raise ConfigError("model.profile", f"A cone’s profile must be flat or gaussian, not {self.profile!r:.40}.")

    def half_window(self, z: float) -> float:  # noqa: ARG002, D102 - as the protocol says
        return self.window / 2.0

    def increment(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:  # noqa: D102
        angle = np.asarray(theta, dtype=np.float64)
        flat = _step(r, z, self.half_window(z), self.log_odds_miss, self.log_odds_hit)
        if self.profile == "gaussian":
            flat = flat * _range_weight(r, z, self.half_window(z)) * np.exp(-8.0 * (angle / self.opening) ** 2)
        return np.where(np.abs(angle) <= self.opening / 2.0, flat, 0.0)


def _range_weight(r: ArrayLike, z: float, half: float) -> NDArray[np.float64]:
    """Return the quadratic of Moravec & Elfes 1985: falling from 1 at the sensor to 0 at the window, and 1 at z inside
    it.
    """
    distance = np.asarray(r, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        empty = 1.0 - (distance / (z - half)) ** 2
        occupied = 1.0 - ((distance - z) / half) ** 2 if half > 0.0 else np.ones_like(distance)
    return np.where(distance < z - half, empty, occupied)


@dataclass(frozen=True, slots=True)
class MoravecElfes:
    """Grids of 1985: a reading has a degree of certainty that a cell is empty, and another that it is occupied.

    With β = ``opening`` radians and ε = w/2 = half of ``window`` metres, for |φ| ≤ β/2: empty (r, φ) = (1 − (r/(z −
    ε))²) · (1 − (2φ/β)²) for r < z − ε, and occupied (r, φ) = (1 − ((r − z)/ε)²) · (1 − (2φ/β)²) for |r − z| ≤ ε. They
    are not combined by a Bayes filter: see :func:`mapper.mapping.textbook.update_moravec_elfes`. Source: Moravec &
    Elfes 1985, with R_min = 0.
    """

    window: float = 0.2
    opening: float = np.pi / 6.0

    def __post_init__(self) -> None:
        _check_window(self.window)
        _check_opening(self.opening)

    @property
    def log_odds_miss(self) -> float:
        """The log-odds of p = 0 at full certainty of "empty": −inf."""
        return -np.inf

    @property
    def log_odds_hit(self) -> float:
        """The log-odds of p = 1 at full certainty of "occupied": +inf."""
        return np.inf

    def half_window(self, z: float) -> float:  # noqa: ARG002, D102 - as the protocol says
        return self.window / 2.0

    def empty(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the certainty of "empty", 0 to 1, for a reading ``z``."""
        distance = np.asarray(r, dtype=np.float64)
        weight = _range_weight(distance, z, self.half_window(z)) * self._off_axis(theta)
        return np.where(distance < z - self.half_window(z), weight, 0.0)

    def occupied(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the certainty of "occupied", 0 to 1, for a reading ``z``, before normalisation."""
        distance = np.asarray(r, dtype=np.float64)
        weight = _range_weight(distance, z, self.half_window(z)) * self._off_axis(theta)
        near = (distance >= z - self.half_window(z)) & (distance <= z + self.half_window(z))
        return np.where(near, weight, 0.0)

    def _off_axis(self, theta: ArrayLike) -> NDArray[np.float64]:
        off = np.asarray(theta, dtype=np.float64) / (self.opening / 2.0)
        return np.where(np.abs(off) <= 1.0, 1.0 - off * off, 0.0)

    def increment(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Return the certainty of "occupied" minus that of "empty", −1 to 1; these are not log-odds."""
        return self.occupied(r, z, theta) - self.empty(r, z, theta)

    @staticmethod
    def log_odds(empty: ArrayLike, occupied: ArrayLike) -> NDArray[np.float64]:
        """Return the log-odds that a map shows for the two certainties: ℓ of p = (1 + v)/2.

        v is the greater certainty, negated if it is that of "empty": the thresholding of 1985.
        """
        against, speaks = np.asarray(empty, dtype=np.float64), np.asarray(occupied, dtype=np.float64)
        value = np.where(speaks >= against, speaks, -against)
        return log_odds((1.0 + value) / 2.0)


@dataclass(frozen=True, slots=True)
class HitCounting:
    """Reflection maps: count how often beams end in a cell and how often they pass it.

    With n hits among n + m visits, and a Beta prior equivalent to ``prior_weight`` n₀ visits with a fraction
    ``p_prior`` of hits, the posterior mean is p = (n + n₀·p_prior) / (n + m + n₀): n₀ = 2 and p_prior = ½ is Laplace's
    rule of succession, n₀ → 0 the maximum likelihood map. p is the probability that the cell *reflects* a beam, which
    is not the probability of "occupied": a cell half filled by a wall converges to ½ with more observations, while a
    Bayes filter converges to 0 or 1. ``window`` w metres as in :class:`FixedIncrements`. Source: Burgard, Stachniss,
    Bennewitz & Arras, Introduction to Mobile Robotics, "Grid maps and reflection maps"; Hähnel, Triebel, Burgard &
    Thrun, ICRA 2003.
    """

    prior_weight: float = 2.0
    p_prior: float = 0.5
    window: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.prior_weight) and self.prior_weight > 0.0):
            raise ConfigError(
                "model.prior_weight", f"The prior must weigh a positive number of visits, not {self.prior_weight!r}."
            )
        if not 0.0 < self.p_prior < 1.0:
            raise ConfigError("model.prior", f"The prior must be a probability in (0, 1), not {self.p_prior!r}.")
        _check_window(self.window)

    def log_odds(self, hits: ArrayLike, misses: ArrayLike) -> NDArray[np.float64]:
        """Return the log-odds of the posterior mean: ln (n + n₀·p_prior) − ln (m + n₀·(1 − p_prior))."""
        speaks = np.asarray(hits, dtype=np.float64) + self.prior_weight * self.p_prior
        against = np.asarray(misses, dtype=np.float64) + self.prior_weight * (1.0 - self.p_prior)
        return np.asarray(np.log(speaks) - np.log(against))

    @property
    def log_odds_miss(self) -> float:
        """Increment of the first miss: ln w(1 − p) − ln (1 + w(1 − p)). Later ones change less."""
        return float(self.log_odds(0, 1) - self.log_odds(0, 0))

    @property
    def log_odds_hit(self) -> float:
        """Increment of the first hit: ln (1 + wp) − ln wp. Later ones change less."""
        return float(self.log_odds(1, 0) - self.log_odds(0, 0))

    def half_window(self, z: float) -> float:  # noqa: ARG002, D102 - as the protocol says
        return self.window / 2.0

    def increment(self, r: ArrayLike, z: float, theta: ArrayLike = 0.0) -> NDArray[np.float64]:  # noqa: ARG002
        """Return the change made by the first visit of a cell."""
        return _step(r, z, self.half_window(z), self.log_odds_miss, self.log_odds_hit)
