"""Open a log of any format that is known: the kind is read from the bytes, never from the name."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from mapper.errors import MapperError, ReadError
from mapper.limits import DEFAULT_LIMITS, Limits
from mapper.logs import breezyslam, carmen, csv_scans, dpslam, mcap_file, ros1_bag, ros2_db3, sonar
from mapper.logs.inflate import ZSTD_MAGIC
from mapper.logs.lines import BOM
from mapper.logs.unpacking import GZIP_MAGIC, Progress, Unpacked, opened
from mapper.scan import ScanLog

HEAD = 1 << 16  #: bytes that the kind is read from

#: First bytes of files that are no text log, and what they are.
FOREIGN: tuple[tuple[bytes, str], ...] = (
    (b"BZh", "bzip2 data"),
    (b"\xfd7zXZ\0", "xz data"),
    (b"\x89PNG\r\n", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"BM", "a BMP picture"),
    (b"P5", "a PGM picture"),
    (b"%PDF", "a PDF document"),
    (b"\xff\xfe", "text in UTF-16, as some Windows programs write it (save it as UTF-8)"),
    (b"\xfe\xff", "text in UTF-16 (save it as UTF-8)"),
    (GZIP_MAGIC, "gzip data within packed data (unpack it once)"),
    (ZSTD_MAGIC, "Zstandard data within packed data (unpack it once)"),
    (b"\x37\x7f\x06\x82", "the write-ahead log of an SQLite file, of no use without the .db3"),
    (b"\x37\x7f\x06\x83", "the write-ahead log of an SQLite file, of no use without the .db3"),
)

#: Archives of several files: where their mark stands, the mark, and what they are.
ARCHIVES: tuple[tuple[int, bytes, str], ...] = (
    (0, b"PK\x03\x04", "a zip archive"),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (0, b"Rar!", "a rar archive"),
    (257, b"ustar", "a tar archive"),
)

Reader = Callable[[Path, Limits, Progress | None, str | None], ScanLog]

#: First bytes of the binary formats.
BINARY: tuple[tuple[bytes, Reader], ...] = (
    (ros1_bag.MAGIC, ros1_bag.read_ros1_bag),
    (mcap_file.MAGIC, mcap_file.read_mcap),
    (ros2_db3.MAGIC, ros2_db3.read_ros2_db3),
)

#: First words of the lines of the text formats.
TEXT: tuple[tuple[frozenset[str], Reader], ...] = (
    (carmen.WORDS, carmen.read_carmen),
    (dpslam.WORDS, dpslam.read_dpslam),
)

#: What tells a text of numbers by its beginning.
NUMBERS: tuple[tuple[Callable[[bytes], bool], Reader], ...] = (
    (csv_scans.is_csv_scans, csv_scans.read_csv_scans),
    (breezyslam.is_breezyslam, breezyslam.read_breezyslam),
    (sonar.is_sonar, sonar.read_sonar),
)

#: How the files end in the folder that a ROS 2 bag is.
ROS2_FILES = (".db3", ".mcap", ".db3.zstd", ".mcap.zstd")

KNOWN = "CARMEN, ROS 1 bag, ROS 2 bag (SQLite), MCAP, DP-SLAM, BreezySLAM, a sonar ring or CSV"


def is_log(path: str | os.PathLike[str]) -> bool:
    """Return whether the file at ``path`` begins as a log of a known format does; only its beginning is read.

    False for a file that cannot be opened. A log may begin well and still be one that :func:`open_log` refuses.
    """
    try:
        _reader_for(_file_of(Path(path)))
    except MapperError:
        return False
    return True


def open_log(
    path: str | os.PathLike[str],
    *,
    topic: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
) -> ScanLog:
    """Return the log at ``path``, plain or compressed, of any known kind (:data:`KNOWN`).

    Of a folder the sonar ring in it is read, or the one file of the ROS 2 bag that it is.
    ``topic`` names the sensor where there are several (``log.topics`` lists them); without it, the one with most scans
    is taken. ``progress`` is called with the share of the file that has been read, 0 … 1. Raises :class:`ReadError`,
    which names the place, for a file that is missing, no log, damaged or without scans, or a topic that it lacks, and
    :class:`LimitError` for one that is larger than ``limits`` allow.
    """
    file = _file_of(Path(path))
    return _reader_for(file)(file, limits, progress, topic)


def _file_of(path: Path) -> Path:
    """Return the recording in a folder, or ``path`` itself; raise :class:`ReadError` where there are several."""
    if not path.is_dir():
        return path
    try:
        files = sorted(one for one in path.iterdir() if one.name.endswith(ROS2_FILES))
    except OSError:
        return path
    if len(files) > 1:
        names = ", ".join(repr(one.name)[:80] for one in files[:6])
        raise ReadError("log.folder", f"The folder holds {len(files)} recordings; open one of them: {names}.")
    return files[0] if files else path


def _reader_for(file: Path) -> Reader:
    """Return the reader of the format that the file begins in; raise :class:`ReadError` where it begins in none."""
    if sonar.is_sonar_folder(file):
        return sonar.read_sonar
    head, broken = _head(file)
    for magic, reader in BINARY:
        if head.startswith(magic):
            return reader
    archive = next((what for at, mark, what in ARCHIVES if head.startswith(mark, at)), None)
    if archive is not None:  # the lines of a log may well stand in it
        raise ReadError("log.archive", f"The file is {archive}: unpack it, and take the log (or the folder) in it.")
    words = _first_words(head)
    for format_words, reader in TEXT:
        if words & format_words:
            return reader
    if not broken or b"\n" in head:  # half a line of numbers looks like another format's
        for begins, reader in NUMBERS:
            if begins(head):
                return reader
    if broken:
        raise ReadError("log.truncated", f"The packed data {broken}, before it tells what kind of log it is.")
    raise _not_a_log(head)


def _head(file: Path) -> tuple[bytes, str | None]:
    """Return the log's first bytes, and what is wrong with its packed data where they are all that come out."""
    head = b""
    with opened(file) as stream:
        unpacked = Unpacked(stream, lambda: "at the beginning")
        for piece in unpacked:
            head += piece
            if len(head) >= HEAD:
                break
    return head[:HEAD].removeprefix(BOM), unpacked.broken


def _first_words(head: bytes) -> set[str]:
    return {line.split(None, 1)[0].decode("latin-1") for line in head.split(b"\n") if line.strip()}


def _not_a_log(head: bytes) -> ReadError:
    if not head:
        return ReadError("log.empty", "The file is empty.")
    foreign = next((what for magic, what in FOREIGN if head.startswith(magic)), None)
    if foreign is not None:
        return ReadError("log.unknown_format", f"The file is {foreign}, and no log ({KNOWN}).")
    if b"\0" in head:
        return ReadError("log.binary", "The file is binary data, not a text log.")
    comments = all(line.lstrip().startswith(b"#") for line in head.split(b"\n") if line.strip())
    if comments:
        return ReadError("log.no_scans", "The log holds no scans: it has nothing but comments and empty lines.")
    line = next(line for line in head.split(b"\n") if line.strip())
    return ReadError(
        "log.unknown_format",
        f"The file is no log of a known kind ({KNOWN}): it starts with {line[:40].decode('latin-1')!r}.",
    )
