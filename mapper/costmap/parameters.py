"""Parameter tables of the layers, with Nav2's names and defaults.

Source: the Nav2 documentation, Costmap 2D, and the declarations in nav2_costmap_2d.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from mapper.core.errors import ConfigError
from mapper.core.parameter import check_fields, choice, flag, number, table_of

#: Nav2's combination_method 0, 1 and 2; see :func:`mapper.costmap.textbook.combine`
COMBINATIONS = ("overwrite", "max", "max_known")


def _enabled(layer: str) -> bool:
    return flag("Enabled", layer, True, "Whether the layer is used.")


@dataclass(frozen=True, slots=True)
class CostmapConfig:
    """Parameters of the whole costmap. Raises :class:`mapper.core.errors.ConfigError` for an impossible value."""

    # fmt: off
    track_unknown_space: bool = flag(
        "Track unknown space", "costmap", False,
        "Whether cells that no layer knows are unknown (255) and not free (0).",
    )
    robot_radius: float = number(
        "Robot radius", "costmap", 0.1, "Radius of a round robot; used without a footprint.", "m", 0.0, 10.0, 0.01,
    )
    footprint_padding: float = number(
        "Footprint padding", "costmap", 0.01, "Added to the footprint along both axes.", "m", 0.0, 1.0, 0.01,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class StaticConfig:
    """Parameters of the static layer. Raises the errors of :class:`CostmapConfig`."""

    # fmt: off
    enabled: bool = _enabled("static")
    trinary_costmap: bool = flag(
        "Trinary", "static", True, "Whether a cell is lethal, free or unknown, without costs between them.",
    )
    lethal_cost_threshold: float = number(
        "Lethal threshold", "static", 100, "Value of the map from which a cell is lethal.", "%", 1, 100, 1,
    )
    inscribed_obstacle_cost_value: float = number(
        "Inscribed value", "static", 99,
        "Value of the map that means inscribed: what Nav2 publishes for a cost of 253.", "", 0, 255, 1,
    )
    unknown_cost_value: float = number(
        "Unknown value", "static", 255, "Value of the map that means unknown.", "", 0, 255, 1,
    )
    use_maximum: bool = flag(
        "Use maximum", "static", False, "Whether the greater cost is kept where a layer before has one.",
    )
    footprint_clearing_enabled: bool = flag(
        "Clear the footprint", "static", False, "Whether the cells under the robot are free.",
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class ReadingsConfig:
    """Parameters of marking and clearing, shared by observation sources and obstacle layers.

    The initial values are Nav2's for a source. Raises the errors of :class:`CostmapConfig`.
    """

    # fmt: off
    marking: bool = flag("Marking", "obstacle", True, "Whether readings mark obstacles.")
    clearing: bool = flag("Clearing", "obstacle", False, "Whether readings clear what the beam passes.")
    obstacle_min_range: float = number(
        "Minimum obstacle range", "obstacle", 0.0, "Nearer readings mark nothing.", "m", 0.0, 100.0, 0.05,
    )
    obstacle_max_range: float = number(
        "Maximum obstacle range", "obstacle", 2.5, "Farther readings mark nothing.", "m", 0.0, 200.0, 0.1,
    )
    raytrace_min_range: float = number(
        "Minimum clearing range", "obstacle", 0.0, "Nearer cells are not cleared.", "m", 0.0, 100.0, 0.05,
    )
    raytrace_max_range: float = number(
        "Maximum clearing range", "obstacle", 3.0, "Farther cells are not cleared.", "m", 0.0, 200.0, 0.1,
    )
    inf_is_valid: bool = flag(
        "No return clears", "obstacle", False,
        "Whether a beam without return clears as far as the scan’s greatest range.",
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class SourceConfig(ReadingsConfig):
    """Parameters of an observation source of an obstacle layer. Raises the errors of :class:`CostmapConfig`.

    A point outside its heights neither marks nor clears. The initial values are Nav2's, with which a source marks
    points at a height of 0 m and clears nothing.
    """

    # fmt: off
    min_obstacle_height: float = number(
        "Minimum height", "source", 0.0, "Lower points are left out.", "m", -10.0, 10.0, 0.05,
    )
    max_obstacle_height: float = number(
        "Maximum height", "source", 0.0, "Higher points are left out.", "m", -10.0, 50.0, 0.05,
    )
    # fmt: on


@dataclass(frozen=True, slots=True)
class NamedSource:
    """An observation source of a parameter file: its name, its parameters and its topic.

    Without ``topic`` the topic has the name of the source. ``data_type`` is LaserScan or PointCloud2.
    """

    name: str
    config: SourceConfig
    topic: str = ""
    data_type: str = "LaserScan"


@dataclass(frozen=True, slots=True)
class ObstacleConfig(ReadingsConfig):
    """Parameters of the obstacle layer and its observation sources. Raises the errors of :class:`CostmapConfig`.

    If ``sources`` is None there is one source, whose parameters are those from ``marking`` to ``inf_is_valid``;
    otherwise each source has its own, and a layer with no sources has no observations. The heights are the layer's
    limits for marking.
    """

    # fmt: off
    enabled: bool = _enabled("obstacle")
    clearing: bool = flag("Clearing", "obstacle", True, "Whether readings clear what the beam passes.")
    min_obstacle_height: float = number(
        "Minimum height", "obstacle", 0.0, "Lower points mark nothing.", "m", -10.0, 10.0, 0.05,
    )
    max_obstacle_height: float = number(
        "Maximum height", "obstacle", 2.0, "Higher points mark nothing.", "m", -10.0, 50.0, 0.05,
    )
    footprint_clearing_enabled: bool = flag(
        "Clear the footprint", "obstacle", True, "Whether the cells under the robot are free.",
    )
    combination_method: str = choice(
        "Combination method", "obstacle", "max",
        "How the layer is laid over those before: overwrite, the greater cost, or the greater cost of known cells.",
        COMBINATIONS,
    )
    # fmt: on
    sources: tuple[NamedSource, ...] | None = None

    def source(self, name: str | None) -> SourceConfig:
        """Return the parameters of a source, None for the first one. Raises :class:`ConfigError` for an unknown
        source.
        """
        if self.sources is None and name is None:
            own = {row.name: getattr(self, row.name) for row in SOURCE_PARAMETERS}
            return SourceConfig(**own)
        for source in self.sources or ():
            if name in (None, source.name):
                return source.config
        raise ConfigError("costmap.source", f"The layer has no source of observations {name!r:.80}.")

    def sources_of_scans(self, topic: str = "", topics: Collection[str] = ()) -> tuple[str | None, ...]:
        """Return the names of the sources that receive the scans of one lidar.

        ``topic`` is the lidar's, one of ``topics``. They are the LaserScan sources with its topic or, if none has one
        of these topics (:meth:`has_topic_of`), those with the first source's topic.
        """
        if self.sources is None:
            return (None,)
        observed_topic = (
            _topic_name(topic) if self.has_topic_of(topics) else next(iter(self._topics_of_scans.values()), "")
        )
        return tuple(name for name, of_source in self._topics_of_scans.items() if of_source == observed_topic)

    def has_topic_of(self, topics: Collection[str]) -> bool:
        """Whether a LaserScan source has one of these topics."""
        return bool({_topic_name(topic) for topic in topics} & set(self._topics_of_scans.values()))

    @property
    def _topics_of_scans(self) -> dict[str, str]:
        """The topics of the LaserScan sources by name, in order."""
        scans = [source for source in self.sources or () if source.data_type == "LaserScan"]
        return {source.name: _topic_name(source.topic or source.name) for source in scans}


def _topic_name(topic: str) -> str:
    """Return a topic name without the leading slash and without the tf prefix."""
    return topic.partition("#")[0].strip("/")


@dataclass(frozen=True, slots=True)
class VoxelConfig(ObstacleConfig):
    """Parameters of the voxel layer. Raises the errors of :class:`CostmapConfig`."""

    # fmt: off
    enabled: bool = _enabled("voxel")
    origin_z: float = number(
        "Lowest voxel", "voxel", 0.0, "Height of the lowest voxel.", "m", -10.0, 10.0, 0.05,
    )
    z_resolution: float = number("Voxel height", "voxel", 0.2, "Height of a voxel.", "m", 0.01, 5.0, 0.01)
    z_voxels: float = number("Voxels per column", "voxel", 10, "Voxels in a column.", "", 1, 16, 1)
    mark_threshold: float = number(
        "Mark threshold", "voxel", 0, "A column with more marked voxels is lethal.", "", 0, 16, 1,
    )
    unknown_threshold: float = number(
        "Unknown threshold", "voxel", 15, "A column with more unknown voxels, of 16, is unknown.", "", 0, 16, 1,
    )
    # fmt: on


@dataclass(frozen=True, slots=True)
class DecayConfig(ObstacleConfig):
    """Parameters of the obstacle layer with a lifetime. Raises the errors of :class:`CostmapConfig`."""

    # fmt: off
    enabled: bool = _enabled("dynamic")
    lifetime: float = number(
        "Lifetime", "dynamic", 10.0, "After this time an obstacle that is not seen again is forgotten.",
        "s", 0.1, 3600.0, 0.1,
    )
    # fmt: on


@dataclass(frozen=True, slots=True)
class DenoiseConfig:
    """Parameters of the layer that removes small groups of obstacles. Raises the errors of :class:`CostmapConfig`."""

    # fmt: off
    enabled: bool = _enabled("denoise")
    minimal_group_size: float = number(
        "Minimum group size", "denoise", 2, "Groups of fewer cells are removed; of 1 or less, none.",
        "", 0, 1_000_000, 1,
    )
    group_connectivity_type: float = number(
        "Connectivity", "denoise", 8, "4: cells of a group have an edge in common; 8: an edge or a corner.", "",
        0, 100, 1,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class GivenConfig:
    """Parameters of a layer with externally computed costs. Raises the errors of :class:`CostmapConfig`."""

    # fmt: off
    enabled: bool = _enabled("terrain")
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class InflationConfig:
    """Parameters of the inflation layer. Raises the errors of :class:`CostmapConfig`."""

    # fmt: off
    enabled: bool = _enabled("inflation")
    inflation_radius: float = number(
        "Inflation radius", "inflation", 0.55, "How far from an obstacle cells have a cost.", "m", 0.0, 20.0, 0.05,
    )
    cost_scaling_factor: float = number(
        "Cost scaling factor", "inflation", 10.0, "How fast the cost falls outside the inscribed radius.",
        "1/m", 0.0, 100.0, 0.1,
    )
    inflate_unknown: bool = flag(
        "Inflate into unknown", "inflation", False,
        "Whether every cost, and not only an inscribed one, is written into unknown cells.",
    )
    inflate_around_unknown: bool = flag(
        "Inflate around unknown", "inflation", False, "Whether unknown cells are inflated as obstacles are.",
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)


COSTMAP_PARAMETERS = table_of(CostmapConfig)
STATIC_PARAMETERS = table_of(StaticConfig)
SOURCE_PARAMETERS = table_of(SourceConfig)
OBSTACLE_PARAMETERS = table_of(ObstacleConfig)
VOXEL_PARAMETERS = table_of(VoxelConfig)
DECAY_PARAMETERS = table_of(DecayConfig)
DENOISE_PARAMETERS = table_of(DenoiseConfig)
GIVEN_PARAMETERS = table_of(GivenConfig)
INFLATION_PARAMETERS = table_of(InflationConfig)
