"""Table of parameters of 3D occupancy, with OctoMap's defaults.

Source: Hornung, Wurm, Bennewitz, Stachniss & Burgard, OctoMap: an efficient probabilistic 3D mapping framework based on
octrees, Autonomous Robots 34, 2013, section 3; the defaults are those of the class OcTree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mapper.core.errors import ConfigError
from mapper.core.parameter import check_fields, flag, number, table_of


@dataclass(frozen=True, slots=True)
class VolumeConfig:
    """Parameters of :class:`mapper.volume.occupancy.volume.OccupancyVolume`, see the table :data:`VOLUME_PARAMETERS`.

    Raises :class:`ConfigError` for a value outside its row.
    """

    # fmt: off
    resolution: float = number("Resolution", "volume", 0.1, "Side of a voxel.", "m", 0.001, 10.0, 0.01)
    p_hit: float = number(
        "Hit", "volume", 0.7, "Occupancy probability of a voxel in which a beam ends.", "", 0.5, 0.99, 0.01,
    )
    p_miss: float = number(
        "Miss", "volume", 0.4, "Occupancy probability of a voxel that a beam passes.", "", 0.01, 0.5, 0.01,
    )
    p_min: float = number(
        "Lower clamp", "volume", 0.1192, "Least occupancy probability that a voxel reaches.", "", 0.001, 0.49, 0.001,
    )
    p_max: float = number(
        "Upper clamp", "volume", 0.971, "Greatest occupancy probability that a voxel reaches.", "", 0.51, 0.999, 0.001,
    )
    p_occupied: float = number(
        "Occupancy threshold", "volume", 0.5, "Occupancy probability from which a voxel is occupied.",
        "", 0.1, 0.95, 0.01,
    )
    range_max: float = number(
        "Maximum range", "volume", 0.0, "Beams are cut here and mark free voxels only; 0 is no limit.",
        "m", 0.0, 1000.0, 0.5,
    )
    discretise: bool = flag(
        "Discretise", "volume", True,
        "Whether a scan has one beam to the centre of each voxel that has points, or one beam to each point.",
    )
    half_life: float = number(
        "Half-life", "volume", 0.0,
        "Time in which log-odds fall by half, so that what is not seen again is forgotten; 0 is never.",
        "s", 0.0, 86400.0, 1.0,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.p_min < self.p_occupied < self.p_max:
            raise ConfigError(
                "parameter.p_occupied",
                f"A voxel is occupied from {self.p_occupied:g}, which must lie between the least and the greatest "
                f"probability, {self.p_min:g} and {self.p_max:g}.",
            )

    @property
    def log_odds_hit(self) -> np.float32:
        """Log-odds added by a beam's end."""
        return log_odds(self.p_hit)

    @property
    def log_odds_miss(self) -> np.float32:
        """Log-odds added by a passing beam."""
        return log_odds(self.p_miss)

    @property
    def log_odds_min(self) -> np.float32:
        """Minimum log-odds of a voxel."""
        return log_odds(self.p_min)

    @property
    def log_odds_max(self) -> np.float32:
        """Maximum log-odds of a voxel."""
        return log_odds(self.p_max)

    @property
    def log_odds_occupied(self) -> np.float32:
        """Log-odds at and above which a voxel is occupied."""
        return log_odds(self.p_occupied)


def log_odds(p: float) -> np.float32:
    """Return log(p / (1 − p)) as float32, as stored by OctoMap."""
    return np.float32(math.log(p / (1.0 - p)))


VOLUME_PARAMETERS = table_of(VolumeConfig)
