"""Inverse sensor models along a beam: what a reading z says of a cell at distance s.

Each model is a frozen dataclass that says which evidence, in log-odds, a cell in front of the reading and a cell at
the reading get; :meth:`increment` is the profile that the pages draw. Source: Thrun, Burgard & Fox, Probabilistic
Robotics, table 9.2 (``inverse_range_sensor_model``); Moravec & Elfes 1985.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.errors import ConfigError
from mapper.grid import log_odds


class BeamModel(Protocol):
    """A model of three zones along a beam: free before the window, occupied in it, nothing known beyond.

    ``log_odds_miss`` and ``log_odds_hit`` are ``inverse_sensor_model − ℓ₀`` in the first two zones; ``window`` is
    the width r of the middle one in metres, centred on the reading.
    """

    @property
    def log_odds_miss(self) -> float: ...  # noqa: D102

    @property
    def log_odds_hit(self) -> float: ...  # noqa: D102

    @property
    def window(self) -> float: ...  # noqa: D102


def beam_profile(
    model: BeamModel, z: float, s: ArrayLike, range_max: float = np.inf, *, no_return_free: bool = False
) -> NDArray[np.float64]:
    """Return the increment that a reading ``z`` gives at distances ``s`` (any shape) along its beam, in log-odds.

    Metres in, ``inverse_sensor_model(s) − ℓ₀`` out: miss for s < z − r/2, hit for |s − z| ≤ r/2, 0 beyond. A ``z``
    beyond ``range_max`` is no return: 0 everywhere, or miss up to ``range_max`` with ``no_return_free``.
    """
    distance = np.asarray(s, dtype=np.float64)
    if np.isnan(z) or z <= 0.0:
        return np.zeros_like(distance)
    if z > range_max:
        miss = model.log_odds_miss if no_return_free else 0.0
        return np.where((distance >= 0.0) & (distance <= range_max), miss, 0.0)
    half = model.window / 2.0
    out = np.zeros_like(distance)
    out[(distance >= 0.0) & (distance < z - half)] = model.log_odds_miss
    out[(distance >= 0.0) & (np.abs(distance - z) <= half)] = model.log_odds_hit
    return out


def _check_window(window: float) -> None:
    if not (np.isfinite(window) and window >= 0.0):
        raise ConfigError("model.window", f"The hit window must be a finite width in metres, not {window!r}.")


@dataclass(frozen=True, slots=True)
class FixedIncrements:
    """Fixed evidence: ``log_odds_miss`` for a cell that a beam passed, ``log_odds_hit`` for one that it ended in.

    With ``window`` r > 0 metres every cell within r/2 of the reading counts as one it ended in; with r = 0 only the
    cell that holds the endpoint does. Source: OctoMap (Hornung et al. 2013, section 3.2: −0.4, +0.85).
    """

    log_odds_miss: float = -0.4
    log_odds_hit: float = 0.85
    window: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.log_odds_miss) and self.log_odds_miss <= 0.0):
            raise ConfigError(
                "model.miss", f"The miss increment must be finite and at most 0, not {self.log_odds_miss!r}."
            )
        if not (np.isfinite(self.log_odds_hit) and self.log_odds_hit >= 0.0):
            raise ConfigError(
                "model.hit", f"The hit increment must be finite and at least 0, not {self.log_odds_hit!r}."
            )
        _check_window(self.window)


@dataclass(frozen=True, slots=True)
class StepWindow:
    """The step window in probabilities: ``p_free`` for s < z − r/2, ``p_occ`` within the window, ``p_prior`` beyond.

    ``window`` is r in metres. As evidence: log-odds of each, minus the log-odds of the prior.
    Source: Probabilistic Robotics, table 9.2 with α = r.
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
