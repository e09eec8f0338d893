"""The limits of the mapping core."""

from __future__ import annotations

from dataclasses import dataclass

LEAST_RECORD_BYTES = 256  #: mean size of the records of a recording that has more of them than messages are kept


@dataclass(frozen=True, slots=True)
class Limits:
    """Caps on what is read and built. Exceeding one raises :class:`mapper.core.errors.LimitError`.

    The defaults let a 16,384-cell-a-side map and two hours of a 1,080-beam lidar at 40 Hz through, and stop a gzip
    bomb. The size of a file has no limit: of a recording only what a map needs is read and kept.
    """

    max_unpacked_bytes: int = 1 << 30  #: bytes that a file's compressed data may expand to, whatever its size,
    max_expansion: int = 100  #: more bytes are allowed for a file that expands by less than this factor
    max_line_bytes: int = 1 << 20  #: bytes of one line of a text log
    max_lines: int = 5_000_000  #: lines of a text log: a day of odometry at 50 Hz
    max_chunk_bytes: int = 1 << 28  #: bytes of one record of a bag, and of what a compressed one expands to
    max_messages: int = 10_000_000  #: messages that are kept: poses at 400 Hz for seven hours
    max_archive_files: int = 10_000  #: files in a tar archive, or in a folder, that is one log
    max_topics: int = 2000  #: topics of a bag
    max_scans: int = 500_000
    max_beams: int = 20_000  #: beams of one scan
    max_readings: int = 300_000_000  #: scans × beams of one log
    max_cells: int = 1 << 28  #: cells of one grid (16,384²)
    max_side: int = 1 << 15  #: rows or columns of one grid; tile indices are int16
    max_blocks: int = 1 << 19  #: blocks of 8³ voxels of one volume: 1 GiB of log-odds
    max_scan_box: int = 1 << 36  #: voxels of the box around one scan: 300 × 300 × 100 m at 5 cm
    max_points: int = 50_000_000  #: points of one cloud: 1.2 GB
    max_cloud_bytes: int = 1 << 31  #: bytes of one cloud's file, unpacked
    max_coordinate: float = 1e8  #: metres: a point farther out than 2.5 times round the Earth is a defect
    max_depth_frames: int = 100_000  #: depth images of one folder
    max_depth_pixels: int = 1 << 26  #: of one depth image
    max_image_bytes: int = 1 << 30  #: bytes of a map image
    max_yaml_bytes: int = 1 << 16  #: bytes of a map's yaml
    max_added_solids: int = 100  #: walls and boxes drawn into one world
    max_pose: float = 1e6  #: metres: a pose farther out than this is a defect in the log

    def unpacked_bytes(self, size: int) -> int:
        """Return how many bytes the compressed data in a file of ``size`` bytes may expand to."""
        return max(self.max_unpacked_bytes, self.max_expansion * size)

    def records(self, size: int) -> int:
        """Return how many records a recording of ``size`` bytes may have: its real ones have some hundred bytes."""
        return max(self.max_messages, size // LEAST_RECORD_BYTES)


DEFAULT_LIMITS = Limits()
