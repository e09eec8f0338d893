"""Table of scan matching parameters, and the components of the methods."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mapper.core.parameter import check_fields, choice, number, table_of, with_values
from mapper.matching.kernels.types import CAUCHY, HUBER, SQUARES


@dataclass(frozen=True, slots=True)
class Method:
    """A method: how initial poses are searched for, and how each is refined.

    ``search`` is a name of :data:`mapper.matching.search.SEARCHES`, ``refinement`` one of
    :data:`mapper.matching.match.REFINEMENTS`.
    """

    name: str
    search: str
    refinement: str
    sentence: str


METHODS: Mapping[str, Method] = {
    method.name: method
    for method in (
        Method(
            "global", "modes", "point_to_line", "The best modes of the correlation, each refined point to line; the "
            "one on which both scans agree best.",
        ),
        Method("global_field", "modes", "likelihood_field", "The best modes, each refined on a smooth field."),
        Method("point_to_line", "guess", "point_to_line", "ICP with the distance to the line (Censi 2008)."),
        Method("point_to_point", "guess", "point_to_point", "ICP with the distance to the point (Besl & McKay 1992)."),
        Method("likelihood_field", "guess", "likelihood_field", "Gauss-Newton on a smooth field (Kohlbrecher 2011)."),
        Method("correlative", "branch_and_bound", "none", "The best cell of the window (Olson 2009; Hess 2016)."),
        Method("exhaustive", "exhaustive", "none", "As correlative, but every pose of the window is scored."),
        Method("features", "features", "point_to_line", "Corners and walls, drawn by RANSAC, then point to line."),
    )
}  # fmt: skip

WEIGHTS: Mapping[str, int] = {"cauchy": CAUCHY, "huber": HUBER, "squares": SQUARES}
CORRESPONDENCES = ("bearing", "nearest")
_SEARCHING = tuple(name for name, method in METHODS.items() if method.search != "guess")
_PAIRING = tuple(name for name, method in METHODS.items() if method.refinement.startswith("point"))
_FIELDS = ("global", "global_field", "likelihood_field", "correlative", "exhaustive")


@dataclass(frozen=True, slots=True)
class MatchConfig:
    """Values of all rows of :data:`PARAMETERS`. Raises :class:`ConfigError` for an invalid one."""

    # fmt: off
    method: str = choice("Method", "method", "global", "How the match is found.", tuple(METHODS))
    window_m: float = number(
        "Search window", "search", 1.5, "How far from the guess, along each axis, poses are searched.",
        "m", 0.0, 50.0, 0.05, only_for=_SEARCHING,
    )
    window_rad: float = number(
        "Angular search window", "search", math.radians(70.0),
        "By how much from the guess, either way, poses are turned.",
        "rad", 0.0, math.pi, 0.01, only_for=_SEARCHING,
    )
    field_resolution: float = number(
        "Field resolution", "search", 0.1, "Side of a cell of the score field.",
        "m", 0.01, 1.0, 0.01, only_for=_FIELDS,
    )
    field_sigma: float = number(
        "Field σ", "search", 0.1, "Standard deviation of the score around a point.",
        "m", 0.01, 2.0, 0.01, only_for=_FIELDS,
    )
    turn_step: float = number(
        "Angular step", "search", math.radians(2.0), "Between two angles that are searched.",
        "rad", 0.001, 0.5, 0.001, only_for=_FIELDS,
    )
    modes: float = number(
        "Maximum modes", "search", 4, "Greatest number of separate poses of the search that are refined.",
        "", 1, 32, 1, only_for=("global", "global_field", "features"),
    )
    mode_share: float = number(
        "Minimum mode score", "search", 0.8, "A pose that scores less than this share of the best one is no mode.",
        "", 0.0, 1.0, 0.05, only_for=("global", "global_field"),
    )
    correspondence: str = choice(
        "Correspondence", "pairs", "bearing",
        "The matching point is searched for around its expected bearing, or it is the nearest one.",
        CORRESPONDENCES, only_for=_PAIRING,
    )
    first_gate: float = number(
        "First pair distance", "pairs", 0.3, "Points farther apart make no pair at the beginning.",
        "m", 0.01, 20.0, 0.01, only_for=_PAIRING,
    )
    last_gate: float = number(
        "Last pair distance", "pairs", 0.12, "The same at the end.", "m", 0.01, 20.0, 0.01, only_for=_PAIRING,
    )
    keep: float = number(
        "Kept pairs", "rejection", 1.0, "Only this share of the pairs, the nearest ones, counts.",
        "", 0.05, 1.0, 0.05, only_for=_PAIRING,
    )
    min_cosine: float = number(
        "Minimum cosine of normals", "rejection", 0.5, "Pairs whose normals differ more do not count; -1: all count.",
        "", -1.0, 1.0, 0.05, only_for=_PAIRING,
    )
    weight: str = choice(
        "Robust kernel", "rejection", "cauchy", "How much less a pair with a large residual counts.",
        tuple(WEIGHTS), only_for=_PAIRING,
    )
    scale: float = number(
        "Kernel scale", "rejection", 0.03, "The residual from which a pair counts less.",
        "m", 0.001, 1.0, 0.001, only_for=_PAIRING,
    )
    iterations: float = number(
        "Maximum iterations", "minimiser", 30, "Maximum number of Gauss-Newton steps.", "", 1, 500, 1,
    )
    score_gate: float = number(
        "Inlier distance", "score", 0.15, "Points nearer than this to what the other scan measured agree with it.",
        "m", 0.01, 2.0, 0.01,
    )
    least_information: float = number(
        "Minimum information", "score", 0.03,
        "A direction with a smaller share of the information is not known: the match is degenerate.",
        "", 0.0, 0.5, 0.005,
    )
    # fmt: on

    def __post_init__(self) -> None:
        check_fields(self)

    def with_values(self, values: Mapping[str, Any]) -> MatchConfig:
        """Return the config with some values replaced. Raise :class:`ConfigError` for unknown names and invalid
        values.
        """
        return with_values(self, values)

    @property
    def parts(self) -> Method:
        """The components of the method."""
        return METHODS[self.method]


PARAMETERS = table_of(MatchConfig)

#: Two maps may differ by any motion; within these limits their walls are aligned.
MAP_CONFIG = MatchConfig(method="global_field", window_m=5.0, window_rad=math.pi)
