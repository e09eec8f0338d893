"""Options for planar scans extracted from point clouds and depth images.

Names and initial values are those of the ROS packages pointcloud_to_laserscan and depthimage_to_laserscan. Heights that
are unlimited there are limited to :data:`HIGHEST` here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter, check_fields, number, table_of

HIGHEST = 1000.0  #: metres


def _number(label: str, initial: float, bounds: tuple[float, float], unit: str, sentence: str) -> float:
    return number(label, "cut", initial, sentence, unit, *bounds, step=0.0)


_HEIGHTS, _BEARINGS = (-HIGHEST, HIGHEST), (-math.pi, math.pi)

#: Message types from which scans are extracted, without their package: clouds (CustomMsg is Livox's), depth images.
CLOUDS, IMAGE = ("PointCloud2", "CustomMsg"), "Image"


def is_cut(kind: str) -> bool:
    """Return whether scans are extracted from messages of the type ``kind``."""
    return kind.rpartition("/")[2] in (*CLOUDS, IMAGE)


def applies(row: Parameter, kind: str) -> bool:
    """Return whether a row of :data:`PARAMETERS` applies to messages of the type ``kind``."""
    name = kind.rpartition("/")[2]
    return name == IMAGE if row.name == "scan_height" else name in CLOUDS


@dataclass(frozen=True, slots=True)
class PlanarCut:
    """Values of all rows of :data:`PARAMETERS`; metres, radians and pixels.

    ``cloud_range`` and ``depth_range`` are (minimum, maximum) valid readings in metres. ``output_frame`` is the frame,
    x forward, of scans from depth images; empty: the image's own. Raises :class:`ConfigError` for values outside the
    table's bounds, and for an empty band or sector.
    """

    # fmt: off
    min_height: float = _number(
        "Minimum height", 0.0, _HEIGHTS, "m",
        "Of a point cloud, points lower than this above the robot’s base frame are left out.",
    )
    max_height: float = _number(
        "Maximum height", HIGHEST, _HEIGHTS, "m",
        "Of a point cloud, points higher than this above the robot’s base frame are left out.",
    )
    angle_min: float = _number(
        "First bearing", -math.pi, _BEARINGS, "rad",
        "Where the scan that is cut out of a point cloud begins, counter-clockwise from straight ahead.",
    )
    angle_max: float = _number(
        "Last bearing", math.pi, _BEARINGS, "rad", "Where the scan that is cut out of a point cloud ends.",
    )
    angle_increment: float = _number(
        "Angle between beams", math.pi / 180.0, (1e-3, math.pi / 2.0), "rad",
        "The angle between two beams of a scan that is cut out of a point cloud.",
    )
    scan_height: float = _number(
        "Rows of the image", 1.0, (1.0, 10_000.0), "pixels",
        "How many rows of a depth image, around its optical centre, a scan is cut out of.",
    )
    # fmt: on
    cloud_range: tuple[float, float] = (0.0, math.inf)
    depth_range: tuple[float, float] = (0.45, 10.0)
    output_frame: str = ""

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.min_height < self.max_height:
            raise ConfigError(
                "cut.heights",
                f"The least height must be below the greatest, not {self.min_height:g} and {self.max_height:g} m.",
            )
        if not self.angle_max - self.angle_min >= self.angle_increment:
            raise ConfigError(
                "cut.angles",
                f"Between {self.angle_min:g} and {self.angle_max:g} rad there is no beam with an angle_increment of "
                f"{self.angle_increment:g} rad.",
            )

    @staticmethod
    def of(values: Mapping[str, object]) -> PlanarCut:
        """Return a cut with these values of :data:`PARAMETERS` and the initial values of all others.

        Raises :class:`ConfigError` for names that the table lacks, and the errors of the constructor.
        """
        unknown = sorted(values.keys() - BY_NAME.keys())
        if unknown:
            raise ConfigError("cut.unknown", f"There is no parameter {unknown[0]!r:.80} of how a scan is cut.")
        return replace(PlanarCut(), **values)  # type: ignore[arg-type] # the constructor checks them

    @property
    def values(self) -> dict[str, float]:
        """The values of :data:`PARAMETERS`."""
        return {name: float(getattr(self, name)) for name in BY_NAME}

    @property
    def n_beams(self) -> int:
        """Number of beams of a scan extracted from a cloud."""
        return math.ceil((self.angle_max - self.angle_min) / self.angle_increment)


PARAMETERS = table_of(PlanarCut)
BY_NAME = {row.name: row for row in PARAMETERS}
