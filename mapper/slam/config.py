"""The one table of SLAM parameters, and one value for each row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from mapper.core.parameter import Parameter, check_fields, check_names, check_table

SLAM_PARAMETERS: tuple[Parameter, ...] = (
    Parameter(
        "range_max", "Longest range", "scans", "number", 30.0,
        "Readings of this range and more are not matched.",
        unit="m", low=1.0, high=200.0, step=1.0,
    ),
    Parameter(
        "n_beams", "Beams", "scans", "number", 360,
        "Of scans with more beams each second, third … one is taken, so that at most this many remain.",
        low=30, high=4000, step=30,
    ),
    Parameter(
        "node_distance", "Distance of nodes", "scans", "number", 0.05,
        "A scan becomes a node where the odometry, or without one the scans, moved this far since the last; others are "
        "carried along.",
        unit="m", low=0.0, high=2.0, step=0.01,
    ),
    Parameter(
        "node_turn", "Turn of nodes", "scans", "number", 0.035,
        "A scan becomes a node where the odometry, or without one the scans, turned this far since the last.",
        unit="rad", low=0.0, high=1.0, step=0.005,
    ),
    Parameter(
        "max_nodes", "Most nodes", "scans", "number", 20_000,
        "Of longer logs fewer scans are matched, so that memory and time stay bounded.",
        low=100, high=200_000, step=100,
    ),
    Parameter(
        "neighbours", "Scans to match with", "front end", "number", 8,
        "Each scan is aligned with this many scans before it.",
        low=1, high=30, step=1,
    ),
    Parameter(
        "submap_scans", "Scans of half a submap", "front end", "number", 20,
        "A submap holds twice as many scans; each half is shared with the next submap.",
        low=5, high=200, step=5,
    ),
    Parameter(
        "loop_closure", "Close loops", "loops", "flag", True,
        "Look for places that the robot was at before.",
    ),
    Parameter(
        "loop_distance", "Distance of attempts", "loops", "number", 0.7,
        "A loop is looked for each time the robot moved this far.",
        unit="m", low=0.1, high=20.0, step=0.1,
    ),
    Parameter(
        "loop_window", "Largest search window", "loops", "number", 4.0,
        "How far from the estimated pose a loop is looked for at most, to each side.",
        unit="m", low=0.5, high=15.0, step=0.5,
    ),
    Parameter(
        "loop_score", "Least score", "loops", "number", 0.55,
        "Share of the greatest possible correlation score that a loop must reach.",
        low=0.2, high=1.0, step=0.01,
    ),
    Parameter(
        "loop_contradicted", "Most contradicted", "loops", "number", 0.12,
        "Share of the points of a loop's scan, and of the scans on the way to one from far away in the graph or to a "
        "recognized place, that may lie where the other scans saw free space.",
        low=0.0, high=1.0, step=0.01,
    ),
    Parameter(
        "loop_inliers", "Least inliers", "loops", "number", 0.55,
        "Share of the points in view that must lie on the walls of the earlier scans for a loop to be accepted.",
        low=0.2, high=1.0, step=0.01,
    ),
    Parameter(
        "place_recognition", "Recognize places", "loops", "flag", True,
        "Where no loop closes in the search window, look for corners that an earlier submap has too.",
    ),
    Parameter(
        "place_drift", "Drift up to recognition", "loops", "number", 0.15,
        "How far the pose may be off where a place is recognized, for each metre driven since.",
        unit="m/m", low=0.02, high=1.0, step=0.01,
    ),
    Parameter(
        "place_length", "Way of a place", "loops", "number", 10.0,
        "How much of the way becomes the submap by whose corners a place is recognized.",
        unit="m", low=3.0, high=50.0, step=1.0,
    ),
    Parameter(
        "place_corners", "Least corners", "loops", "number", 5,
        "Corners of two submaps that must coincide for their scans to be matched.",
        low=3, high=40, step=1,
    ),
    Parameter(
        "place_group", "Least loops of a place", "loops", "number", 5,
        "Loops at a recognized place that must agree with one another to be accepted.",
        low=3, high=30, step=1,
    ),
    Parameter(
        "robust", "Robust kernel", "graph", "choice", "geman_mcclure",
        "How loops that contradict the rest of the graph lose weight.",
        choices=("geman_mcclure", "cauchy", "huber", "none"),
    ),
    Parameter(
        "robust_scale", "Scale of the kernel", "graph", "number", 3.0,
        "Residuals, in standard deviations, that are larger than this lose weight.",
        low=0.5, high=50.0, step=0.5,
    ),
    Parameter(
        "refinement", "Refinement iterations", "refinement", "number", 3,
        "Iterations in which all scans are aligned with their neighbours in space at once; 0 for none.",
        low=0, high=20, step=1,
    ),
    Parameter(
        "refinement_neighbours", "Neighbours in space", "refinement", "number", 8,
        "Each scan is aligned with this many scans taken nearby.",
        low=1, high=30, step=1,
    ),
)  # fmt: skip

BY_NAME: Mapping[str, Parameter] = {row.name: row for row in SLAM_PARAMETERS}


@dataclass(frozen=True, slots=True)
class SlamConfig:
    """One value for each row of :data:`SLAM_PARAMETERS`; units and meanings are in the table.

    Raises :class:`ConfigError` naming the parameter that is refused.
    """

    range_max: float = 30.0
    n_beams: float = 360
    node_distance: float = 0.05
    node_turn: float = 0.035
    max_nodes: float = 20_000
    neighbours: float = 8
    submap_scans: float = 20
    loop_closure: bool = True
    loop_distance: float = 0.7
    loop_window: float = 4.0
    loop_score: float = 0.55
    loop_contradicted: float = 0.12
    loop_inliers: float = 0.55
    place_recognition: bool = True
    place_drift: float = 0.15
    place_length: float = 10.0
    place_corners: float = 5
    place_group: float = 5
    robust: str = "geman_mcclure"
    robust_scale: float = 3.0
    refinement: float = 3
    refinement_neighbours: float = 8

    def __post_init__(self) -> None:
        check_fields(self, SLAM_PARAMETERS)

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name."""
        return asdict(self)

    def with_values(self, values: Mapping[str, Any]) -> SlamConfig:
        """Return the config with these values replaced. Raises :class:`ConfigError` for a name or a value."""
        check_names(values, SLAM_PARAMETERS, "SLAM parameter")
        return SlamConfig(**{**asdict(self), **values})


check_table(SlamConfig, SLAM_PARAMETERS)
