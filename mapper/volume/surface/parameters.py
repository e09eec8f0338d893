"""Table of parameters of truncated signed distance fields.

Source: Curless & Levoy, A volumetric method for building complex models from range images, SIGGRAPH 1996; Newcombe et
al., KinectFusion: real-time dense surface mapping and tracking, ISMAR 2011, section 3.3; Oleynikova et al., Voxblox:
incremental 3D Euclidean signed distance fields for on-board MAV planning, IROS 2017, section IV-A, for the weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.errors import ConfigError
from mapper.core.parameter import check_fields, choice, flag, number, table_of

TRUNCATION_VOXELS = 4.0  #: default truncation in voxels


@dataclass(frozen=True, slots=True)
class TsdfConfig:
    """Parameters of :class:`mapper.volume.surface.tsdf.TsdfVolume`, see the table :data:`TSDF_PARAMETERS`.

    Raises :class:`ConfigError` for a value outside its row and for a truncation of less than two voxels.
    """

    # fmt: off
    resolution: float = number("Resolution", "tsdf", 0.02, "Side of a voxel.", "m", 0.001, 10.0, 0.005)
    truncation: float = number(
        "Truncation", "tsdf", 0.0,
        "Distance from the surface, before and behind it, within which voxels are updated; 0 is four voxels.",
        "m", 0.0, 50.0, 0.01,
    )
    max_weight: float = number(
        "Maximum weight", "tsdf", 64.0,
        "Weight at which a voxel’s mean becomes a moving average, so that the surface can still change.",
        "", 1.0, 10000.0, 1.0,
    )
    weighting: str = choice(
        "Weight", "tsdf", "constant",
        "Weight of one measurement: 1, or 1 / depth², as the noise of depth cameras grows with the depth.",
        ("constant", "inverse_square"),
    )
    drop_off: bool = flag(
        "Drop off", "tsdf", False, "Whether the weight falls to 0 from one voxel behind the surface to the truncation.",
    )
    carve: bool = flag(
        "Carve", "tsdf", True,
        "Whether voxels of the map’s blocks farther in front of the surface than the truncation are updated too, as "
        "free, so that what is seen through goes away.",
    )
    range_max: float = number(
        "Maximum range", "tsdf", 0.0, "Depths and ranges beyond are left out; 0 is no limit.", "m", 0.0, 1000.0, 0.5,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)
        if 0.0 < self.truncation < 2.0 * self.resolution:
            raise ConfigError(
                "parameter.truncation",
                f"A truncation of {self.truncation:g} m is less than two voxels of {self.resolution:g} m: the surface "
                "would have holes.",
            )

    @property
    def band(self) -> np.float32:
        """The truncation distance in metres."""
        return np.float32(self.truncation or TRUNCATION_VOXELS * self.resolution)

    @property
    def far(self) -> np.float32:
        """The maximum depth or range, metres; without a limit the greatest finite number, because infinity means no
        return.
        """
        return np.float32(self.range_max or np.finfo(np.float32).max)


TSDF_PARAMETERS = table_of(TsdfConfig)
