"""Consistency of the readings of a log.

Every check of the form "would the map be better if …" uses this measure: for the cells in which beams ended, how often
did a beam end there, of all that reached the cell? If poses, mount and times are right, walls are hit repeatedly and
hardly ever passed; every error smears them over cells that other beams passed.

Evidence for double walls is the fraction of readings that end where readings of another part of the log passed: a beam
that ends in a cell is evidence for an object, and a beam that passes through it is evidence for free space. If the
poses are right, two parts of a log contradict each other only because of moving objects and noise, and that fraction is
the same for parts recorded a moment apart and for parts recorded minutes apart. If the poses drift, it grows with the
time between them. So the second fraction is compared with the first, from the same log.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import KDTree

from mapper.core.errors import WorkCancelledError
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_scans
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.joint_log import with_trajectories
from mapper.sensors.motion import at_middle_of_sweep
from mapper.sensors.scan import ScanLog, Trajectory

RESOLUTION = 0.1  #: metres: fine enough for a wall, coarse enough to be fast and robust to range noise
LARGEST_SIDE = 1500  #: cells: a larger area is examined with coarser ones
PHASES = ((0.0, 0.0), (0.5, 0.5), (0.25, 0.75))  #: in cells: offsets of the grids over which the mean is taken
MOST_READINGS = 60_000  #: maximum number of readings examined; longer logs are thinned evenly
OF_THE_MOUNT = ("mount_x", "mount_y", "mount_yaw", "mount_upside_down")  #: parameters that correct the mount
PARTS = 24  #: parts of the whole log
FAR = 3  #: parts: minimum distance at which two parts are far apart in time
WINDOW = 16  #: scans within which drift is negligible; its two halves are the parts near in time
TOLERANCE = 2  #: cells: a beam that passes nearer to an endpoint does not contradict it
LEAST_PASSES = 2  #: beams through a cell that make it free
RANGE_MAX = 10.0  #: metres: beyond it a heading error of 1° exceeds the tolerance
LEAST_EVIDENCE = 1000.0  #: endpoints in cells of a part far apart in time
WITHIN = 0.9  #: fraction of the endpoints within :meth:`Contradiction.offset` of a wall
_DISK = np.hypot(*np.mgrid[-TOLERANCE : TOLERANCE + 1, -TOLERANCE : TOLERANCE + 1]) <= TOLERANCE + 0.01


@dataclass(frozen=True)  # without slots: cached properties need a __dict__
class Examined:
    """A log thinned for examination, with one of its trajectories; ``scans`` are its scan indices.

    ``may_continue`` is called before each map made of it; False cancels the examination. ``compared`` is called with
    the measurements of the drift check, whether it finds drift or not.
    """

    log: ScanLog
    trajectory: str
    scans: NDArray[np.int64]
    config: MappingConfig
    time_offset: float = 0.0  #: seconds added to the stamps to look up the poses
    may_continue: Callable[[], bool] = lambda: True
    compared: Callable[[Contradiction], None] = lambda _: None

    @cached_property
    def agreement(self) -> float:
        """:func:`consistency` with the log's own values, the reference of every check, computed once."""
        return consistency(self)

    def check_cancelled(self) -> None:
        """Raise :class:`WorkCancelledError` if ``may_continue`` returns False."""
        if not self.may_continue():
            raise WorkCancelledError("doctor.unwanted", "The examination was cancelled: its session has ended.")

    def shifted(self, x: float, y: float) -> Examined:
        """Return the same scans in a map shifted by ``x`` and ``y`` metres."""
        trajectory = self.log.trajectory()
        by = np.array([x, y, 0.0])
        timed = None if trajectory.timed is None else replace(trajectory.timed, poses=trajectory.timed.poses + by)
        moved = replace(trajectory, poses=trajectory.poses + by, timed=timed)
        return replace(self, log=with_trajectories(self.log, {self.trajectory: moved}))

    def part(self, which: NDArray[np.int64]) -> Examined:
        """Return the scans with these indices (n,) of those examined."""
        return replace(self, log=self.log.take(which), scans=self.scans[which])

    def with_poses(self, poses: NDArray[np.float64]) -> Examined:
        """Return the same scans with other poses of the base (n, 3)."""
        return replace(self, log=with_trajectories(self.log, {self.trajectory: Trajectory(poses)}))


def examined(log: ScanLog, trajectory: str | None = None, most: int = MOST_READINGS) -> Examined:
    """Return the part of a log to examine: whole, evenly spaced scans with at most ``most`` readings."""
    name = trajectory or log.default_trajectory
    used = max(1, min(log.n_scans, most // max(1, log.n_beams)))
    scans = np.unique(np.linspace(0, log.n_scans - 1, used).astype(np.int64))
    thinned = with_trajectories(log, {name: Trajectory(log.trajectory(name).poses)}).take(scans)
    span = float(np.ptp(thinned.trajectory().poses[:, :2], axis=0).max()) + 2.0 * min(log.range_max, 30.0)
    resolution = min(1.0, max(RESOLUTION, span / LARGEST_SIDE))
    config = MappingConfig(model="hit_counting", resolution=resolution, range_max=min(30.0, max(0.5, log.range_max)))
    return Examined(thinned, name, scans, config)


def examined_as_mapped(log: ScanLog, trajectory: str | None, config: MappingConfig) -> tuple[ScanLog, Examined]:
    """Return the log at the middle of its sweeps, and its examined part with the mount and range of ``config``.

    Raises :class:`ConfigError` for a trajectory that the log lacks.
    """
    whole = at_middle_of_sweep(log, trajectory, config.time_offset)
    seen = examined(whole, trajectory)
    values: dict[str, object] = {name: getattr(config, name) for name in OF_THE_MOUNT}
    values["range_max"] = min(config.range_max, seen.config.range_max)
    return whole, replace(seen, config=seen.config.with_values(values))


def unthinned(log: ScanLog, seen: Examined) -> Examined:
    """Return all scans of ``log`` with the trajectory and configuration of ``seen``."""
    whole = with_trajectories(log, {seen.trajectory: log.trajectory(seen.trajectory)})
    return replace(seen, log=whole, scans=np.arange(log.n_scans))


def counts(seen: Examined, config: MappingConfig | None = None) -> OccupancyGrid:
    """Return the grid of hits and visits of the examined scans. Raises :class:`WorkCancelledError`."""
    seen.check_cancelled()
    config = config or seen.config
    grid = OccupancyGrid(geometry_for(seen.log, config))
    integrate_scans(grid, seen.log, config, None, 0, seen.log.n_scans)
    return grid


def consistency(seen: Examined, **parameters: object) -> float:
    """Return the fraction of beams that ended in a cell, of all that reached it, averaged over all endpoints.

    ``parameters`` replace values of the table, such as the mount. Slight noise splits a wall on a cell border between
    two cells, so the mean is taken over grids with different offsets.
    """
    config = seen.config.with_values(parameters)
    return float(
        np.mean(
            [_agreement(counts(seen.shifted(config.resolution * x, config.resolution * y), config)) for x, y in PHASES]
        )
    )


def _agreement(grid: OccupancyGrid) -> float:
    if grid.cell_statistics is None:
        return 0.0
    hit = grid.cell_statistics[0] > 0.0  # few of the cells, so the rest of the grid is not read again
    hits, misses = grid.cell_statistics[:, hit].astype(np.float64)
    if not len(hits):
        return 0.0
    # A single endpoint does not show agreement, so each is judged by the others in its cell.
    others = hits - 1.0
    share = np.divide(others, others + misses, out=np.zeros_like(hits), where=others + misses > 0)
    return float((hits * share).sum() / hits.sum())


@dataclass(frozen=True, slots=True)
class _Part:
    """Flat cell indices of one part: with endpoints, their number, near an endpoint, and free."""

    ends: NDArray[np.int64]
    weights: NDArray[np.float64]
    near: NDArray[np.int64]
    free: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Contradiction:
    """Fractions of endpoints, 0 to 1, in free space of another part of the log.

    ``near`` is the fraction between parts a moment apart, ``far`` that between parts far apart in time; ``evidence`` is
    the number of endpoints used for ``far``. ``parts`` are the PARTS parts, on a grid of ``geometry``.
    """

    near: float
    far: float
    evidence: float
    parts: Sequence[_Part]
    geometry: GridGeometry

    @property
    def excess(self) -> float:
        """Fraction contradicted far apart in time, among those not contradicted a moment apart; 0 without evidence."""
        if self.evidence < LEAST_EVIDENCE:
            return 0.0
        return max(0.0, (self.far - self.near) / (1.0 - self.near)) if self.near < 1.0 else 0.0

    def offset(self) -> float | None:
        """Return the distance, metres, from walls of other parts, far in time, within which :data:`WITHIN` of endpoints
        lie.

        The endpoints are those counted in ``far``: confirmed or contradicted by the other part. The distance is
        measured from the centre of the endpoint's cell to that of the nearest cell with an endpoint of the other part.
        With correct poses it is one or two cells. With double walls it is about the distance between the two copies,
        and at most about half the width of a room, because then another wall is nearest. None without evidence.
        """
        if self.evidence < LEAST_EVIDENCE:
            return None
        distances, weights = [], []
        for i, other in enumerate(self.parts):
            if not len(other.ends):
                continue
            walls = KDTree(self._cells(other.ends))
            known = np.concatenate([other.near, other.free])
            for j, part in enumerate(self.parts):
                if _far_apart(i, j):
                    counted = np.isin(part.ends, known)
                    distances.append(walls.query(self._cells(part.ends[counted]))[0])
                    weights.append(part.weights[counted])
        cells, count = np.concatenate(distances), np.concatenate(weights)
        order = np.argsort(cells)
        below = np.cumsum(count[order])
        order_at = order[np.searchsorted(below, WITHIN * below[-1])]
        return float(cells[order_at]) * self.geometry.resolution

    def _cells(self, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        return np.stack(np.divmod(numbers, self.geometry.cols), axis=-1)


def contradiction(whole: Examined, thinned: Examined) -> Contradiction:
    """Return how much parts of one log contradict each other with one of its trajectories.

    ``thinned`` holds scans from the whole log, which are compared far apart in time; ``whole`` holds all scans, of
    which short windows are compared. The mount and the maximum range are those of their configurations. Raises
    :class:`WorkCancelledError`.
    """
    whole, thinned = (
        replace(seen, config=replace(seen.config, range_max=min(seen.config.range_max, RANGE_MAX)))
        for seen in (whole, thinned)
    )
    parts, geometry = _parts(thinned, PARTS)
    far = _compared(parts, geometry, _far_apart)
    starts = np.unique(np.linspace(0, max(0, whole.log.n_scans - WINDOW), PARTS).astype(np.int64))
    near = np.zeros(2)
    for start in starts.tolist():
        window = cut(whole, start, start + WINDOW)
        halves, place = _parts(window, 2)
        near += _compared(halves, place, lambda i, j: i != j).sum(axis=0)
    return Contradiction(_share(near), _share(far.sum(axis=0)), float(far.sum(axis=1).sum()), parts, geometry)


def cut(seen: Examined, start: int, stop: int) -> Examined:
    """Return the scans [``start``, ``stop``) only."""
    part = slice(start, stop)
    return replace(seen, log=seen.log.take(part), scans=seen.scans[part])


def _far_apart(i: int, j: int) -> bool:
    return abs(i - j) >= FAR


def _share(counts: NDArray[np.float64]) -> float:
    return float(counts[0] / counts.sum()) if counts.sum() else 0.0


def _parts(seen: Examined, n_parts: int) -> tuple[list[_Part], GridGeometry]:
    """Return the scans in ``n_parts`` parts of equal length, and their common grid."""
    seen.check_cancelled()
    geometry = geometry_for(seen.log, seen.config)
    edges = np.linspace(0, seen.log.n_scans, n_parts + 1).astype(int)
    parts = []
    for start, stop in pairwise(edges.tolist()):
        grid = OccupancyGrid(geometry)
        integrate_scans(grid, seen.log, seen.config, None, start, stop)
        parts.append(_part(grid, geometry))
    return parts, geometry


def _part(grid: OccupancyGrid, geometry: GridGeometry) -> _Part:
    nothing = np.zeros(0, dtype=np.int64)
    if grid.cell_statistics is None:
        return _Part(nothing, np.zeros(0), nothing, nothing)
    hits, misses = grid.cell_statistics
    touched = (hits > 0) | (misses > 0)
    rows, cols = np.flatnonzero(touched.any(axis=1)), np.flatnonzero(touched.any(axis=0))
    if not len(rows):
        return _Part(nothing, np.zeros(0), nothing, nothing)
    box = (slice(rows[0], rows[-1] + 1), slice(cols[0], cols[-1] + 1))
    ended = hits[box] > 0
    near = ndimage.binary_dilation(ended, structure=_DISK)

    def numbers(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
        row, col = np.nonzero(mask)
        return np.asarray((row + rows[0]) * geometry.cols + col + cols[0], dtype=np.int64)

    free = (misses[box] >= LEAST_PASSES) & ~near
    return _Part(numbers(ended), hits[box][ended].astype(np.float64), numbers(near), numbers(free))


def _compared(
    parts: Sequence[_Part], geometry: GridGeometry, counts: Callable[[int, int], bool]
) -> NDArray[np.float64]:
    """Return for each part (n, 2) how many of its endpoints the others contradict and how many they confirm."""
    totals = np.zeros((len(parts), 2))
    votes = np.zeros(geometry.rows * geometry.cols, dtype=np.int8)  # 1 free, 2 near an endpoint of the other part
    for i, other in enumerate(parts):
        votes[other.free], votes[other.near] = 1, 2
        for j, part in enumerate(parts):
            if counts(i, j):
                here = votes[part.ends]
                totals[j] += (part.weights[here == 1].sum(), part.weights[here == 2].sum())
        votes[other.free] = votes[other.near] = 0
    return totals
