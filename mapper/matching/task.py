"""Definition of one match: a scan, its target, a first guess and the method."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from mapper.core.array_types import Float64Array, UInt8Array
from mapper.core.errors import ConfigError, LimitError
from mapper.core.se2 import check_poses
from mapper.grid import GridGeometry
from mapper.matching.fields import gaussian_stamps
from mapper.matching.kernels.correlative import Window
from mapper.matching.kernels.score_field import add_scan
from mapper.matching.kernels.types import LINE, POINTS, Iterations, PairRule, ScanArrays
from mapper.matching.parameters import WEIGHTS, MatchConfig
from mapper.matching.target import Target, check_points

MOST_BLOCKS = 1 << 24  #: of a search window: 64 MB of bounds
TOP_LEVEL = 3  #: blocks of 8 × 8 cells are bounded first
MOST_BEAMS = 20  #: around the bearing of a point for correspondences by bearing
STOP_M, STOP_RAD = 2e-4, 5e-5  #: iteration stops when the pose changes by less
SHRINK = 0.6  #: factor of the gate between iterations


@dataclass(frozen=True, slots=True)
class Task:
    """Match scan ``index`` of ``source`` to ``target``, starting from ``guess`` (3,), ``T_target_base``.

    Raises :class:`ConfigError` for a scan that does not exist or has fewer than three points, a guess that is not
    finite, and a method that the target does not allow; :class:`LimitError` for a window of too many poses.
    """

    source: ScanArrays
    index: int
    target: Target
    guess: Float64Array
    config: MatchConfig
    _fields: dict[tuple[float, float], tuple[GridGeometry, UInt8Array]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "guess", np.ascontiguousarray(self.guess, dtype=np.float64))
        if self.guess.shape != (3,) or not np.isfinite(self.guess).all():
            raise ConfigError(
                "matching.guess", f"The guess must be three finite numbers, not {self.guess.tolist()!r:.80}."
            )
        check_poses(self.guess[np.newaxis], (1, 3))
        if not 0 <= self.index < len(self.source.kind):
            raise ConfigError(
                "matching.scan", f"There is no scan {self.index}; the last is {len(self.source.kind) - 1}."
            )
        check_points(self.source, np.array([self.index]), "the scan")
        parts = self.config.parts
        if self.target.is_map and parts.refinement.startswith("point"):
            raise ConfigError(
                "matching.method",
                f"The method {self.config.method!r} matches a scan with scans, not with a map: "
                "choose global_field, likelihood_field or correlative.",
            )
        window = self.window
        blocks = (2 * window.turns + 1) * (2 * window.cells / (1 << TOP_LEVEL) + 1) ** 2
        if parts.search == "exhaustive":
            blocks = (2 * window.turns + 1) * (2 * window.cells + 1) ** 2
        if parts.search in {"modes", "branch_and_bound", "exhaustive"} and blocks > MOST_BLOCKS:
            raise LimitError(
                "matching.window",
                f"A window of ±{self.config.window_m:g} m and ±{self.config.window_rad:g} rad has too many poses with "
                f"cells of {self.config.field_resolution:g} m: choose a smaller window or larger cells.",
            )

    @property
    def window(self) -> Window:
        """The window in cells of the field and steps of the angle, rounded up."""
        config = self.config
        return Window(
            math.ceil(config.window_m / config.field_resolution - 1e-9),
            math.ceil(config.window_rad / config.turn_step - 1e-9),
            config.turn_step,
        )

    @property
    def rule(self) -> PairRule:
        """Rule for pairing and weighting points."""
        config = self.config
        every = max(self.source.points.shape[1], self.target.scans.points.shape[1])
        return PairRule(
            config.min_cosine,
            MOST_BEAMS if config.correspondence == "bearing" else every,
            WEIGHTS[config.weight],
            config.scale,
            1,
            config.keep,
            POINTS if config.parts.refinement == "point_to_point" else LINE,
        )

    @property
    def iterations(self) -> Iterations:
        """The Gauss–Newton iterations."""
        config = self.config
        first, last = config.first_gate, min(config.first_gate, config.last_gate)
        return Iterations(int(config.iterations), first, last, SHRINK, STOP_M, STOP_RAD)

    def score_field(self, resolution: float, sigma: float) -> tuple[GridGeometry, UInt8Array]:
        """Return the score field of the target: its lattice and the scores (rows, cols) uint8."""
        key = (resolution, sigma)
        if key not in self._fields:
            self._fields[key] = self._make_field(resolution, sigma)
        return self._fields[key]

    def _make_field(self, resolution: float, sigma: float) -> tuple[GridGeometry, UInt8Array]:
        points = self.target.points
        stamps = gaussian_stamps(resolution, sigma)
        margin = (stamps.shape[2] // 2 + 1) * resolution
        low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
        cols, rows = (math.ceil(length / resolution) + 1 for length in high - low)
        geometry = GridGeometry(resolution, rows, cols, (float(low[0]), float(low[1]), 0.0))
        scores = np.zeros(geometry.shape, dtype=np.uint8)
        for j in self.target.indices:
            add_scan(scores, geometry.frame, stamps, self.target.scans, int(j), self.target.poses[j], 1)
        return geometry, scores

    @property
    def stride(self) -> int:
        """Beam stride of the search for modes, for which 60 to 120 points of a scan are enough."""
        most = 400 if self.target.is_map else 60
        return max(1, int(np.count_nonzero(self.source.kind[self.index])) // most)
