"""The tables of parameters of the layers, with Nav2's names and defaults.

Source: the Nav2 documentation, Costmap 2D, and the declarations in nav2_costmap_2d.
"""

from __future__ import annotations

from dataclasses import dataclass

from mapper.core.parameter import Parameter, check_fields, check_table

#: Nav2's combination_method 0, 1 and 2; see :func:`mapper.costmap.textbook.combine`
COMBINATIONS = ("overwrite", "max", "max_known")


def _enabled(layer: str) -> Parameter:
    return Parameter("enabled", "Enabled", layer, "flag", True, "Whether the layer is used.")


def _number(
    name: str, label: str, group: str, initial: float, sentence: str, unit: str, bounds: tuple[float, float, float]
) -> Parameter:
    low, high, step = bounds
    return Parameter(name, label, group, "number", initial, sentence, unit, low, high, step)


COSTMAP_PARAMETERS: tuple[Parameter, ...] = (
    Parameter(
        "track_unknown_space", "Track unknown space", "costmap", "flag", False,
        "Whether cells that no layer knows are unknown (255) and not free (0).",
    ),
    _number("robot_radius", "Robot radius", "costmap", 0.1, "Radius of a round robot; used without a footprint.", "m",
            (0.0, 10.0, 0.01)),
    _number("footprint_padding", "Footprint padding", "costmap", 0.01, "Added to the footprint along both axes.", "m",
            (0.0, 1.0, 0.01)),
)  # fmt: skip

STATIC_PARAMETERS: tuple[Parameter, ...] = (
    _enabled("static"),
    Parameter(
        "trinary_costmap", "Trinary", "static", "flag", True,
        "Whether a cell is lethal, free or unknown, without costs between them.",
    ),
    _number("lethal_cost_threshold", "Lethal from", "static", 100, "Value of the map from which a cell is lethal.", "%",
            (1, 100, 1)),
    _number("inscribed_obstacle_cost_value", "Inscribed value", "static", 99,
            "Value of the map that means inscribed: what Nav2 publishes for a cost of 253.", "", (0, 255, 1)),
    _number("unknown_cost_value", "Unknown value", "static", 255, "Value of the map that means unknown.", "",
            (0, 255, 1)),
    Parameter(
        "use_maximum", "Use maximum", "static", "flag", False,
        "Whether the greater cost is kept where a layer before has one.",
    ),
    Parameter(
        "footprint_clearing_enabled", "Clear the footprint", "static", "flag", False,
        "Whether the cells under the robot are free.",
    ),
)  # fmt: skip

_OBSERVATIONS: tuple[Parameter, ...] = (
    Parameter("marking", "Marking", "obstacle", "flag", True, "Whether readings mark obstacles."),
    Parameter("clearing", "Clearing", "obstacle", "flag", True, "Whether readings clear what the beam passes."),
    _number("obstacle_min_range", "Least obstacle range", "obstacle", 0.0, "Nearer readings mark nothing.", "m",
            (0.0, 100.0, 0.05)),
    _number("obstacle_max_range", "Greatest obstacle range", "obstacle", 2.5, "Farther readings mark nothing.", "m",
            (0.0, 200.0, 0.1)),
    _number("raytrace_min_range", "Least clearing range", "obstacle", 0.0, "Nearer cells are not cleared.", "m",
            (0.0, 100.0, 0.05)),
    _number("raytrace_max_range", "Greatest clearing range", "obstacle", 3.0, "Farther cells are not cleared.", "m",
            (0.0, 200.0, 0.1)),
    Parameter(
        "inf_is_valid", "No return clears", "obstacle", "flag", False,
        "Whether a beam without return clears as far as the scan's greatest range.",
    ),
    _number("min_obstacle_height", "Least height", "obstacle", 0.0, "Lower points mark nothing.", "m",
            (-10.0, 10.0, 0.05)),
    _number("max_obstacle_height", "Greatest height", "obstacle", 2.0, "Higher points mark nothing.", "m",
            (-10.0, 50.0, 0.05)),
)  # fmt: skip

_COMBINED: tuple[Parameter, ...] = (
    Parameter(
        "footprint_clearing_enabled", "Clear the footprint", "obstacle", "flag", True,
        "Whether the cells under the robot are free.",
    ),
    Parameter(
        "combination_method", "Combination", "obstacle", "choice", "max",
        "How the layer is laid over those before: overwrite, the greater cost, or the greater cost of known cells.",
        choices=COMBINATIONS,
    ),
)  # fmt: skip

OBSTACLE_PARAMETERS: tuple[Parameter, ...] = (_enabled("obstacle"), *_OBSERVATIONS, *_COMBINED)

VOXEL_PARAMETERS: tuple[Parameter, ...] = (
    _enabled("voxel"),
    *_OBSERVATIONS,
    *_COMBINED,
    _number("origin_z", "Height of the columns", "voxel", 0.0, "Height of the lowest voxel.", "m", (-10.0, 10.0, 0.05)),
    _number("z_resolution", "Height of a voxel", "voxel", 0.2, "Height of a voxel.", "m", (0.01, 5.0, 0.01)),
    _number("z_voxels", "Voxels in a column", "voxel", 10, "Voxels in a column.", "", (1, 16, 1)),
    _number("mark_threshold", "Marked voxels", "voxel", 0, "Marked voxels that a lethal column has more than.", "",
            (0, 16, 1)),
    _number("unknown_threshold", "Unknown voxels", "voxel", 15,
            "A column with more unknown voxels, of 16, is unknown.", "", (0, 16, 1)),
)  # fmt: skip

DECAY_PARAMETERS: tuple[Parameter, ...] = (
    _enabled("dynamic"),
    *_OBSERVATIONS,
    *_COMBINED,
    _number("lifetime", "Lifetime", "dynamic", 10.0, "After this time an obstacle that is not seen again is forgotten.",
            "s", (0.1, 3600.0, 0.1)),
)  # fmt: skip

DENOISE_PARAMETERS: tuple[Parameter, ...] = (
    _enabled("denoise"),
    _number("minimal_group_size", "Least group", "denoise", 2,
            "Groups of fewer cells are removed; of 1 or less, none.", "", (0, 1_000_000, 1)),
    _number("group_connectivity_type", "Connectivity", "denoise", 8,
            "4: cells of a group have an edge in common; 8: an edge or a corner.", "", (0, 100, 1)),
)  # fmt: skip

GIVEN_PARAMETERS: tuple[Parameter, ...] = (_enabled("terrain"),)

INFLATION_PARAMETERS: tuple[Parameter, ...] = (
    _enabled("inflation"),
    _number("inflation_radius", "Inflation radius", "inflation", 0.55, "How far from an obstacle cells have a cost.",
            "m", (0.0, 20.0, 0.05)),
    _number("cost_scaling_factor", "Cost scaling factor", "inflation", 10.0,
            "How fast the cost falls outside the inscribed radius.", "1/m", (0.0, 100.0, 0.1)),
    Parameter(
        "inflate_unknown", "Inflate into unknown", "inflation", "flag", False,
        "Whether every cost, and not only an inscribed one, is written into unknown cells.",
    ),
    Parameter(
        "inflate_around_unknown", "Inflate around unknown", "inflation", "flag", False,
        "Whether unknown cells are inflated as obstacles are.",
    ),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class CostmapConfig:
    """Parameters of the whole costmap. Raises :class:`mapper.core.errors.ConfigError` for an impossible value."""

    track_unknown_space: bool = False
    robot_radius: float = 0.1
    footprint_padding: float = 0.01

    def __post_init__(self) -> None:
        check_fields(self, COSTMAP_PARAMETERS)


@dataclass(frozen=True, slots=True)
class StaticConfig:
    """Parameters of the static layer. Raises as :class:`CostmapConfig`."""

    enabled: bool = True
    trinary_costmap: bool = True
    lethal_cost_threshold: float = 100
    inscribed_obstacle_cost_value: float = 99
    unknown_cost_value: float = 255
    use_maximum: bool = False
    footprint_clearing_enabled: bool = False

    def __post_init__(self) -> None:
        check_fields(self, STATIC_PARAMETERS)


@dataclass(frozen=True, slots=True)
class ObstacleConfig:
    """Parameters of the obstacle layer and its one source of observations. Raises as :class:`CostmapConfig`."""

    enabled: bool = True
    marking: bool = True
    clearing: bool = True
    obstacle_min_range: float = 0.0
    obstacle_max_range: float = 2.5
    raytrace_min_range: float = 0.0
    raytrace_max_range: float = 3.0
    inf_is_valid: bool = False
    min_obstacle_height: float = 0.0
    max_obstacle_height: float = 2.0
    footprint_clearing_enabled: bool = True
    combination_method: str = "max"

    def __post_init__(self) -> None:
        check_fields(self, OBSTACLE_PARAMETERS)


@dataclass(frozen=True, slots=True)
class VoxelConfig(ObstacleConfig):
    """Parameters of the voxel layer. Raises as :class:`CostmapConfig`."""

    origin_z: float = 0.0
    z_resolution: float = 0.2
    z_voxels: float = 10
    mark_threshold: float = 0
    unknown_threshold: float = 15

    def __post_init__(self) -> None:
        check_fields(self, VOXEL_PARAMETERS)


@dataclass(frozen=True, slots=True)
class DecayConfig(ObstacleConfig):
    """Parameters of the layer of obstacles with a lifetime. Raises as :class:`CostmapConfig`."""

    lifetime: float = 10.0

    def __post_init__(self) -> None:
        check_fields(self, DECAY_PARAMETERS)


@dataclass(frozen=True, slots=True)
class DenoiseConfig:
    """Parameters of the layer that removes small groups of obstacles. Raises as :class:`CostmapConfig`."""

    enabled: bool = True
    minimal_group_size: float = 2
    group_connectivity_type: float = 8

    def __post_init__(self) -> None:
        check_fields(self, DENOISE_PARAMETERS)


@dataclass(frozen=True, slots=True)
class GivenConfig:
    """Parameters of a layer whose costs another module computes. Raises as :class:`CostmapConfig`."""

    enabled: bool = True

    def __post_init__(self) -> None:
        check_fields(self, GIVEN_PARAMETERS)


@dataclass(frozen=True, slots=True)
class InflationConfig:
    """Parameters of the inflation layer. Raises as :class:`CostmapConfig`."""

    enabled: bool = True
    inflation_radius: float = 0.55
    cost_scaling_factor: float = 10.0
    inflate_unknown: bool = False
    inflate_around_unknown: bool = False

    def __post_init__(self) -> None:
        check_fields(self, INFLATION_PARAMETERS)


for _config, _table in (
    (CostmapConfig, COSTMAP_PARAMETERS),
    (StaticConfig, STATIC_PARAMETERS),
    (ObstacleConfig, OBSTACLE_PARAMETERS),
    (VoxelConfig, VOXEL_PARAMETERS),
    (DecayConfig, DECAY_PARAMETERS),
    (DenoiseConfig, DENOISE_PARAMETERS),
    (GivenConfig, GIVEN_PARAMETERS),
    (InflationConfig, INFLATION_PARAMETERS),
):
    check_table(_config, _table)
