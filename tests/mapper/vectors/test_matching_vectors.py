"""Vectors that compare the lecture's scan matching with the textbook: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_matching_vectors.py --write`` rewrites them after a change of the methods.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mapper.core.se2 import transform_points
from mapper.grid import GridGeometry
from mapper.matching import textbook
from mapper.matching.textbook import PointScan

VECTORS = Path(__file__).parents[3] / "static" / "src" / "lessons" / "matching" / "matching.vectors.json"
BEAMS = 60
NORMALS: dict[str, Any] = {"halfWidth": 2, "reach": 0.2, "most": 6, "leastGap": 0.25, "maxThickness": 0.02}
GATE, KEEP, STEPS = 1.0, 0.9, 8
FIELD: dict[str, Any] = {"resolution": 0.1, "rows": 45, "cols": 55, "origin": (-0.5, -0.5, 0.0)}
SIGMA, FINE, REACH = 0.1, 4, 3
TURNS = [math.radians(turn) for turn in (-10.0, -5.0, 0.0, 5.0, 10.0)]
CELLS = 4
FIXED_AT, MOVING_AT, GUESS = (1.6, 1.3, 0.2), (2.1, 1.5, 0.45), (2.3, 1.35, 0.3)
ROOM = (0.1, 0.1, 4.4, 3.3)


def ranges_in_room(pose: tuple[float, float, float]) -> np.ndarray:
    """Return the distances (n,) from a pose to the walls of :data:`ROOM` and to a round post, with small errors."""
    angles = pose[2] + np.arange(BEAMS) * 2.0 * math.pi / BEAMS
    c, s = np.cos(angles), np.sin(angles)
    x_wall = np.where(c > 0, ROOM[2] - pose[0], ROOM[0] - pose[0]) / c
    y_wall = np.where(s > 0, ROOM[3] - pose[1], ROOM[1] - pose[1]) / s
    distances = np.minimum(x_wall, y_wall)
    off = np.array([3.3, 2.4]) - pose[:2]
    along, across = off[0] * c + off[1] * s, off[1] * c - off[0] * s
    post = along - np.sqrt(np.maximum(0.35**2 - across**2, 0.0))
    distances = np.where((np.abs(across) < 0.35) & (along > 0), np.minimum(post, distances), distances)
    return np.asarray(distances + 0.004 * np.sin(7.0 * np.arange(BEAMS)))


def scan_at(pose: tuple[float, float, float], placed: bool) -> PointScan:
    """Return the scan from a pose, in its own frame or in that of the room, with its normals."""
    readings = ranges_in_room(pose).astype(np.float32)
    bearings = np.arange(BEAMS) * 2.0 * math.pi / BEAMS
    points, used = textbook.scan_points(readings, bearings, np.zeros(3), 0.05, 2.6)
    if placed:
        points = np.where(used[:, np.newaxis], transform_points(pose, points), 0.0)
    points = points.round(6)
    sensor = np.array(pose[:2]) if placed else np.zeros(2)
    nothing = np.zeros_like(points)
    first = pose[2] if placed else 0.0
    bare = PointScan(points, used, nothing, np.zeros(BEAMS, np.bool_), first, 2.0 * math.pi / BEAMS, True, sensor)
    normals, has_normal = textbook.scan_normals(bare, *NORMALS.values())
    return PointScan(points, used, normals, has_normal, first, bare.step, True, sensor)


def pairs_and_equations(moving: PointScan, pose: np.ndarray, fixed: PointScan) -> dict[str, Any]:
    """Return the pairs of a pose, the kept ones, the equations of the distances to the lines, and both new poses."""
    ours, theirs, _ = textbook.pairs_by_bearing(moving, pose, fixed, np.zeros(3), GATE, BEAMS)
    arguments = moving.points[ours], pose, fixed.points[theirs]
    e, jacobian = textbook.point_to_line_residuals(*arguments, fixed.normals[theirs])
    kept = textbook.smallest(e, KEEP)
    h, g = textbook.normal_equations(jacobian[kept], e[kept], np.ones(np.count_nonzero(kept)))
    apart = np.linalg.norm(textbook.point_to_point_residuals(*arguments)[0].reshape(-1, 2), axis=1)
    near = textbook.smallest(apart, KEEP)
    to_point = textbook.best_rigid_motion(moving.points[ours[near]], fixed.points[theirs[near]])
    return {
        "ours": ours.tolist(), "theirs": theirs.tolist(), "kept": ours[kept].tolist(), "h": h.tolist(), "g": g.tolist(),
        "point_to_line": (pose + np.linalg.solve(h, g)).tolist(), "point_to_point": to_point.tolist(),
    }  # fmt: skip


def least_known(h: np.ndarray, points: np.ndarray) -> dict[str, Any]:
    """Return the least eigenvalue's share and its direction, as :class:`mapper.matching.match.Match` states them."""
    scale = np.array([1.0, 1.0, 1.0 / math.sqrt(np.mean(np.sum(points**2, axis=1)))])
    values, vectors = np.linalg.eigh(h * np.outer(scale, scale))
    direction = vectors[:, 0] * scale
    return {"share": values[0] / (h[0, 0] + h[1, 1]), "direction": (direction / np.linalg.norm(direction)).tolist()}


def vectors() -> dict[str, Any]:
    """Return two scans, and what the textbook makes of them step by step."""
    fixed, moving = scan_at(FIXED_AT, placed=True), scan_at(MOVING_AT, placed=False)
    first = pairs_and_equations(moving, np.array(GUESS), fixed)
    paths: dict[str, list[Any]] = {}
    for method in ("point_to_point", "point_to_line"):
        pose, path = np.array(GUESS), []
        for _ in range(STEPS):
            pose = np.array(pairs_and_equations(moving, pose, fixed)[method])
            path.append(pose.tolist())
        paths[method] = path
    geometry = GridGeometry(**FIELD)
    scores = textbook.score_field(geometry, fixed.points[fixed.is_point], SIGMA, FINE, REACH)
    points = moving.points[moving.is_point]
    volume = textbook.scores_in_window(scores, geometry, points, np.array(GUESS), np.array(TURNS), CELLS)
    turn, row, col = np.unravel_index(np.argmax(volume), volume.shape)
    best = [GUESS[0] + (col - CELLS) * 0.1, GUESS[1] + (row - CELLS) * 0.1, GUESS[2] + TURNS[turn]]
    scans = {
        name: {"points": scan.points.tolist(), "is_point": scan.is_point.astype(int).tolist(),
               "sensor": scan.sensor.tolist(), "normals": scan.normals.tolist(),
               "has_normal": scan.has_normal.astype(int).tolist()}
        for name, scan in (("fixed", fixed), ("moving", moving))
    }  # fmt: skip
    settings = {"normals": NORMALS, "gate": GATE, "keep": KEEP, "guess": GUESS, "truth": MOVING_AT, "field": FIELD,
                "sigma": SIGMA, "fine": FINE, "reach": REACH, "turns": TURNS, "cells": CELLS}  # fmt: skip
    return {
        "settings": settings, "scans": scans, "first": first, "paths": paths,
        "least_known": least_known(np.array(first["h"]), points), "scores": scores.ravel().tolist(),
        "window": volume[1].ravel().tolist(), "best": {"pose": best, "score": int(volume.max())},
    }  # fmt: skip


def text() -> str:
    return json.dumps(vectors(), separators=(",", ":")).replace(',"', ',\n"') + "\n"


def assert_alike(old: Any, new: Any, where: str) -> None:
    if isinstance(new, dict):
        assert old.keys() == new.keys(), where
        for key in new:
            assert_alike(old[key], new[key], f"{where} {key}")
    else:
        np.testing.assert_allclose(old, new, atol=1e-9, err_msg=where)


def test_the_vectors_of_scan_matching_are_those_of_the_textbook():
    hint = "run: python tests/mapper/vectors/test_matching_vectors.py --write"
    assert_alike(json.loads(VECTORS.read_text()), json.loads(text()), hint)


def test_the_textbook_finds_the_true_pose_of_the_vectors():
    """The last pose of each method is near the one from which the scan was simulated: the vectors show a match."""
    paths = vectors()["paths"]
    np.testing.assert_allclose(paths["point_to_line"][-1], MOVING_AT, atol=0.03)
    assert math.dist(paths["point_to_point"][-1][:2], MOVING_AT[:2]) < math.dist(GUESS[:2], MOVING_AT[:2])


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(text())
