"""The parameters of ground filtering and of patches: one table each, which drives the command line and the checks."""

from __future__ import annotations

from dataclasses import dataclass

from mapper.core.parameter import Parameter, check_fields, check_table

GROUND_PARAMETERS = (
    Parameter("cell", "cell", "ground", "number", 1.0, "Side of the cells of the filter.", "m", 0.05, 20.0, 0.05),
    Parameter("slope", "slope", "ground", "number", 0.15, "Steepest ground, rise over run.", "", 0.01, 2.0, 0.01),
    Parameter("window", "window", "ground", "number", 18.0, "Radius of the largest disc.", "m", 0.1, 100.0, 0.1),
    Parameter(
        "height", "height", "ground", "number", 0.5, "A ground point's distance from flat ground.", "m", 0.01, 5.0, 0.01
    ),
    Parameter(
        "scaling",
        "scaling",
        "ground",
        "number",
        1.25,
        "More distance where it is steep, times the slope.",
        "m",
        0.0,
        5.0,
        0.05,
    ),
    Parameter(
        "low_slope",
        "low slope",
        "ground",
        "number",
        5.0,
        "A cell that lies deeper among its neighbours is an outlier.",
        "",
        0.5,
        50.0,
        0.5,
    ),
    Parameter(
        "passes",
        "passes",
        "ground",
        "number",
        2.0,
        "How often the surface is made; after the first time of ground points.",
        "",
        1.0,
        5.0,
        1.0,
    ),
)

PATCH_PARAMETERS = (
    Parameter("patch", "patch", "patches", "number", 1.0, "Side of a patch.", "m", 0.01, 100.0, 0.01),
    Parameter(
        "min_points", "points", "patches", "number", 3.0, "A patch with fewer points is unknown.", "", 3.0, 1000.0, 1.0
    ),
    Parameter(
        "max_slope", "greatest slope", "patches", "number", 20.0, "Slope that is unsafe by itself.", "°", 1.0, 89.0, 1.0
    ),
    Parameter(
        "max_roughness",
        "greatest roughness",
        "patches",
        "number",
        0.15,
        "Roughness that is unsafe by itself.",
        "m",
        0.001,
        5.0,
        0.001,
    ),
    Parameter(
        "max_step",
        "greatest step",
        "patches",
        "number",
        0.3,
        "Step between patches that is unsafe by itself.",
        "m",
        0.001,
        5.0,
        0.001,
    ),
    Parameter(
        "fit",
        "fit",
        "patches",
        "choice",
        "least_squares",
        "Planes of all points by least squares, or only of those that RANSAC keeps.",
        choices=("least_squares", "ransac"),
    ),
    Parameter(
        "fit_distance",
        "RANSAC distance",
        "patches",
        "number",
        0.1,
        "RANSAC keeps points up to this far from the plane of most.",
        "m",
        0.005,
        5.0,
        0.005,
    ),
    Parameter(
        "rule",
        "rule",
        "patches",
        "choice",
        "weighted_sum",
        "Unsafe: the weighted sum of the three ratios is above 1, or one of them alone (thresholds).",
        choices=("weighted_sum", "thresholds"),
    ),
    Parameter(
        "slope_weight",
        "weight of the slope",
        "patches",
        "number",
        1.0,
        "Weight of slope / greatest slope.",
        "",
        0.0,
        1.0,
        0.05,
    ),
    Parameter(
        "roughness_weight",
        "weight of the roughness",
        "patches",
        "number",
        1.0,
        "Weight of roughness / greatest roughness.",
        "",
        0.0,
        1.0,
        0.05,
    ),
    Parameter(
        "step_weight",
        "weight of the step",
        "patches",
        "number",
        1.0,
        "Weight of step / greatest step.",
        "",
        0.0,
        1.0,
        0.05,
    ),
)


@dataclass(frozen=True, slots=True)
class GroundConfig:
    """Parameters of ground filtering; a value per row of ``GROUND_PARAMETERS``.

    The first values are the one set of parameters that Pingel, Clarke & McBride (2013) give for all samples. Raises
    :class:`mapper.core.errors.ConfigError` for an invalid value.
    """

    cell: float = 1.0
    slope: float = 0.15
    window: float = 18.0
    height: float = 0.5
    scaling: float = 1.25
    low_slope: float = 5.0
    passes: float = 2.0

    def __post_init__(self) -> None:
        check_fields(self, GROUND_PARAMETERS)


@dataclass(frozen=True, slots=True)
class PatchConfig:
    """Patches and when they are safe; a value per row of ``PATCH_PARAMETERS``.

    Raises :class:`mapper.core.errors.ConfigError` for an invalid value.
    """

    patch: float = 1.0
    min_points: float = 3.0
    max_slope: float = 20.0
    max_roughness: float = 0.15
    max_step: float = 0.3
    fit: str = "least_squares"
    fit_distance: float = 0.1
    rule: str = "weighted_sum"
    slope_weight: float = 1.0
    roughness_weight: float = 1.0
    step_weight: float = 1.0

    def __post_init__(self) -> None:
        check_fields(self, PATCH_PARAMETERS)


check_table(GroundConfig, GROUND_PARAMETERS)
check_table(PatchConfig, PATCH_PARAMETERS)
