"""Cached bounds of a whole log."""

from __future__ import annotations

from dataclasses import fields

from mapper.mapping.integrate import Bounds, bounds_of_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog

#: Parameters that change the values of cells but not which place a log sees. Any other one is part of the key.
WITHOUT_EFFECT = frozenset({
    "log_odds_hit", "log_odds_miss", "p_free", "p_occ", "cone_profile", "prior_weight", "traversal", "clamp",
    "log_odds_min", "log_odds_max", "log_odds_prior",
})  # fmt: skip
CAPACITY = 8  #: bounds kept

_KEY = tuple(field.name for field in fields(MappingConfig) if field.name not in WITHOUT_EFFECT)


class BoundsCache:
    """Computes the bounds of a log (:func:`mapper.mapping.integrate.bounds_of_log`) once per set of parameters.

    It serves one log, and keeps the bounds that were requested last.
    """

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], Bounds] = {}

    def __call__(self, log: ScanLog, config: MappingConfig, trajectory: str | None) -> Bounds:
        """Return the least and the greatest x, y (2,), metres, of all that ``log`` sees with ``config``."""
        key = (trajectory, *(getattr(config, name) for name in _KEY))
        found = self._known.pop(key, None)
        if found is None:
            found = bounds_of_log(log, config, trajectory)
        self._known[key] = found  # the newest is last
        if len(self._known) > CAPACITY:
            del self._known[next(iter(self._known))]
        return found
