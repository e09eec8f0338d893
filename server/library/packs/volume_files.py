"""Reading the source of a 3D map in the worker process: clouds, scan graphs, depth folders, recordings, octrees."""

from __future__ import annotations

import contextlib
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from mapper.core.array_types import Float32Array
from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.core.sampling import sample_rows
from mapper.io.clouds.content import content
from mapper.io.clouds.depth_archive import is_depth_archive, is_zip, unpack_depth_archive
from mapper.io.clouds.depth_folder import is_depth_folder
from mapper.io.clouds.reading import TEXT, cloud_format
from mapper.io.logs.archives.unpacking import Progress
from mapper.io.logs.opening import is_log
from mapper.io.logs.summary import NO_SCANS, LogSummary, TimeSummary, time_without_gaps
from mapper.volume.occupancy.volume import centres_of
from mapper.volume.octree.files import is_octree, octree_of_bytes
from mapper.volume.scans.scan_sequence import UPS, ScanSequence, gather
from mapper.volume.scans.sources import file_head
from server.library.packs.picture import HEIGHTS, write_codes
from server.library.packs.volume import VolumeSource, write_volume_pack

MOST_OCTREE_BYTES = 256 << 20  #: of the file of an octree, whose tree is kept in memory
SIDE = 320  #: pixels along the longer side
MOST_POINTS = 400_000
OUTLIERS = 0.5  #: percentage of the points at each end of an axis that may be outside the picture


def holds_volume(path: Path) -> bool:
    """Return whether a file is a cloud, a scan graph, an octree or an archive of depth images, by its bytes.

    A folder of depth images is one too; a text of numbers that is a known log is not. Raises :class:`ReadError` if the
    file cannot be read.
    """
    if path.is_dir():
        return is_depth_folder(path)
    head = file_head(path, DEFAULT_LIMITS)
    if is_octree(head) or is_zip(head):
        return True
    kind = cloud_format(head)
    if kind is None:
        return is_depth_archive(path, DEFAULT_LIMITS)
    return kind != TEXT or not is_log(path)


def read_volume(path: Path, topic: str | None, progress: Progress) -> VolumeSource:
    """Return the contents of the file. Raises :class:`ReadError` and :class:`LimitError`."""
    head = b"" if path.is_dir() else file_head(path, DEFAULT_LIMITS)
    if is_octree(head):
        return octree_of_bytes(content(path, replace(DEFAULT_LIMITS, max_cloud_bytes=MOST_OCTREE_BYTES)), "The octree")
    if is_zip(head) or (not path.is_dir() and cloud_format(head) is None and is_depth_archive(path, DEFAULT_LIMITS)):
        with tempfile.TemporaryDirectory(prefix="gridbloom-depth-") as folder:
            # Half of the progress is for unpacking, half for reading the images.
            unpack_depth_archive(path, Path(folder), DEFAULT_LIMITS, lambda share: progress(0.5 * share))
            return gather(folder, progress=lambda share: progress(0.5 + 0.5 * share))
    return gather(path, topic=topic, progress=progress)


def store_volume(source: VolumeSource, pack: Path | None, picture: Path | None) -> None:
    """Write the pack and the picture. Raises :class:`LimitError` if there is no room."""
    if pack is not None:
        try:
            write_volume_pack(source, pack)
        except OSError as error:
            message = "What was read of the file could not be stored; the server’s disk may be full."
            raise LimitError("log.storage", message) from error
    if picture is not None:
        with contextlib.suppress(OSError, ValueError, MemoryError):
            write_volume_picture(source, picture)


def summarise_volume(source: VolumeSource, name: str) -> LogSummary:
    """Return the figures of the source of a 3D map."""
    if not isinstance(source, ScanSequence):
        if source.tree.n_nodes == 0:
            raise ReadError("octree.empty", "The octree has no nodes.")
        return _summary(name, f"OctoMap {source.kind}", 1, source.tree.n_leaves, source.notes, None, 0.0)
    time, duration = time_without_gaps(source.stamps_ns)
    return _summary(name, source.kind, len(source), len(source.points), source.notes, time, duration)


def _summary(
    name: str, kind: str, clouds: int, points: int, notes: tuple[str, ...], time: TimeSummary | None, duration: float
) -> LogSummary:
    return replace(
        NO_SCANS,
        name=name,
        format=kind,
        duration_s=duration,
        notes=notes,
        time=time,
        clouds=clouds,
        points=points,
    )


def write_volume_picture(source: VolumeSource, path: Path) -> bool:
    """Draw ``source`` into the file ``path``; return whether there was anything to draw. Raises :class:`OSError`."""
    points = _points(source)
    if not len(points):
        return False
    low, high = np.percentile(points, [OUTLIERS, 100.0 - OUTLIERS], axis=0)
    size = float(max(high[0] - low[0], high[1] - low[1], 1e-3)) / (SIDE - 8)
    cols, rows = (int(np.ceil((high[k] - low[k]) / size)) + 8 for k in (0, 1))
    col = np.floor((points[:, 0] - low[0]) / size).astype(np.int64) + 4
    row = rows - 1 - (np.floor((points[:, 1] - low[1]) / size).astype(np.int64) + 4)
    inside = (col >= 0) & (col < cols) & (row >= 0) & (row < rows)
    share = (points[:, 2] - low[2]) / max(float(high[2] - low[2]), 1e-6)
    first, count = HEIGHTS
    codes = np.zeros((rows, cols), dtype=np.uint8)
    colours = (first + np.clip(share * count, 0, count - 1)).astype(np.uint8)
    np.maximum.at(codes, (row[inside], col[inside]), colours[inside])
    write_codes(codes, path)
    return True


def _points(source: VolumeSource) -> Float32Array:
    """Return at most :data:`MOST_POINTS` points (n, 3), or centres of an octree's occupied leaves, metres."""
    if isinstance(source, ScanSequence):
        points = source.points[sample_rows(len(source.points), MOST_POINTS)]
        return np.asarray(points @ np.array(UPS[source.first_up], dtype=np.float32).T)
    keys, depths, values = source.tree.leaves()
    sides = np.int64(1) << (16 - depths.astype(np.int64))
    occupied = values >= 0.0
    middles = keys[occupied] + sides[occupied, None] // 2
    return centres_of(middles[sample_rows(len(middles), MOST_POINTS)], source.tree.resolution)
