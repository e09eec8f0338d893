"""3D occupancy as in the paper: a dictionary of voxels, one beam and one voxel at a time.

A voxel is identified by its key (x, y, z), 16-bit integers; key 32768 starts at coordinate 0. Number types are
OctoMap's (float32 for points, float64 along a beam), so that ties are resolved identically.

Source: Hornung, Wurm, Bennewitz, Stachniss & Burgard, OctoMap: an efficient probabilistic 3D mapping framework based on
octrees, Autonomous Robots 34, 2013; Amanatides & Woo, A fast voxel traversal algorithm for ray tracing, 1987.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence

import numpy as np

from mapper.core.array_types import Float32Array
from mapper.volume.kernels.types import FaceRule
from mapper.volume.occupancy.parameters import VolumeConfig

DEPTH = 16  #: levels below the root
CENTRE = 1 << (DEPTH - 1)  #: key of the voxel that starts at coordinate 0
FREE, HIT, UNKNOWN, TOO_FAR, OUTSIDE = range(5)  #: how a cast ray ends; FREE is never an end

Key = tuple[int, int, int]
Voxels = dict[Key, np.float32]
Point = Sequence[np.float32] | Float32Array


def key_of(point: Point, resolution: float) -> Key | None:
    """Return the key of the voxel that contains a point, None outside the 2¹⁶ voxels of an axis."""
    key = [math.floor((1.0 / resolution) * float(c)) + CENTRE for c in point]
    return (key[0], key[1], key[2]) if all(0 <= k < 2 * CENTRE for k in key) else None


def centre_of(key: Key, resolution: float) -> Float32Array:
    """Return the centre (3,) of a voxel, metres."""
    return np.array([(k - CENTRE + 0.5) * resolution for k in key], dtype=np.float32)


def norm(vector: Float32Array) -> float:
    """Return the length of a vector (3,), with squares summed in float32."""
    x, y, z = vector
    return math.sqrt(x * x + y * y + z * z)


def crossings(
    origin: Float32Array, direction: Float32Array, key: Key, resolution: float
) -> tuple[list[int], list[float], list[float]]:
    """Return for each axis the step, the distance to the first border and the distance between borders."""
    steps, first, between = [0, 0, 0], [math.inf] * 3, [math.inf] * 3
    for axis in range(3):
        if direction[axis] != 0.0:
            steps[axis] = 1 if direction[axis] > 0.0 else -1
            border = (key[axis] - CENTRE + 0.5) * resolution + float(np.float32(steps[axis] * resolution * 0.5))
            first[axis] = (border - float(origin[axis])) / float(direction[axis])
            between[axis] = resolution / abs(float(direction[axis]))
    return steps, first, between


def next_axis(t: Sequence[float]) -> int:
    """Return the axis of the nearest border; of equal ones the last."""
    if t[0] < t[1]:
        return 0 if t[0] < t[2] else 2
    return 1 if t[1] < t[2] else 2


def ray_keys(origin: Float32Array, end: Float32Array, resolution: float) -> list[Key]:
    """Return the voxels from ``origin`` (3,) to ``end`` (3,), without the one that contains the end."""
    first, last = key_of(origin, resolution), key_of(end, resolution)
    if first is None or last is None or first == last:
        return []
    direction = end - origin
    length = np.float32(norm(direction))
    direction = direction / length
    steps, t, between = crossings(origin, direction, first, resolution)
    keys, key = [first], list(first)
    while True:
        axis = next_axis(t)
        key[axis] += steps[axis]
        t[axis] += between[axis]
        if tuple(key) == last or min(t) > float(length):  # rounding may miss the last voxel
            return keys
        keys.append((key[0], key[1], key[2]))


def seen_voxels(points: Float32Array, origin: Float32Array, config: VolumeConfig) -> tuple[set[Key], set[Key]]:
    """Return the voxels that a scan observes as free and as occupied, each once; occupied if both.

    ``points`` (n, 3) and ``origin`` (3,) are in the frame of the map.
    """
    resolution = config.resolution
    if config.discretise:
        keys = {key_of(point, resolution) for point in points}
        points = np.array([centre_of(key, resolution) for key in keys if key], dtype=np.float32).reshape(-1, 3)
    free: set[Key] = set()
    occupied: set[Key] = set()
    for point in points:
        key = key_of(point, resolution)
        if config.range_max == 0.0 or norm(point - origin) <= config.range_max:
            if key is not None:
                occupied.add(key)
            free.update(ray_keys(origin, point, resolution))
        else:
            away = point - origin
            end = origin + away / np.float32(norm(away)) * np.float32(config.range_max)
            free.update(ray_keys(origin, end, resolution))
    return free - occupied, occupied


def insert_scan(voxels: Voxels, points: Float32Array, origin: Float32Array, config: VolumeConfig) -> None:
    """Update a map by one scan: log-odds are added and clamped."""
    free, occupied = seen_voxels(points, origin, config)
    for keys, update in ((free, config.log_odds_miss), (occupied, config.log_odds_hit)):
        for key in keys:
            value = voxels.get(key, np.float32(0.0)) + update
            voxels[key] = min(max(value, config.log_odds_min), config.log_odds_max)


def decay(voxels: Voxels, factor: np.float32, forget_below: np.float32) -> None:
    """Multiply all log-odds by ``factor``, and remove the voxels whose log-odds are then nearer to 0 than a limit."""
    for key in list(voxels):
        voxels[key] *= factor
        if abs(voxels[key]) < forget_below:
            del voxels[key]


def cast_ray(
    voxels: Voxels, origin: Float32Array, direction: Float32Array, config: VolumeConfig, *, through_unknown: bool,
    range_max: float = 0.0,
) -> tuple[int, Key]:  # fmt: skip
    """Return how a ray ends (:data:`HIT`, ...) and the key of its last voxel.

    The range is measured to voxel centres; a ``range_max`` of 0 means no limit. ``direction`` must not be 0.
    """
    resolution, occupied = config.resolution, config.log_odds_occupied
    first = key_of(origin, resolution)
    if first is None:
        return OUTSIDE, (0, 0, 0)
    if first in voxels and voxels[first] >= occupied:
        return HIT, first
    if first not in voxels and not through_unknown:
        return UNKNOWN, first
    direction = direction / np.float32(norm(direction))
    steps, t, between = crossings_of_cast(origin, direction, first, resolution)
    key = list(first)
    while True:
        axis = next_axis(t)
        if (steps[axis] < 0 and key[axis] == 0) or (steps[axis] > 0 and key[axis] == 2 * CENTRE - 1):
            return OUTSIDE, (key[0], key[1], key[2])
        key[axis] += steps[axis]
        t[axis] += between[axis]
        at = (key[0], key[1], key[2])
        if range_max > 0.0:
            apart = centre_of(at, resolution) - origin
            if sum(float(d * d) for d in apart) > range_max * range_max:
                return TOO_FAR, at
        if at in voxels:
            if voxels[at] >= occupied:
                return HIT, at
        elif not through_unknown:
            return UNKNOWN, at


def crossings_of_cast(
    origin: Float32Array, direction: Float32Array, key: Key, resolution: float
) -> tuple[list[int], list[float], list[float]]:
    """Return :func:`crossings`, with half a voxel in float64, as in OctoMap's castRay."""
    steps, first, between = crossings(origin, direction, key, resolution)
    for axis in range(3):
        if steps[axis]:
            border = (key[axis] - CENTRE + 0.5) * resolution + steps[axis] * resolution * 0.5
            first[axis] = (border - float(origin[axis])) / float(direction[axis])
    return steps, first, between


def nearest_occupied(voxels: Voxels, point: Float32Array, config: VolumeConfig, distance_max: float) -> float:
    """Return the distance from a point to the nearest centre of an occupied voxel, infinite beyond the limit."""
    best = math.inf
    for key, value in voxels.items():
        if value >= config.log_odds_occupied:
            best = min(
                best, math.dist([float(c) for c in point], [(k - CENTRE + 0.5) * config.resolution for k in key])
            )
    return best if best <= distance_max else math.inf


def projection(voxels: Voxels, low: int, high: int) -> dict[tuple[int, int], np.float32]:
    """Return the maximum log-odds of each column (x, y) with known voxels whose key z is ``low`` … ``high``."""
    columns: dict[tuple[int, int], np.float32] = {}
    for (x, y, z), value in voxels.items():
        if low <= z <= high:
            columns[x, y] = max(value, columns.get((x, y), value))
    return columns


Node = tuple[np.float32, dict[int, "Node"]]  #: log-odds and children by index: 1 × x + 2 × y + 4 × z half


def pruned_tree(voxels: Voxels) -> Node | None:
    """Return the root of a map's octree: eight equal leaves are merged, and an inner node has the maximum value below
    it.
    """
    if not voxels:
        return None
    nodes: dict[Key, Node] = {key: (value, {}) for key, value in voxels.items()}
    for _ in range(DEPTH):
        parents: dict[Key, dict[int, Node]] = {}
        for (x, y, z), node in nodes.items():
            parents.setdefault((x >> 1, y >> 1, z >> 1), {})[(x & 1) + 2 * (y & 1) + 4 * (z & 1)] = node
        nodes = {key: _joined(children) for key, children in parents.items()}
    return nodes[0, 0, 0]


def _joined(children: dict[int, Node]) -> Node:
    values = [value for value, _ in children.values()]
    if len(children) == 8 and len(set(values)) == 1 and not any(below for _, below in children.values()):
        return values[0], {}
    return max(values), children


def ot_data(node: Node) -> bytes:
    """Return a node and its descendants in the .ot format: log-odds, a bit for each child, the children in order."""
    value, children = node
    bits = sum(1 << number for number in children)
    return struct.pack("<fB", value, bits) + b"".join(ot_data(children[number]) for number in sorted(children))


def bt_data(node: Node, occupied: np.float32) -> bytes:
    """Return a node and its descendants in the .bt format: two bits per child, then the children that have children.

    The bits of child n are bits 2n and 2n + 1: 00 unknown, 01 (bit 2n) free, 10 occupied, 11 has children.
    """
    _, children = node
    bits = 0
    for number, (value, below) in children.items():
        bits |= (3 if below else 2 if value >= occupied else 1) << 2 * number
    return struct.pack("<H", bits) + b"".join(
        bt_data(children[number], occupied) for number in sorted(children) if children[number][1]
    )


def is_in_box(rule: FaceRule, key: Key) -> bool:
    """Return whether a voxel is in the drawn box."""
    return all(first <= k <= last for first, k, last in zip(rule.first, key, rule.last, strict=True))


def chunk_colours(voxels: Voxels, corner: Key, side: int, rule: FaceRule) -> dict[Key, int]:
    """Return the colours of the drawn voxels in and around a cube of ``side`` voxels, by position in the cube.

    Those around it have a coordinate of −1 or ``side`` along some axis.
    """
    colours = {}
    for key, value in voxels.items():
        x, y, z = (k - c for k, c in zip(key, corner, strict=True))
        if not all(-1 <= k <= side for k in (x, y, z)) or float(value) < rule.occupied:
            continue
        if not is_in_box(rule, key):
            continue
        step = math.floor((key[2] - rule.base) / rule.band)
        if rule.by_belief:
            step = int((float(value) - rule.occupied) / (rule.greatest - rule.occupied) * rule.colours)
        colours[x, y, z] = 1 + min(max(step, 0), rule.colours - 1)
    return colours


def hides_faces(voxels: Voxels, corner: Key, rule: FaceRule, colours: dict[Key, int], place: Key) -> bool:
    """Return whether a voxel in a cube hides the faces towards it, because it is drawn or was never seen."""
    key = (place[0] + corner[0], place[1] + corner[1], place[2] + corner[2])
    return place in colours or (rule.seen_only and is_in_box(rule, key) and key not in voxels)


def merged_faces(
    colours: dict[Key, int], side: int, hides: Callable[[Key], bool]
) -> list[tuple[int, int, int, int, int, int, int]]:
    """Merge the visible faces of a cube's drawn voxels into rectangles of one colour each.

    In each plane of faces, row by row, the first remaining face is extended as far as possible in length, then in
    width. The format is that of :func:`mapper.volume.kernels.faces.merge_faces`. Source: M. Lysenko, Meshing in a
    Minecraft Game, 2012 (greedy meshing).
    """
    merged = []
    for number in range(6):
        axis, step = number // 2, 1 if number % 2 else -1
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for level in range(side):
            faces = {}
            for key, colour in colours.items():
                x, y, z = (k + step * (n == axis) for n, k in enumerate(key))
                if key[axis] == level and 0 <= key[u] < side and 0 <= key[v] < side and not hides((x, y, z)):
                    faces[key[v], key[u]] = colour
            while faces:
                b, a = min(faces)
                colour, wide, high = faces[b, a], 1, 1
                while faces.get((b, a + wide)) == colour:
                    wide += 1
                while all(faces.get((b + high, a + k)) == colour for k in range(wide)):
                    high += 1
                for row in range(b, b + high):
                    for k in range(a, a + wide):
                        del faces[row, k]
                place = [0, 0, 0]
                place[axis], place[u], place[v] = level, a, b
                merged.append((number, place[0], place[1], place[2], wide, high, colour))
    return merged
