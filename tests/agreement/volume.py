"""Volumes, for the table: random scans in a small room, by the kernels and by the textbook."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.volume import OccupancyVolume, Octree, VolumeConfig, cast, distance_to_obstacle, octree_file, project
from mapper.volume.mesh.faces import CHUNK, FaceRule, VoxelFaces, chunks_of, face_rule
from mapper.volume.occupancy import textbook
from mapper.volume.occupancy.volume import FORGET_BELOW


@dataclass(frozen=True)
class VolumeCase:
    """Scans, each an origin and points, how they become a map, and rays and points to ask it about."""

    config: VolumeConfig
    scans: list[tuple[np.ndarray, np.ndarray]]
    elapsed: float
    origins: np.ndarray
    directions: np.ndarray
    through_unknown: bool
    range_max: float
    band: tuple[float, float]

    def volume(self) -> OccupancyVolume:
        volume = OccupancyVolume(self.config)
        for points, origin in self.scans:
            volume.insert_scan(points, origin)
        volume.decay(self.elapsed)
        return volume

    def voxels(self) -> textbook.Voxels:
        voxels: textbook.Voxels = {}
        for points, origin in self.scans:
            textbook.insert_scan(voxels, points, origin, self.config)
        if self.config.half_life:
            factor = np.float32(0.5 ** (self.elapsed / self.config.half_life))
            textbook.decay(voxels, factor, np.float32(FORGET_BELOW))
        return voxels


@st.composite
def volume_cases(draw: st.DrawFn) -> VolumeCase:
    """Points at random places and on the borders of voxels, so that rays meet edges and corners; some on one voxel."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    resolution = draw(st.sampled_from([0.1, 0.25, 0.3]))
    spread = draw(st.sampled_from([0.5, 1.5]))
    step = draw(st.sampled_from([0.0, 0.5, 1.0]))

    def places(n: int) -> np.ndarray:
        some = rng.normal(0.0, spread, (n, 3))
        return (np.round(some / (step * resolution)) * step * resolution if step else some).astype(np.float32)

    scans = [(places(draw(st.sampled_from([0, 1, 12]))), places(1)[0]) for _ in range(draw(st.integers(1, 3)))]
    directions = places(8)
    directions[~directions.any(axis=1)] = [0.0, 0.0, 1.0]
    return VolumeCase(
        VolumeConfig(
            resolution=resolution,
            p_hit=draw(st.sampled_from([0.7, 0.9])),
            p_occupied=draw(st.sampled_from([0.5, 0.8])),
            range_max=draw(st.sampled_from([0.0, 1.2])),
            discretise=draw(st.booleans()),
            half_life=draw(st.sampled_from([0.0, 10.0])),
        ),
        scans,
        draw(st.sampled_from([1.0, 30.0])),
        places(8),
        directions,
        draw(st.booleans()),
        draw(st.sampled_from([0.7, 4.0])),
        draw(st.sampled_from([(-np.inf, np.inf), (-0.4, 0.9), (0.3, 0.3)])),
    )


def inserted_by_kernel(case: VolumeCase) -> tuple[Any, ...]:
    keys, values = case.volume().voxels()
    order = np.lexsort(keys.T)
    return keys[order], values[order]


def inserted_by_textbook(case: VolumeCase) -> tuple[Any, ...]:
    voxels = case.voxels()
    keys = np.array(list(voxels), dtype=np.int64).reshape(-1, 3)
    order = np.lexsort(keys.T)
    return keys[order], np.array(list(voxels.values()), dtype=np.float32)[order]


def cast_by_kernel(case: VolumeCase) -> tuple[Any, ...]:
    casts = cast(
        case.volume(), case.origins, case.directions, through_unknown=case.through_unknown, range_max=case.range_max
    )
    return casts.keys, casts.ends


def cast_by_textbook(case: VolumeCase) -> tuple[Any, ...]:
    voxels = case.voxels()
    ends = [
        textbook.cast_ray(
            voxels, origin, direction, case.config, through_unknown=case.through_unknown, range_max=case.range_max
        )
        for origin, direction in zip(case.origins, case.directions, strict=True)
    ]
    return np.array([key for _, key in ends]), np.array([end for end, _ in ends], dtype=np.uint8)


def tree_by_kernel(case: VolumeCase) -> tuple[Any, ...]:
    """Of the tree, and of the tree that is made of that map's tree: the data of both kinds of files, the nodes."""
    tree = Octree.of(case.volume())
    again = Octree.of(tree.volume(case.config))
    files = [octree_file(one, kind, case.config) for one in (tree, again) for kind in (".ot", ".bt")]
    return tuple(file.bytes(case.config)[len(file.header) :] for file in files)


def tree_by_textbook(case: VolumeCase) -> tuple[Any, ...]:
    config, voxels = case.config, case.voxels()
    node = textbook.pruned_tree(voxels)
    if node is None:
        return b"", b"", b"", b""
    states = {
        key: config.log_odds_max if value >= config.log_odds_occupied else config.log_odds_min
        for key, value in voxels.items()
    }
    likely = textbook.pruned_tree(states)
    assert likely is not None
    both = textbook.ot_data(node), textbook.bt_data(likely, config.log_odds_occupied)
    return both + both


def asked_by_kernel(case: VolumeCase) -> tuple[Any, ...]:
    """The distances to obstacles, and the map from above."""
    volume = case.volume()
    distances = distance_to_obstacle(volume, case.origins, 3.0)
    low, high = case.band
    if not textbook.projection(case.voxels(), *_levels(case)):
        return distances, []
    grid = project(volume, low, high)
    rows, cols = np.nonzero(grid.observed)
    x, y = grid.geometry.cell_to_world(np.stack([rows, cols], axis=1)).T / case.config.resolution
    columns = zip(np.floor(x).astype(int).tolist(), np.floor(y).astype(int).tolist(), strict=True)
    return distances, sorted(zip(columns, grid.log_odds[rows, cols].tolist(), strict=True))


def asked_by_textbook(case: VolumeCase) -> tuple[Any, ...]:
    voxels = case.voxels()
    distances = [textbook.nearest_occupied(voxels, origin, case.config, 3.0) for origin in case.origins]
    columns = textbook.projection(voxels, *_levels(case))
    cells = [((x - textbook.CENTRE, y - textbook.CENTRE), float(value)) for (x, y), value in columns.items()]
    return np.array(distances), sorted(cells)


def _levels(case: VolumeCase) -> tuple[int, int]:
    """The levels of voxels that the band of heights has."""
    low, high = case.band
    levels = [
        level
        for level in range(-100, 100)
        if (low == high and level == np.floor((1.0 / case.config.resolution) * low))
        or (low <= (level + 0.5) * case.config.resolution <= high)
    ]
    return levels[0] + textbook.CENTRE, levels[-1] + textbook.CENTRE


def faces_by_kernel(case: VolumeCase) -> tuple[Any, ...]:
    """Of each chunk the rectangles of its faces, and the number of its drawn voxels."""
    volume, faces = case.volume(), VoxelFaces()
    faces.update(volume, _rule(case, volume), chunks_of(volume))
    return [(key, faces.voxels[key], faces.chunks[key].tolist()) for key in sorted(faces.chunks)], sorted(faces.voxels)


def faces_by_textbook(case: VolumeCase) -> tuple[Any, ...]:
    voxels, rule = case.voxels(), _rule(case, case.volume())
    found = []
    for chunk in sorted({(x // CHUNK, y // CHUNK, z // CHUNK) for x, y, z in voxels}):
        corner = (CHUNK * chunk[0], CHUNK * chunk[1], CHUNK * chunk[2])
        colours = textbook.chunk_colours(voxels, corner, CHUNK, rule)
        inside = [key for key in colours if all(0 <= k < CHUNK for k in key)]
        hides = partial(textbook.hides_faces, voxels, corner, rule, colours)
        quads = textbook.merged_faces(colours, CHUNK, hides)
        if quads:
            found.append((chunk, len(inside), [list(quad) for quad in quads]))
    return found, [chunk for chunk, _, _ in found]


def _rule(case: VolumeCase, volume: OccupancyVolume) -> FaceRule:
    low, high = case.band if case.band[0] < case.band[1] else (-0.6, 0.6)
    return face_rule(
        volume,
        (-0.7, -np.inf, low),
        (np.inf, 0.9, high),
        base=-0.5,
        band=0.3,
        colours=5,
        by_belief=case.through_unknown,
        seen_only=case.config.discretise,
    )
