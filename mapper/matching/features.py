"""Feature matching: walls, and corners where two walls meet, associated by RANSAC.

A corner is an ordered pair of non-parallel walls: the intersection of their lines, and the direction of the first. Its
descriptor is the angle from the first to the second, so one pair of corners determines a pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse, transform_points, wrap_angle
from mapper.matching.kernels.segments import split_scan
from mapper.matching.kernels.types import NO_POINT, ScanArrays
from mapper.matching.target import Target
from mapper.matching.task import Task

GAP, THICKNESS, FEWEST = 0.3, 0.06, 5  #: m, m, points: parameters of wall extraction
SHORTEST = 0.3  #: m: shorter walls are ignored
LEAST_ANGLE = np.deg2rad(25.0)  #: minimum angle between the walls of a corner
FARTHEST = 30.0  #: m from the sensor: farther corners, of nearly parallel lines, are uncertain
SAME_ANGLE = np.deg2rad(8.0)  #: tolerance for the angles of matching corners and the directions of matching walls
SAME_M = 0.2  #: distance tolerance for matching walls
DRAWS = 400  #: maximum number of sampled pairs of corners
SEED = 14  #: of the sampling
APART_M, APART_RAD = 0.4, 0.25  #: hypotheses closer than both are merged


@dataclass(frozen=True, slots=True)
class Walls:
    """Line segments: ``ends`` (n, 2, 2), first and last point, counter-clockwise as seen from the sensor."""

    ends: Float64Array

    @property
    def directions(self) -> Float64Array:
        """Angles (n,) from the first end to the last, radians."""
        d = self.ends[:, 1] - self.ends[:, 0]
        return np.asarray(np.arctan2(d[:, 1], d[:, 0]))

    @property
    def lengths(self) -> Float64Array:
        """Lengths (n,), metres."""
        return np.asarray(np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T))


def walls_of(scans: ScanArrays, i: int) -> Walls:
    """Return the walls of scan i in its base frame: the runs of split and merge, each fitted along its principal
    axis.
    """
    runs = np.empty((scans.points.shape[1], 2), dtype=np.int64)
    count = split_scan(scans, i, GAP, THICKNESS, FEWEST, runs)
    ends = [_fitted(scans, i, run) for run in runs[:count]]
    walls = Walls(np.array(ends, dtype=np.float64).reshape(-1, 2, 2))
    return Walls(walls.ends[walls.lengths >= SHORTEST])


def _fitted(scans: ScanArrays, i: int, run: Int64Array) -> Float64Array:
    """Return the first and last point (2, 2) of a run projected onto its total least-squares line."""
    beams = slice(run[0], run[1] + 1)
    points = scans.points[i, beams][scans.kind[i, beams] != NO_POINT].astype(np.float64)
    mean = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - mean, full_matrices=False)
    along = (points[[0, -1]] - mean) @ axes[0]
    return np.asarray(mean + along[:, np.newaxis] * axes[0])


def corners_of(walls: Walls) -> tuple[Float64Array, Float64Array]:
    """Return the poses (n, 3) of the corners, point and direction of the first wall, and their angles (n,), radians."""
    directions, starts = walls.directions, walls.ends[:, 0]
    n = len(directions)
    first, second = (part.ravel() for part in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    angles = wrap_angle(directions[second] - directions[first])
    clear = np.abs(np.sin(angles)) > np.sin(LEAST_ANGLE)
    first, second, angles = first[clear], second[clear], angles[clear]
    c, s = np.cos(directions[first]), np.sin(directions[first])
    off = starts[second] - starts[first]
    d = directions[second]
    t = (off[:, 0] * np.sin(d) - off[:, 1] * np.cos(d)) / np.sin(angles)
    at = starts[first] + t[:, np.newaxis] * np.stack([c, s], axis=-1)
    near = np.hypot(*at.T) < FARTHEST
    return np.column_stack([at, directions[first]])[near], angles[near]


def support(walls: Walls, others: Walls, poses: Float64Array) -> Float64Array:
    """Return the length (k,), metres, of ``walls`` that lies on one of ``others`` at each of ``poses`` (k, 3)."""
    lengths, total = walls.lengths, np.zeros(len(poses))
    directions = others.directions
    along = np.stack([np.cos(directions), np.sin(directions)], axis=-1)
    for k, pose in enumerate(poses):
        ends = transform_points(pose, walls.ends)
        off = ends[:, np.newaxis] - others.ends[:, 0][np.newaxis, :, np.newaxis]
        at = np.einsum("mnec,nc->mne", off, along)
        across = np.abs(off[..., 0] * along[:, np.newaxis, 1] - off[..., 1] * along[:, np.newaxis, 0]).max(axis=2)
        turned = np.abs(wrap_angle(walls.directions[:, np.newaxis] + pose[2] - directions))
        shared = np.minimum(at.max(axis=2), others.lengths) - np.maximum(at.min(axis=2), 0.0)
        shared = np.where((across < SAME_M) & (turned < SAME_ANGLE), np.maximum(shared, 0.0), 0.0)
        total[k] = np.minimum(shared.sum(axis=1), lengths).sum()
    return total


def walls_of_target(target: Target) -> Walls:
    """Return the walls of all scans of a target in its frame. Raises :class:`ConfigError` for a map."""
    if target.is_map:
        raise ConfigError("matching.method", "The method 'features' matches a scan with scans, not with a map.")
    placed = [transform_points(target.poses[j], walls_of(target.scans, int(j)).ends) for j in target.indices]
    return Walls(np.concatenate(placed))


def poses_by_features(task: Task) -> Float64Array:
    """Return the poses (k, 3) in the window on which most of the walls agree, best first; possibly none.

    Source: Fischler & Bolles 1981 (RANSAC): at most :data:`DRAWS` pairs of corners of equal angle are drawn. Each
    determines a pose, scored by the length of the walls that then lie on walls of the target.
    """
    walls, others = walls_of(task.source, task.index), walls_of_target(task.target)
    ours, our_angles = corners_of(walls)
    theirs, their_angles = corners_of(others)
    alike = np.abs(wrap_angle(our_angles[:, np.newaxis] - their_angles)) < SAME_ANGLE
    a, b = np.nonzero(alike)
    poses = compose(theirs[b], inverse(ours[a]))
    off = poses - task.guess
    config = task.config
    inside = (np.abs(off[:, :2]) <= config.window_m).all(axis=1) & (np.abs(wrap_angle(off[:, 2])) <= config.window_rad)
    poses = poses[inside]
    if len(poses) > DRAWS:
        poses = poses[np.sort(np.random.default_rng(SEED).choice(len(poses), DRAWS, replace=False))]
    supports = support(walls, others, poses)
    chosen: list[Float64Array] = []
    for k in np.argsort(-supports, kind="stable"):
        if len(chosen) == int(config.modes) or supports[k] <= 0.0:
            break
        apart = [
            np.hypot(*(poses[k] - pose)[:2]) > APART_M or abs(float(wrap_angle(poses[k, 2] - pose[2]))) > APART_RAD
            for pose in chosen
        ]
        if all(apart):
            chosen.append(poses[k])
    return np.array(chosen).reshape(-1, 3)
