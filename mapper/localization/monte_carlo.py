"""Monte Carlo localization: a particle filter on odometry and scans.

Source: Probabilistic Robotics, tables 8.2 to 8.4, with the parameters of AMCL. Beyond these: many particles until the
filter has converged, likelihoods that are scaled down if a scan would leave too few effective particles, sensor
resetting (Lenser and Veloso 2000), which draws particles from the likelihood of a scan, and an alternative: a second
filter elsewhere in the map that is tested against the first (:mod:`mapper.localization.recovery`).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import between_one, compose_one
from mapper.grid import OccupancyGrid
from mapper.localization.confidence import Confidence, is_jump, unexplained_shares
from mapper.localization.estimate import Estimate, estimate_of, find_clusters
from mapper.localization.map_model import MapModel, check_pose, map_model
from mapper.localization.motion import anywhere, around, key_of, motion_between, move
from mapper.localization.parameters import LocalizationConfig
from mapper.localization.recovery import SHARE as ALTERNATIVE_SHARE
from mapper.localization.recovery import Alternative, Recovery, alternative_config, alternative_particles, near
from mapper.localization.resample import drawn, resampled
from mapper.localization.scan_beams import ScanBeams, limits_of, scan_beams
from mapper.localization.weighing import (
    effective_number,
    log_likelihoods,
    logarithm_of_mean,
    normalised,
    scan_sums,
    tempering,
)
from mapper.sensors.scan import RangeScan

INITIAL_COVARIANCE = np.diag([0.25, 0.25, (math.pi / 12.0) ** 2])  #: of an initial pose, AMCL's initial_cov
_MOVE, _START, _DRAW, _RESET, _REPLACE, _SPREAD, _ALTERNATIVE = range(7)  #: purposes of random numbers
_STAGE = 16  #: offset between the purposes of two stages of one scan


def bandwidth(n: int, dimensions: int = 3) -> float:
    """Return the bandwidth of a Gaussian kernel density estimate of n samples, in units of their standard deviation.

    It is optimal for a normal density. Source: Silverman 1986, Density Estimation, section 4.3.2.
    """
    d = dimensions
    return float((4.0 / (n * (d + 2.0))) ** (1.0 / (d + 4.0)))


class MonteCarloLocalizer:
    """A particle filter on one map.

    ``particles`` (n, 3) are ``T_map_base`` and ``weights`` (n,) sum to 1; :meth:`set_particles` replaces them.
    ``weighed`` are the particles used for the estimate: after the newest scan, before resampling. The same seed and
    calls produce the same particles, regardless of the number of threads.
    """

    def __init__(
        self,
        grid: OccupancyGrid | MapModel,
        config: LocalizationConfig | None = None,
        *,
        range_min: float = 0.0,
        range_max: float = 100.0,
        mount: tuple[float, float, float] = (0.0, 0.0, 0.0),
        initial_pose: ArrayLike | None = None,
        particles: ArrayLike | None = None,
        seed: int = 0,
    ) -> None:
        """Create a filter for scans of a sensor at ``mount``, ``T_base_laser``, with a maximum range of ``range_max``
        m.

        It starts around an ``initial_pose`` (3,), or with ``particles`` (n, 3), or otherwise everywhere. ``grid`` may
        be the :class:`MapModel` of another filter with the same sensor parameters. Raises :class:`ConfigError` for a
        map without free or occupied cells, and a pose outside the map.
        """
        self.config = config or LocalizationConfig()
        _, longest = limits_of(self.config, range_min, range_max)
        self.model = grid if isinstance(grid, MapModel) else map_model(grid, self.config, longest)
        self.mount, self.seed = mount, seed
        self.n_updates = 0  #: number of scans used
        self.log_evidence = 0.0  #: log p(z | the scans before) of the newest scan, up to a constant common to all poses
        self._longest = longest
        self._odometry: tuple[float, float, float] | None = None  # at the last scan used
        self._due: dict[int, bool] = {}  # for each sensor, whether its next scan is used
        self._steps = 0
        self._kept = 1.0  # fraction of effective particles left by all stages of the newest scan except the last
        if initial_pose is not None:
            self.start_at(initial_pose)
        elif particles is not None:
            self.set_particles(particles)
        else:
            self.start_anywhere()

    def start_anywhere(self) -> None:
        """Spread the particles uniformly over the free cells and all headings."""
        self._begin(anywhere(self.model, int(self.config.global_particles), self._key(_START)))

    def start_at(self, pose: ArrayLike) -> None:
        """Sample the particles around a pose (3,) with :data:`INITIAL_COVARIANCE`.

        Raises :class:`ConfigError` for a pose outside the map.
        """
        place = check_pose(self.model.geometry, pose)
        self._begin(around(place, INITIAL_COVARIANCE, int(self.config.max_particles), self._key(_START)))

    def set_particles(self, particles: ArrayLike, weights: ArrayLike | None = None) -> None:
        """Replace the particles (n, 3) and their weights (n,), which need not sum to 1.

        Raises :class:`ConfigError` for poses or weights that are not finite, and weights that are negative or all 0.
        """
        poses = np.array(particles, dtype=np.float64)
        if poses.ndim != 2 or poses.shape[1] != 3 or not len(poses) or not np.isfinite(poses).all():
            raise ConfigError("localization.particles", "Particles must be one or more rows of three finite numbers.")
        w = np.ones(len(poses)) if weights is None else np.array(weights, dtype=np.float64)
        if w.shape != (len(poses),) or not np.isfinite(w).all() or (w < 0.0).any() or not w.sum() > 0.0:
            raise ConfigError(
                "localization.weights",
                f"Weights of particles must be {len(poses)} finite numbers, none negative and not all of them 0.",
            )
        self._begin(poses, w / w.sum())

    def _begin(self, particles: Float64Array, weights: Float64Array | None = None) -> None:
        self.particles = particles
        self.weights = np.full(len(particles), 1.0 / len(particles)) if weights is None else weights
        self.weighed = self.particles.copy(), self.weights
        self._odometry, self._due = None, {}
        clusters = find_clusters(self.particles, self.weights)
        self.estimate = estimate_of(clusters, 0.0, was_converged=False, is_updated=False)
        self._recovery = Recovery(self.config, is_searched=not self.estimate.is_converged)
        self._alternative: Alternative | None = None
        self._confidence = Confidence()
        self._base = tuple(self.estimate.pose.tolist())

    def update(self, odometry: ArrayLike, scan: RangeScan) -> Estimate:
        """Process the odometry's pose (3,), ``T_odom_base``, at a scan, and the scan; return the estimate.

        The scan is used once the robot has moved by ``update_min_d`` or turned by ``update_min_a``; until then the
        odometry propagates the estimate. Raises :class:`ConfigError` for odometry that is not finite.
        """
        return self.update_beams(odometry, scan_beams(scan, self.mount, self.config))

    def update_beams(self, odometry: ArrayLike, scan: ScanBeams, sensor: int = 0) -> Estimate:
        """Like :meth:`update`, for a scan with selected beams (:func:`scan_beams`) from one of several sensors.

        Once the robot has moved far enough, the next scan of each ``sensor`` is used. Source: AMCL, laserReceived.
        """
        now = np.asarray(odometry, dtype=np.float64)
        if now.shape != (3,) or not np.isfinite(now).all():
            raise ConfigError(
                "localization.odometry", f"Odometry must be three finite numbers, not {now.tolist()!r:.80}."
            )
        here: tuple[float, float, float] = tuple(now.tolist())
        if self._odometry is not None:
            moved = between_one(self._odometry, here)
            if math.hypot(moved[0], moved[1]) >= self.config.update_min_d or abs(moved[2]) >= self.config.update_min_a:
                self._due = dict.fromkeys(self._due, True)
            if not self._due.get(sensor, True):
                return self._moved_by_odometry(moved, scan)
            self.predict(np.array(self._odometry), now)
        self._due[sensor] = False
        self._odometry = here
        self.correct(scan)
        return self.estimate

    def _moved_by_odometry(self, moved: tuple[float, float, float], scan: ScanBeams) -> Estimate:
        pose = np.array(compose_one(self._base, moved))
        self.estimate = replace(self.estimate, pose=pose, is_updated=False)
        if self.config.reset_below > 0.0:  # a scan without weight also indicates that the robot was moved
            self._confidence.glance(*unexplained_shares(self.model, scan, pose))
            self._tell_confidence()
        return self.estimate

    def predict(self, before: Float64Array, after: Float64Array) -> None:
        """Move the particles by the odometry's motion from ``before`` to ``after``, both (3,), with noise."""
        self._steps += 1
        self._base = compose_one(self._base, between_one(before.tolist(), after.tolist()))
        move(self.particles, motion_between(before, after, self.config), self._key(_MOVE))
        if self._alternative is not None:
            self._alternative.robot.predict(before, after)

    def correct(self, scan: ScanBeams) -> None:
        """Weight the particles by a scan, set the estimate, and resample the particles if due."""
        self._steps += 1
        self.n_updates += 1
        fit, random_share = 0.0, 0.0
        if len(scan.beams):
            sums, logs = self._weigh(scan)
            fit = float(self.weights @ self.model.field.fit(sums, len(scan.points)))
            random_share = self._recovery.random_share(logs, len(scan.beams))
        was_converged = self.estimate.is_converged
        clusters = find_clusters(self.particles, self.weights)
        self.estimate = estimate_of(clusters, fit, was_converged=was_converged, is_updated=True)
        expected, self._base = np.array(self._base), tuple(self.estimate.pose.tolist())
        self.weighed = self.particles, self.weights
        if self._is_time():
            self._resample()
        else:
            self.particles = self.particles.copy()  # they are modified in place
        if random_share > 0.0:
            self._scatter(random_share)
        if len(scan.points):
            self._test_alternative(scan)
            if self._recovery.wants_comparison():
                self._compare(scan, fit)
        if self.config.reset_below > 0.0:
            self._judge(scan, expected)

    def _judge(self, scan: ScanBeams, expected: Float64Array) -> None:
        """Determine whether the filter is sure of its place; the odometry predicted ``expected`` (3,)."""
        confidence, estimate = self._confidence, self.estimate
        confidence.look(*unexplained_shares(self.model, scan, estimate.pose))
        other = self._alternative
        if other is None:
            confidence.wait()
        else:
            confidence.wait(other.n_scans, other.log_ratio)
        is_elsewhere = bool(is_jump(expected[np.newaxis], estimate.pose[np.newaxis])[0])
        if is_elsewhere or not estimate.is_converged or self._recovery.is_searched:
            confidence.doubt()
        self._tell_confidence()

    def _tell_confidence(self) -> None:
        estimate, confidence = self.estimate, self._confidence
        is_sure = estimate.is_converged and confidence.is_confirmed
        self.estimate = replace(estimate, is_sure=is_sure, contradicted=confidence.contradicted)

    def reconfigure(self, config: LocalizationConfig, model: MapModel) -> None:
        """Continue with other parameters, and with the map for the sensor's parameters. The particles are kept."""
        self.config, self.model = config, model
        self._recovery = Recovery(config, is_searched=self._recovery.is_searched)
        self._alternative = None
        self._confidence = Confidence()

    def weights_by(self, scan: ScanBeams) -> Float64Array:
        """Return the weights (n,), Σ = 1, that a scan alone assigns to the particles of ``weighed``; nothing
        changes.
        """
        poses = self.weighed[0]
        logs = log_likelihoods(self.model, scan, poses, scan_sums(self.model, scan, poses), self.config)
        flat = np.full(len(poses), 1.0 / len(poses))
        least = self.config.least_effective
        return normalised((tempering(flat, logs, least) if least > 0.0 else 1.0) * logs)

    def _weigh(self, scan: ScanBeams) -> tuple[NDArray[np.int64], Float64Array]:
        """Weight the particles by a scan, in stages if its likelihood is scaled down.

        Return the sums of the scores at the particles, and the log-likelihoods at the previous ones. Each stage applies
        as much of the likelihood as :func:`tempering` allows. Between stages, particles are resampled and perturbed
        with the covariance of their heaviest cluster times the bandwidth of a kernel density estimate. Sources: Del
        Moral, Doucet and Jasra 2012 (stages), Musso, Oudjane and Le Gland 2001 (the regularised particle filter).
        """
        config, left, self._kept = self.config, 1.0, 1.0
        stages = int(config.annealing_stages) if len(self.particles) <= config.max_particles else 1
        first: Float64Array | None = None
        before = self.weights
        for stage in range(stages):
            sums = scan_sums(self.model, scan, self.particles)
            logs = log_likelihoods(self.model, scan, self.particles, sums, config)
            first = logs if first is None else first
            power = left
            if config.least_effective > 0.0:
                power = min(left, tempering(self.weights, logs, config.least_effective))
            with np.errstate(divide="ignore"):
                self.weights = normalised(np.log(self.weights) + power * logs)
            left -= power
            if left <= 0.0 or stage == stages - 1:
                break
            self._kept *= effective_number(self.weights) / len(self.weights)
            self._spread(stage)
        assert first is not None  # noqa: S101 - for the type checker: there is a stage
        self.log_evidence = logarithm_of_mean(before, first)
        return sums, first

    def _spread(self, stage: int) -> None:
        """Resample the same number of particles, and perturb each."""
        n = len(self.particles)
        clusters = find_clusters(self.particles, self.weights)
        covariance = bandwidth(n) ** 2 * clusters.covariance[int(np.argmax(clusters.weight))]
        chosen = drawn(self.weights, n, self._uniform(_DRAW + _STAGE * (stage + 1)))
        offsets = around(np.zeros(3), covariance, n, self._key(_SPREAD + _STAGE * (stage + 1)))
        self.particles = self.particles[chosen] + offsets
        self.weights = np.full(n, 1.0 / n)

    def _is_time(self) -> bool:
        if self.n_updates % int(self.config.resample_interval):
            return False
        return not self.config.selective_resampling or effective_number(self.weights) < 0.5 * len(self.weights)

    def _resample(self) -> None:
        most = int(self.config.max_particles)
        if not self.estimate.is_converged:
            most = max(most, int(self.config.global_particles))
        u = self._uniform(_DRAW)
        self.particles = resampled(self.particles, self.weights, most, u, self.config, self._kept)
        self.weights = np.full(len(self.particles), 1.0 / len(self.particles))

    def _scatter(self, share: float) -> None:
        """Replace a fraction of the particles by ones drawn from all free space: augmented MCL."""
        count = round(share * len(self.particles))
        if count:
            places = np.linspace(0, len(self.particles) - 1, count).astype(np.int64)
            self.particles[places] = anywhere(self.model, count, self._key(_REPLACE))

    def _compare(self, scan: ScanBeams, fit: float) -> None:
        """Compare the fit of a scan with its fit all over the map, and add particles drawn from its likelihood.

        If it fits much worse, the filter has probably lost the robot, and the added particles get half of the weight.
        Before convergence they get a little, as in mixture MCL (Thrun, Fox, Burgard and Dellaert 2001).
        """
        count = int(self.config.global_particles)
        places = anywhere(self.model, count, self._key(_RESET))
        sums = scan_sums(self.model, scan, places)
        best = float(self.model.field.fit(sums.max(keepdims=True), len(scan.points))[0])
        now = self.estimate
        share = self._recovery.added_weight(fit, best, is_converged=now.is_converged, share=now.share)
        if share > 0.0:
            self._alternative = None
            added = self._likely(scan, places, sums, max(1, round(2.0 * share * count)))
            self._add(added, np.full(len(added), share / len(added)))
        elif self._alternative is None and now.is_converged:
            self._begin_alternative(scan, places, sums)

    def _begin_alternative(self, scan: ScanBeams, places: Float64Array, sums: NDArray[np.int64]) -> None:
        """Start an alternative on the most likely of ``places`` (n, 3) that are apart from the filter."""
        apart = ~near(places, self.estimate.pose)
        if not apart.any():
            return
        poses = self._likely(scan, places[apart], sums[apart], alternative_particles(self.config))
        robot = MonteCarloLocalizer(
            self.model,
            alternative_config(self.config),
            range_max=self._longest,
            seed=self._key(_ALTERNATIVE),
            particles=poses,
        )
        self._alternative = Alternative(robot)

    def _likely(self, scan: ScanBeams, places: Float64Array, sums: NDArray[np.int64], count: int) -> Float64Array:
        """Return ``count`` poses drawn from ``places`` (n, 3) by a scan's tempered likelihood; ``sums`` (n,)."""
        logs = log_likelihoods(self.model, scan, places, sums, self.config)
        flat = np.full(len(places), 1.0 / len(places))
        weights = normalised(tempering(flat, logs, max(self.config.least_effective, 0.01)) * logs)
        return places[drawn(weights, count, self._uniform(_REPLACE))]

    def _add(self, particles: Float64Array, weights: Float64Array) -> None:
        """Add particles (n, 3) with weights (n,); the existing ones share the rest."""
        self.particles = np.concatenate([self.particles, particles])
        self.weights = np.concatenate([(1.0 - float(weights.sum())) * self.weights, weights])

    def _test_alternative(self, scan: ScanBeams) -> None:
        """Weight the alternative by a scan, and add its particles to the filter's if the test decides for it."""
        alternative = self._alternative
        if alternative is None:
            return
        alternative.correct(scan, self.log_evidence)
        if alternative.has_won:
            self._add(alternative.robot.particles, ALTERNATIVE_SHARE * alternative.robot.weights)
            self._confidence.doubt()
        elif alternative.has_lost(self.estimate):
            self._confidence.rule_out(alternative.n_scans)
        else:
            return
        self._alternative = None

    def _key(self, purpose: int) -> int:
        return key_of(self.seed, self._steps, purpose)

    def _uniform(self, purpose: int) -> float:
        return self._key(purpose) / float(1 << 62)
