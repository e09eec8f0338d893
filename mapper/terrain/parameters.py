"""Parameters of ground filtering and of patches, one table each, used by the command line and the validation."""

from __future__ import annotations

from dataclasses import dataclass

from mapper.core.parameter import check_fields, choice, number, table_of

SWEEPS = 16  #: Jacobi sweeps at each level when cells without points are filled
BLOCK = 4  #: cells along the side of a block, whose minimum heights determine the slope around it
STEEPEST = 1.5  #: maximum rise over run between cells of continuous ground
RISE_SHARE = 0.5  #: rises of neighbouring cells may differ by the height of the limit plus this fraction of the rise
LEAST_INTO = 0.35  #: minimum fraction of sides into the ground, of those and the drops, for a segment to be restored
PLANE_REACH, PLANE_POINTS = 3, 5  #: size in cells of the plane next to a point, and the number of points that it needs
PLANE_SHARE = 0.3  #: points may be off that plane by the height of the limit plus this fraction of its rise over a cell


@dataclass(frozen=True, slots=True)
class GroundConfig:
    """Parameters of ground filtering; one value per row of ``GROUND_PARAMETERS``.

    The initial values of cell, window, scaling and low slope are those of Pingel, Clarke & McBride (2013) for all
    samples. Raises :class:`mapper.core.errors.ConfigError` for an invalid value.
    """

    # fmt: off
    cell: float = number(
        "cell", "ground", 1.0, "Side of the filter’s cells; each keeps its lowest point.", "m", 0.05, 20.0, 0.05,
    )
    slope: float = number(
        "slope", "ground", 0.12,
        "Steepest ground, rise over run: what rises faster above its surroundings is an object.",
        "", 0.01, 2.0, 0.01,
    )
    local_slope: float = number(
        "local slope", "ground", 0.5,
        "By how much faster the ground may rise where it is steep all around: this times the slope there.",
        "", 0.0, 2.0, 0.05,
    )
    window: float = number(
        "window", "ground", 18.0, "Radius of the largest disc: an object into which this disc fits remains as ground.",
        "m", 0.1, 100.0, 0.1,
    )
    height: float = number(
        "height", "ground", 0.3, "How far a ground point may be from the surface where it is level.",
        "m", 0.01, 5.0, 0.01,
    )
    scaling: float = number(
        "scaling", "ground", 1.25, "How much farther it may be where the surface is steep: this times the slope.",
        "m", 0.0, 5.0, 0.05,
    )
    low_slope: float = number(
        "low slope", "ground", 5.0,
        "A cell that drops more steeply below its neighbours, rise over run, is an outlier.",
        "", 0.5, 50.0, 0.5,
    )
    passes: float = number(
        "passes", "ground", 2.0, "How often the surface is computed; after the first pass from ground points only.",
        "", 1.0, 5.0, 1.0,
    )
    extensions: float = number(
        "extensions", "ground", 2.0, "How often points are added that lie on the plane of the ground beside them.",
        "", 0.0, 20.0, 1.0,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class PatchConfig:
    """Parameters of patches and their safety; one value per row of ``PATCH_PARAMETERS``.

    Raises :class:`mapper.core.errors.ConfigError` for an invalid value.
    """

    # fmt: off
    patch: float = number("patch", "patches", 1.0, "Side of a patch.", "m", 0.01, 100.0, 0.01)
    min_points: float = number("points", "patches", 3.0, "A patch with fewer points is unknown.", "", 3.0, 1000.0, 1.0)
    max_slope: float = number(
        "maximum slope", "patches", 20.0, "Slope above which a patch is unsafe by itself.", "°", 1.0, 89.0, 1.0,
    )
    max_roughness: float = number(
        "maximum roughness", "patches", 0.15,
        "Roughness, the RMS distance of the points from the plane, above which a patch is unsafe by itself.",
        "m", 0.001, 5.0, 0.001,
    )
    max_step: float = number(
        "maximum step", "patches", 0.3,
        "Step to the plane of a neighbouring patch above which a patch is unsafe by itself.",
        "m", 0.001, 5.0, 0.001,
    )
    fit: str = choice(
        "fit", "patches", "least_squares",
        "Planes are fitted by least squares to all points, or only to those that RANSAC keeps.",
        ("least_squares", "ransac"),
    )
    fit_distance: float = number(
        "RANSAC distance", "patches", 0.1,
        "RANSAC keeps the points that are at most this far from the plane that most points agree with.",
        "m", 0.005, 5.0, 0.005,
    )
    rule: str = choice(
        "rule", "patches", "weighted_sum",
        "A patch is unsafe where the weighted sum of slope, roughness and step, each over its greatest safe value, is "
        "above 1, or where one of them is (thresholds).",
        ("weighted_sum", "thresholds"),
    )
    slope_weight: float = number(
        "slope weight", "patches", 1.0, "Weight of slope / maximum slope in that sum.", "", 0.0, 1.0, 0.05,
    )
    roughness_weight: float = number(
        "roughness weight", "patches", 1.0, "Weight of roughness / maximum roughness in that sum.",
        "", 0.0, 1.0, 0.05,
    )
    step_weight: float = number(
        "step weight", "patches", 1.0, "Weight of step / maximum step in that sum.", "", 0.0, 1.0, 0.05,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


GROUND_PARAMETERS = table_of(GroundConfig)
PATCH_PARAMETERS = table_of(PatchConfig)
