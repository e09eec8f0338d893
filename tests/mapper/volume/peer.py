"""OctoMap itself, and scans to compare with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyoctomap

from mapper.volume import VolumeConfig


def octomap_tree(scans: list[tuple[np.ndarray, np.ndarray]], config: VolumeConfig) -> pyoctomap.OcTree:
    """Return OctoMap's tree of scans, each points (n, 3) and an origin (3,), float32."""
    tree = pyoctomap.OcTree(config.resolution)
    for points, origin in scans:
        tree.insertPointCloud(
            points.astype(np.float64),
            origin.astype(np.float64),
            max_range=config.range_max or -1.0,
            discretize=config.discretise,
        )
    return tree


def written(tree: pyoctomap.OcTree, kind: str, folder: Path) -> bytes:
    """Return the bytes of OctoMap's file of a tree."""
    path = folder / f"peer{kind}"
    assert tree.write(str(path)) if kind == ".ot" else tree.writeBinary(str(path))
    return path.read_bytes()


def room_scans(n_scans: int = 3, n_points: int = 1500) -> list[tuple[np.ndarray, np.ndarray]]:
    """Scans of a room of 4 × 6 × 2.5 m from several places, float32; a few points lie far outside."""
    rng = np.random.default_rng(5)
    scans = []
    for _ in range(n_scans):
        origin = rng.uniform([-1.0, -2.0, 0.5], [1.0, 2.0, 1.5])
        away = rng.normal(size=(n_points, 3))
        with np.errstate(divide="ignore"):
            walls = (
                np.where(away > 0.0, np.array([2.0, 3.0, 2.5]) - origin, np.array([-2.0, -3.0, 0.0]) - origin) / away
            )
        ranges = walls.min(axis=1) + rng.normal(0.0, 0.01, n_points)
        ranges[:5] *= 3.0
        scans.append(((origin + away * ranges[:, None]).astype(np.float32), origin.astype(np.float32)))
    return scans
