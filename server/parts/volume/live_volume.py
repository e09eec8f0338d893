"""The 3D map of the lab's robot, computed from its 3D sensor while it drives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from mapper.core.array_types import BoolArray, Float64Array
from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import Limits
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.occupancy_grid import OCCUPIED
from mapper.simulation.robot import PoseTuple
from mapper.simulation.sensors_3d import Scan3D, measure_3d
from mapper.simulation.worlds import World
from mapper.volume import OccupancyVolume, Octree, VolumeConfig, project
from mapper.volume.blocks import BLOCK
from mapper.volume.occupancy.volume import Inserted
from mapper.volume.placed_scan import PlacedScan
from mapper.volume.scans.sources import Insertion
from server.parts.volume.parameters import HIGHEST, VolumeParameters

MOST_POINTS = 150_000  #: of the newest scans that are used as a cloud
TRUE_WITHIN = 0.05  #: metres: a point this close to the floor or a ramp is ground
MOST_BLOCKS = 30_000  #: of 8³ voxels: 60 MB of log-odds
MOST_READINGS = 4_000_000  #: of all recorded scans: 16 MB
AT_ONCE = 4  #: recorded scans integrated per tick into a map that is recomputed
DECAY_DRAWN_S = 1.0  #: simulated seconds after which decaying voxels that no scan touched are redrawn
BYTES_OF_NODE = 5  #: log-odds and the bits of its children, as in an ``.ot`` file


class LabVolume:
    """Scans of a 3D sensor and their map. Not thread-safe.

    With another voxel size the map is recomputed from the scans, a few with each :meth:`catch_up`. If a recording
    becomes too long, every second scan is dropped.
    """

    def __init__(self, world: World, seed: int, parameters: VolumeParameters) -> None:
        self.parameters = parameters
        self.world = world
        self._noise = np.random.default_rng([seed, 3])
        self._due = -np.inf  #: when the next scan is due, simulated seconds
        self.scans: list[Scan3D] = []
        self.problem: LimitError | None = None  #: why some scans are not in the map
        self.begin_map()

    def begin_map(self) -> None:
        """Clear the map, but keep the scans."""
        self.volume = OccupancyVolume(self.parameters.config)
        self.used = 0  #: number of the scans in the map
        self.problem = None
        self._inserted = Insertion()
        self._decayed_at = -np.inf  #: stamp of the scan since which decayed voxels were not redrawn, seconds

    def change(self, parameters: VolumeParameters) -> bool:
        """Use other parameters; return whether the map is recomputed."""
        before, self.parameters = self.parameters, parameters
        if parameters.sensor != before.sensor:
            self._due = -np.inf
        if parameters.config == before.config:
            return False
        self.begin_map()
        return True

    @property
    def is_behind(self) -> bool:
        """Whether recorded scans are not in the map yet."""
        return self.used < len(self.scans) and self.problem is None

    def look(self, world: World, pose: PoseTuple, believed: PoseTuple, now: float) -> bool:
        """Record a scan at ``pose`` (by the robot's estimate ``believed``), if one is due at ``now``, s.

        At most one is recorded, however much time has passed. Returns whether there is one.
        """
        sensor = self.parameters.sensor
        if self.problem is not None or now < self._due - 1e-9:
            return False
        self._due = max(self._due + 1.0 / sensor.rate, now)
        self.world = world
        self.scans.append(Scan3D(sensor, measure_3d(world, sensor, pose, self._noise), believed, now))
        if sum(len(scan.ranges) for scan in self.scans) > MOST_READINGS:
            scans = range(len(self.scans) - 1, -1, -2)[::-1]
            self.used = sum(i < self.used for i in scans)
            self.scans = [self.scans[i] for i in scans]
        return True

    def catch_up(self, limits: Limits) -> list[np.ndarray]:
        """Integrate the next scans into the map; return the slots of the blocks that each touched."""
        self.volume.blocks.limits = lab_limits(limits)
        touched = []
        for scan in self.scans[self.used : self.used + AT_ONCE]:
            try:
                touched.append(self._insert(_placed(scan, self.config)).slots)
            except LimitError as error:
                self.problem = error
                break
            self.used += 1
            if self.config.half_life > 0.0 and abs(scan.stamp_s - self._decayed_at) >= DECAY_DRAWN_S:
                self._decayed_at = scan.stamp_s
                touched.append(np.arange(self.volume.blocks.count, dtype=np.int32))  # all blocks have changed
        return touched

    def _insert(self, scan: PlacedScan) -> Inserted:
        return self._inserted.insert(self.volume, scan)

    @property
    def config(self) -> VolumeConfig:
        """The parameters of the map."""
        return self.parameters.config

    @property
    def index(self) -> int:
        """Number of stored scans in the map."""
        return self.used

    def placed_scans(self) -> Iterator[PlacedScan]:
        """Yield these scans."""
        return (_placed(scan, self.config) for scan in self.scans[: self.used])

    def projection(self) -> OccupancyGrid:
        """Return the map from above of the band of heights, on a lattice that covers the world."""
        size = self.parameters.config.resolution
        x0, y0, x1, y1 = self.world.bounds
        col0, row0 = int(np.floor(x0 / size)) - 1, int(np.floor(y0 / size)) - 1
        cols, rows = int(np.ceil(x1 / size)) + 1 - col0, int(np.ceil(y1 / size)) + 1 - row0
        grid = OccupancyGrid(GridGeometry(size, rows, cols, (col0 * size, row0 * size, 0.0)))
        try:
            projected = project(self.volume, *self.parameters.band)
        except ConfigError:
            return grid  # nothing is known at these heights yet
        down = round(projected.geometry.origin[1] / size) - row0
        right = round(projected.geometry.origin[0] / size) - col0
        r0, c0 = max(down, 0), max(right, 0)
        r1, c1 = min(down + projected.geometry.rows, rows), min(right + projected.geometry.cols, cols)
        if r0 < r1 and c0 < c1:
            part = slice(r0 - down, r1 - down), slice(c0 - right, c1 - right)
            grid.log_odds[r0:r1, c0:c1] = projected.log_odds[part]
            grid.observed[r0:r1, c0:c1] = projected.observed[part]
        return grid

    def memory(self) -> dict[str, int]:
        """Return the map's memory in three representations, bytes, and the numbers of nodes and known voxels.

        A dense grid has a float32 for each voxel of the world's box, :data:`HIGHEST` high.
        """
        volume, size = self.volume, self.parameters.config.resolution
        x0, y0, x1, y1 = self.world.bounds
        dense = np.prod(np.ceil(np.array([x1 - x0, y1 - y0, HIGHEST]) / size - 1e-9))
        tree = Octree.of(volume) if volume.blocks.count else None
        nodes = 0 if tree is None else tree.n_nodes
        return {
            "known": volume.n_known,
            "nodes": nodes,
            "leaves": 0 if tree is None else tree.n_leaves,
            "octree_bytes": BYTES_OF_NODE * nodes,
            "block_bytes": volume.n_bytes,
            "dense_bytes": 4 * int(dense),
        }


def lab_limits(limits: Limits) -> Limits:
    """Return the limits for a map of the lab."""
    return replace(limits, max_blocks=min(MOST_BLOCKS, limits.max_cells // BLOCK**3))


def _placed(scan: Scan3D, config: VolumeConfig) -> PlacedScan:
    """Return the ends of a scan's beams.

    Beams without a return end beyond the longest range of the map, which cuts them. If the sensor's range was shorter
    than it is now they are left out, because their ends would become obstacles.
    """
    ends, origin = scan.ends()
    if scan.sensor.reach < config.range_max:
        ends = ends[np.isfinite(scan.ranges)]
    return PlacedScan(ends, origin, round(1e9 * scan.stamp_s))


def only_in_3d(projection: OccupancyGrid, flat: OccupancyGrid) -> tuple[np.ndarray, int]:
    """Return the cells of the projection, uint8 (rows, cols), and how many of its occupied cells a flat map lacks.

    255 is unknown, 0 free, 1 occupied in both maps, 2 occupied in the projection without an occupied cell of the flat
    map within one cell.
    """
    occupied = projection.classify() == OCCUPIED
    rows, cols = np.nonzero(flat.classify() == OCCUPIED)
    near = np.zeros((projection.geometry.rows + 2, projection.geometry.cols + 2), dtype=np.bool_)
    places = projection.geometry.world_to_cell(flat.geometry.cell_to_world(np.stack([rows, cols], axis=1)))
    inside = ((places >= 0) & (places < projection.geometry.shape)).all(axis=1)
    for down in range(3):
        for right in range(3):
            near[places[inside, 0] + down, places[inside, 1] + right] = True
    out = np.where(projection.observed, 0, 255).astype(np.uint8)
    out[occupied] = 1
    out[occupied & ~near[1:-1, 1:-1]] = 2
    return out, int((out == 2).sum())


def points_of(scans: Sequence[Scan3D]) -> Float64Array:
    """Return at most :data:`MOST_POINTS` measured points (n, 3) of the newest scans, metres."""
    left, parts = MOST_POINTS, []
    for scan in reversed(scans):
        points = scan.ends()[0][np.isfinite(scan.ranges)]
        parts.append(points[:left])
        left -= len(parts[-1])
        if left <= 0:
            break
    return np.concatenate(parts) if parts else np.empty((0, 3))


def true_ground(world: World, points: Float64Array) -> BoolArray:
    """Return which points (n, 3) are on the floor of a world or on one of its ramps."""
    on_ground = np.abs(points[:, 2]) <= TRUE_WITHIN
    for block in world.blocks:
        a, b, c = block.top
        if b == c == 0.0:
            continue
        low, high = block.outline.min(axis=0), block.outline.max(axis=0)
        inside = ((points[:, :2] >= low) & (points[:, :2] <= high)).all(axis=1)
        on_ground |= inside & (np.abs(points[:, 2] - a - points[:, :2] @ (b, c)) <= TRUE_WITHIN)
    return np.asarray(on_ground)
