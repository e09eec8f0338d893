"""Table of SLAM parameters, and a config with one value for each row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mapper.core.parameter import check_fields, choice, flag, number, table_of, with_values


@dataclass(frozen=True, slots=True)
class SlamConfig:
    """Values of all rows of :data:`SLAM_PARAMETERS`; each field states its unit and meaning.

    Raises :class:`ConfigError` naming the invalid parameter.
    """

    # fmt: off
    range_max: float = number(
        "Maximum range", "scans", 30.0, "Readings of this range and more are not matched.", "m", 1.0, 200.0, 1.0,
    )
    n_beams: float = number(
        "Maximum beams", "scans", 360,
        "Of scans with more beams only every second, third … is used, so that at most this many remain.",
        "", 30, 4000, 30,
    )
    node_distance: float = number(
        "Node spacing", "scans", 0.05,
        "A scan becomes a node where the odometry, or without one the scans, moved this far since the last; others are "
        "carried along.", "m", 0.0, 2.0, 0.01,
    )
    node_turn: float = number(
        "Node rotation", "scans", 0.035,
        "A scan becomes a node where the odometry, or without one the scans, turned this far since the last.",
        "rad", 0.0, 1.0, 0.005,
    )
    max_nodes: float = number(
        "Maximum nodes", "scans", 20_000,
        "Of longer logs fewer scans are matched, so that memory and time stay bounded.", "", 100, 200_000, 100,
    )
    neighbours: float = number(
        "Scans to match with", "front end", 8, "Each scan is aligned with this many scans before it.", "", 1, 30, 1,
    )
    submap_scans: float = number(
        "Scans per half submap", "front end", 20,
        "A submap holds twice as many scans; each half is shared with the next submap.", "", 5, 200, 5,
    )
    loop_closure: bool = flag("Close loops", "loops", True, "Look for places that the robot was at before.")
    loop_distance: float = number(
        "Loop search interval", "loops", 0.7, "A loop is looked for each time the robot moved this far.",
        "m", 0.1, 20.0, 0.1,
    )
    loop_window: float = number(
        "Maximum search window", "loops", 4.0,
        "How far from the estimated pose a loop is looked for at most, to each side.", "m", 0.5, 15.0, 0.5,
    )
    loop_score: float = number(
        "Minimum score", "loops", 0.55, "Share of the greatest possible correlation score that a loop must reach.",
        "", 0.2, 1.0, 0.01,
    )
    loop_contradicted: float = number(
        "Maximum contradicted share", "loops", 0.12,
        "Share of the points of a loop’s scan, and of the scans on the way to one from far away in the graph or to a "
        "recognized place, that may lie where the other scans saw free space.", "", 0.0, 1.0, 0.01,
    )
    loop_inliers: float = number(
        "Minimum inliers", "loops", 0.55,
        "Share of the points in view that must lie on the walls of the earlier scans for a loop to be accepted.",
        "", 0.2, 1.0, 0.01,
    )
    place_recognition: bool = flag(
        "Recognize places", "loops", True,
        "Where no loop closes in the search window, look for corners that an earlier submap has too.",
    )
    place_drift: float = number(
        "Drift before recognition", "loops", 0.15,
        "How far the pose may be off where a place is recognized, for each metre driven since.", "m/m", 0.02, 1.0, 0.01,
    )
    place_length: float = number(
        "Length of a place’s submap", "loops", 10.0,
        "How much of the way becomes the submap by whose corners a place is recognized.", "m", 3.0, 50.0, 1.0,
    )
    place_corners: float = number(
        "Minimum corners", "loops", 5, "Corners of two submaps that must coincide for their scans to be matched.",
        "", 3, 40, 1,
    )
    place_group: float = number(
        "Minimum loops per place", "loops", 5,
        "Loops at a recognized place that must agree with one another to be accepted.", "", 3, 30, 1,
    )
    robust: str = choice(
        "Robust kernel", "graph", "geman_mcclure", "How loops that contradict the rest of the graph lose weight.",
        ("geman_mcclure", "cauchy", "huber", "none"),
    )
    robust_scale: float = number(
        "Kernel scale", "graph", 3.0,
        "Residuals, in standard deviations, that are larger than this lose weight.", "", 0.5, 50.0, 0.5,
    )
    refinement: float = number(
        "Refinement iterations", "refinement", 3,
        "Iterations in which all scans are aligned with their neighbours in space at once; 0 for none.", "", 0, 20, 1,
    )
    refinement_neighbours: float = number(
        "Neighbours in space", "refinement", 8, "Each scan is aligned with this many scans taken nearby.", "", 1, 30, 1,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)

    def with_values(self, values: Mapping[str, Any]) -> SlamConfig:
        """Return the config with these values replaced. Raises :class:`ConfigError` for an invalid name or value."""
        return with_values(self, values, "SLAM parameter")


SLAM_PARAMETERS = table_of(SlamConfig)
