"""The limits of the mapping core."""

from __future__ import annotations

from dataclasses import dataclass

LEAST_RECORD_BYTES = 256  #: mean record size of a recording that has more records than the limit of messages


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits on input sizes and on what is built from them. Exceeding one raises
    :class:`mapper.core.errors.LimitError`.

    The defaults allow a map of 16,384² cells and two hours of a 1,080-beam lidar at 40 Hz, and reject a gzip bomb. File
    size is not limited, because only the data that a map needs is read from a recording.
    """

    max_unpacked_bytes: int = 1 << 30  #: bytes that a file's compressed data may expand to, regardless of its size;
    max_expansion: int = 100  #: a file that expands by less than this factor may exceed max_unpacked_bytes
    max_line_bytes: int = 1 << 20  #: bytes of one line of a text log
    max_lines: int = 5_000_000  #: lines of a text log: a day of odometry at 50 Hz
    max_chunk_bytes: int = 1 << 28  #: bytes of one record of a bag, compressed or expanded
    max_messages: int = 10_000_000  #: messages kept in memory: poses at 400 Hz for seven hours
    max_archive_files: int = 10_000  #: files in a tar archive or folder that is read as one log
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
    max_coordinate: float = 1e8  #: metres: a point farther than 2.5 times the Earth's circumference is invalid
    max_depth_frames: int = 100_000  #: depth images of one folder
    max_depth_pixels: int = 1 << 26  #: pixels of one depth image
    max_image_bytes: int = 1 << 30  #: bytes of a map image
    max_yaml_bytes: int = 1 << 16  #: bytes of a map's yaml
    max_added_solids: int = 100  #: walls and boxes drawn into one world
    max_pose: float = 1e6  #: metres: a pose farther than this is an error in the log

    def unpacked_bytes(self, size: int) -> int:
        """Return the number of bytes that the compressed data in a file of ``size`` bytes may expand to."""
        return max(self.max_unpacked_bytes, self.max_expansion * size)

    def records(self, size: int) -> int:
        """Return the number of records that a recording of ``size`` bytes may have; real records have some hundred
        bytes.
        """
        return max(self.max_messages, size // LEAST_RECORD_BYTES)


DEFAULT_LIMITS = Limits()
