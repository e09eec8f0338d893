"""Place recognition, for the table: local maps, corners, descriptors and RANSAC, by the kernels and by the textbook."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.core.se2 import transform_points
from mapper.slam import places_textbook as textbook
from mapper.slam.kernels.keypoint_pairs import nearest_descriptors, pose_of_pairs
from mapper.slam.kernels.local_map import (
    MOST_PASSES,
    Square,
    draw_scan,
    write_corner_strengths,
    write_polar_shares,
    write_states,
)
from mapper.slam.local_map import BINS, RADIUS, RINGS, SECTORS, SIZES
from mapper.slam.place_recognition import largest_consistent
from tests.agreement.matching import MatchCase, point_scan

#: Walls at whole tenths of a metre do not lie on the borders of cells, where rounding would decide.
SHAPE, LOW, RESOLUTION, REACH, CORNER = (70, 80), (-4.0317, -3.5291), 0.1, 5.0, 4
KEYPOINTS = np.array([[0, 0], [20, 35], [69, 79], [35, 40]])


def _drawn(case: MatchCase) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    hits, passes, tensors = np.zeros(SHAPE, np.int32), np.zeros(SHAPE, np.int32), np.zeros((*SHAPE, 3))
    for k, pose in enumerate(case.poses):
        draw_scan(hits, passes, tensors, Square(*LOW, RESOLUTION), case.scans, k, pose, REACH, 1)
    return hits, passes, tensors


def local_map_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    hits, passes, tensors = _drawn(case)
    return hits.astype(np.int64), passes.astype(np.int64), tensors


def local_map_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    scans = [point_scan(case.scans, k) for k in range(2)]
    return textbook.local_map(scans, case.poses, np.array(LOW), SHAPE, RESOLUTION, REACH)


def described_by_kernel(case: MatchCase) -> tuple[Any, ...]:
    hits, passes, tensors = _drawn(case)
    states, strengths = np.empty(SHAPE, np.uint8), np.empty(SHAPE)
    write_states(hits, passes, states)
    write_corner_strengths(states, hits, tensors, CORNER, strengths)
    shares = np.empty((len(KEYPOINTS), 2, len(SIZES)), dtype=np.float32)
    write_polar_shares(states, KEYPOINTS, BINS, SIZES, shares)
    return states, strengths, shares


def described_by_textbook(case: MatchCase) -> tuple[Any, ...]:
    hits, passes, tensors = _drawn(case)
    states = textbook.cell_states(hits, passes, MOST_PASSES)
    strengths = textbook.corner_strengths(states, hits, tensors, CORNER)
    return states, strengths, textbook.polar_shares(states, KEYPOINTS, RINGS, SECTORS, RADIUS)


@dataclass(frozen=True)
class PairCase:
    """Points with descriptors, the same ones moved, and others; which of some measurements are consistent."""

    ours: np.ndarray
    theirs: np.ndarray
    owner: np.ndarray
    guess: np.ndarray
    descriptors: tuple[np.ndarray, np.ndarray]
    consistent: np.ndarray


@st.composite
def pair_cases(draw: st.DrawFn) -> PairCase:
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    n, outliers = draw(st.integers(0, 6)), draw(st.integers(0, 6))
    owner = np.sort(rng.integers(0, 6, n + outliers))
    points = rng.uniform(-4, 4, (6, 2))
    pose = np.array([*rng.uniform(-3, 3, 2), rng.uniform(-4, 4)])
    theirs = transform_points(pose, points[owner]) + rng.normal(0.0, 0.05, (len(owner), 2))
    is_outlier = rng.permutation(len(owner)) < outliers
    theirs[is_outlier] = rng.uniform(-6, 6, (len(owner), 2))[is_outlier]
    guess = pose + rng.normal(0.0, 0.3, 3)
    m = draw(st.integers(0, 8))
    upper = np.triu(rng.random((m, m)) < draw(st.sampled_from([0.2, 0.5, 0.8])), 1)
    descriptors = (rng.random((5, 7)).astype(np.float32), rng.random((draw(st.integers(0, 9)), 7)).astype(np.float32))
    return PairCase(points[owner], theirs, owner, guess, descriptors, upper | upper.T)


WINDOWS, TOLERANCE, LEAST_DISTANCE = (1.0, 0.6), 0.3, 1.0


def pairs_by_kernel(case: PairCase) -> tuple[Any, ...]:
    pose = np.zeros(3)
    count = pose_of_pairs(case.ours, case.theirs, case.owner, case.guess, *WINDOWS, TOLERANCE, LEAST_DISTANCE, pose)
    squares = np.sum((transform_points(pose, case.ours) - case.theirs) ** 2, axis=1)
    least = [squares[case.owner == one].min() for one in np.unique(case.owner)]
    total = sum((one for one in least if one <= TOLERANCE**2), 0.0) if count else 0.0
    near = np.empty((len(case.descriptors[0]), 3), dtype=np.int64)
    nearest_descriptors(*case.descriptors, near)
    return count, np.array(total), near


def pairs_by_textbook(case: PairCase) -> tuple[Any, ...]:
    count, total = textbook.pose_of_pairs(
        case.ours, case.theirs, case.owner, case.guess, WINDOWS, TOLERANCE, LEAST_DISTANCE
    )
    return count, np.array(float(total)), textbook.nearest_descriptors(*case.descriptors, 3)


def group_by_search(case: PairCase) -> tuple[Any, ...]:
    group = largest_consistent(case.consistent)
    each_two = case.consistent[np.ix_(group, group)] | np.eye(len(group), dtype=np.bool_)
    return len(group), bool(each_two.all())


def group_by_textbook(case: PairCase) -> tuple[Any, ...]:
    return textbook.largest_consistent(case.consistent), True
