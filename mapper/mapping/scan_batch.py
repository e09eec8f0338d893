"""A batch of scans of one sensor, with its poses: the data that all updates read."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry
from mapper.mapping.kernels.bresenham import reach
from mapper.mapping.kernels.types import ReadingFilter, Scans

_CHUNK_READINGS = 1 << 19  # planned at once: each chunk costs two rounds of the threads


@dataclass(frozen=True)  # without slots: cached properties need a __dict__
class ScanBatch:
    """Scans of one sensor, with the poses it had."""

    ranges: NDArray[np.float32]  #: (n_scans, n_beams), m
    sensor_poses: NDArray[np.float64]  #: (n_scans, 3), T_map_laser
    angles: NDArray[np.float64]  #: (n_beams,), rad in the laser frame
    fields: NDArray[np.float64]  #: (n_beams, 4), see mapper.sensors.beam_fields.beam_fields
    range_min: float  #: m
    range_max: float  #: m
    numbers: NDArray[np.int64]  #: (n_scans,) of the scan; rows of one scan, its deskewed beams, follow one another

    @cached_property
    def sensors(self) -> NDArray[np.float64]:
        """(n_scans, 4): x, y (m), cos θ, sin θ."""
        theta = np.ascontiguousarray(self.sensor_poses[:, 2])
        return np.column_stack([self.sensor_poses[:, :2], np.cos(theta), np.sin(theta)])

    @cached_property
    def beams(self) -> NDArray[np.float64]:
        """(n_beams, 2): cosine and sine of the bearings."""
        return directions(self.angles.tobytes())

    def headings(self, geometry: GridGeometry) -> NDArray[np.float64]:
        """Return the cosine and sine (n_scans, 2) of the sensor's heading along the lattice."""
        if geometry.origin[2] == 0.0:
            return np.ascontiguousarray(self.sensors[:, 2:])
        theta = np.ascontiguousarray(self.sensor_poses[:, 2] - geometry.origin[2])
        return np.column_stack([np.cos(theta), np.sin(theta)])

    def scans_on(self, geometry: GridGeometry) -> Scans:
        """Return all scans as the kernels take them, on the lattice of ``geometry``."""
        return Scans(self.ranges, self.sensors, self.beams, self.fields, self.headings(geometry), self.numbers)

    def chunks_on(self, geometry: GridGeometry) -> list[Scans]:
        """Return the scans as :meth:`scans_on`, in chunks of about half a million readings, none within a scan."""
        step = max(1, _CHUNK_READINGS // max(1, self.ranges.shape[1]))
        scans, n = self.scans_on(geometry), len(self.ranges)
        ends = scan_ends(self.numbers)
        edges = np.unique([0, *ends[np.searchsorted(ends, range(step, n, step))], n])
        return [part_of(scans, first, stop) for first, stop in pairwise(edges.tolist())]

    def bounds(self, reading_filter: ReadingFilter, *, fields: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the least and the greatest x, y (2,), metres in the map, of the sensors and of all that they see.

        With ``fields`` a beam sees its whole field, otherwise only its axis.
        """
        out = np.array([np.inf, np.inf, -np.inf, -np.inf])
        directions = [self.beams]
        if fields and len(self.fields):
            # A field ends in an arc, which is within the polygon of three corners around it: right, middle and left.
            right, left = self.fields[:, :2], self.fields[:, 2:]
            cos_half = np.minimum(np.sum(right * self.beams, axis=1), np.sum(left * self.beams, axis=1))
            stretch = 1.0 / np.cos(0.5 * np.arccos(np.clip(cos_half, 0.0, 1.0)))[:, np.newaxis]
            directions = [right * stretch, self.beams * stretch, left * stretch]
        for direction in directions:
            reach(self.ranges, self.sensors, np.ascontiguousarray(direction), reading_filter, out)
        return out[:2], out[2:]


@lru_cache(maxsize=32)  # the scans of a live robot, and of all of one kind, have the same bearings
def directions(angles: bytes) -> NDArray[np.float64]:
    """Return the cosine and sine (n, 2) of float64 angles, radians. It is shared and must not be modified."""
    radians = np.frombuffer(angles)
    return np.column_stack([np.cos(radians), np.sin(radians)])


def scan_ends(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the row after the last one of each scan; ``numbers`` (n_rows,) as those of :class:`Scans`."""
    return np.flatnonzero(np.diff(numbers, append=numbers[-1:] - 1)) + 1


def part_of(scans: Scans, start: int, stop: int) -> Scans:
    """Return the scans [start, stop) as views."""
    part = slice(start, stop)
    return scans._replace(
        ranges=scans.ranges[part],
        sensors=scans.sensors[part],
        headings=scans.headings[part],
        numbers=scans.numbers[part],
    )
