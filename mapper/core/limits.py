"""The limits of the mapping core."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Limits:
    """Caps on what is read and built. Exceeding one raises :class:`mapper.core.errors.LimitError`.

    The defaults let a 16,384-cell-a-side map and an hour of a 1,080-beam lidar through, and stop a gzip bomb.
    """

    max_log_bytes: int = 1 << 30  #: bytes of a log after decompression
    max_line_bytes: int = 1 << 20  #: bytes of one line of a text log
    max_lines: int = 5_000_000  #: lines of a text log: a day of odometry at 50 Hz
    max_chunk_bytes: int = 1 << 28  #: bytes of one record of a bag, and of what a compressed one expands to
    max_messages: int = 10_000_000  #: messages of a bag: IMU at 400 Hz for seven hours
    max_archive_files: int = 10_000  #: files in a tar archive, or in a folder, that is one log
    max_topics: int = 2000  #: topics of a bag
    max_scans: int = 500_000
    max_beams: int = 20_000  #: beams of one scan
    max_readings: int = 300_000_000  #: scans × beams of one log
    max_cells: int = 1 << 28  #: cells of one grid (16,384²)
    max_side: int = 1 << 15  #: rows or columns of one grid; tile indices are int16
    max_image_bytes: int = 1 << 30  #: bytes of a map image
    max_yaml_bytes: int = 1 << 16  #: bytes of a map's yaml
    max_added_solids: int = 100  #: walls and boxes drawn into one world
    max_pose: float = 1e6  #: metres: a pose farther out than this is a defect in the log


DEFAULT_LIMITS = Limits()
