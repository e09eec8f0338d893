"""Opening of logs of any known format, which is detected from the bytes, never from the name."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import BinaryIO

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs.archives.archive import Member, Source
from mapper.io.logs.archives.packed_archive import archive_members, is_archive
from mapper.io.logs.archives.unpacking import Progress, Unpacked, opened
from mapper.io.logs.containers import mcap_file, ros1_bag, ros2_db3
from mapper.io.logs.containers.container import Container, are_parts_by_name, in_order
from mapper.io.logs.containers.kept_copies import journal_of
from mapper.io.logs.foreign import READ_HERE, archive_of, not_a_log, zipped_document
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.selection import ALL_SENSORS, Selection
from mapper.io.logs.text import breezyslam, carmen, cmu, csv_scans, dpslam, gfs, sonar
from mapper.io.logs.text.lines import BOM, with_line_feeds
from mapper.io.logs.understanding import understood
from mapper.sensors.joint_log import with_notes
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import OdometryRecords

HEAD = 1 << 16  #: bytes used for format detection

Reader = Callable[[Source, Limits, Progress | None, str | None], ScanLog]
RobotReader = Callable[[Source, Limits, Progress | None, Selection], RobotLog]
Reading = Callable[[Limits, Progress | None, Selection], RobotLog]  #: for files that have been identified

#: First bytes of the binary formats.
BINARY: tuple[tuple[bytes, Container], ...] = (
    (ros1_bag.MAGIC, ros1_bag.ROS1_BAG),
    (mcap_file.MAGIC, mcap_file.MCAP),
    (ros2_db3.MAGIC, ros2_db3.ROS2_DB3),
)

#: First words of the lines of the text formats.
TEXT: tuple[tuple[frozenset[str], Reader], ...] = (
    (gfs.WORDS, gfs.read_gfs),  # before CARMEN's, whose lines may be among them
    (carmen.WORDS, carmen.read_carmen),
    (dpslam.WORDS, dpslam.read_dpslam),
)

#: Detection of numeric texts by their beginning.
NUMBERS: tuple[tuple[Callable[[bytes], bool], Reader], ...] = (
    (cmu.is_cmu, cmu.read_cmu),
    (csv_scans.is_csv_scans, csv_scans.read_csv_scans),
    (breezyslam.is_breezyslam, breezyslam.read_breezyslam),
    (sonar.is_sonar, sonar.read_sonar),
)

CLOUD_ENDINGS = (".bin", ".pcd", ".ply", ".las", ".laz", ".xyz", ".pts")  #: extensions that no log has
METADATA = "metadata.yaml"  #: written by rosbag2 next to the files of a split recording


def is_log(path: str | os.PathLike[str]) -> bool:
    """Return whether the file at ``path`` starts like a log of a known format; only its beginning is read.

    False for a file that cannot be opened. :func:`open_log` may still reject the file.
    """
    try:
        _reading(Path(path), DEFAULT_LIMITS)
    except MapperError:
        return False
    return True


def open_log(
    path: str | os.PathLike[str],
    *,
    topic: str | None = None,
    tf: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
) -> ScanLog:
    """Return one range sensor of the log at ``path``, plain or compressed, of any kind in ``foreign.KNOWN``.

    For a folder, or a tar archive of one, plain or compressed, the log in it is read: the only file that is a log, the
    files of a split ROS 2 recording, or the two files of a sonar ring. ``topic`` names the sensor if there are several
    (``log.topics`` lists them); by default the one with most scans is read. ``tf`` names the topic of transforms, if
    there are several. ``progress`` is called with the fraction of the file read, 0 to 1. Raises :class:`ReadError`,
    naming the place, for a file that is missing, not a log, damaged or without scans, or a topic that it lacks, and
    :class:`LimitError` for one that exceeds ``limits``.
    """
    return understood(_reading(Path(path), limits)(limits, progress, Selection.of(topic, tf=tf))).first


def open_robot_log(
    path: str | os.PathLike[str],
    *,
    selection: Selection = ALL_SENSORS,
    limits: Limits = DEFAULT_LIMITS,
    progress: Progress | None = None,
    also: MessageSink | None = None,
) -> RobotLog:
    """Return the log at ``path`` with the sensors of ``selection``; otherwise like :func:`open_log`.

    ``also`` receives the messages of a recording in the same pass; a text format has none.
    """
    return understood(_reading(Path(path), limits, also)(limits, progress, selection))


def odometry_records(
    path: str | os.PathLike[str], *, topic: str | None = None, limits: Limits = DEFAULT_LIMITS
) -> OdometryRecords | None:
    """Return the odometry messages of the log at ``path`` in record order, around its scans.

    None for logs of other formats than CARMEN, in a folder or a tar archive, or without such messages. Raises the
    errors of :func:`open_log`.
    """
    file = Path(path)
    if file.is_dir() or is_archive(file) or _kind_of(file) is not carmen.read_carmen:
        return None
    return carmen.read_carmen(file, limits, None, topic).odometry


def log_files(path: Path) -> list[Path]:
    """Return the files of the log in a folder, or the file at ``path``, with all files that belong to them.

    These are the files that mark several files as one log, and what a killed recorder left next to a database. Raises
    :class:`ReadError` for a folder with no log, or with several.
    """
    files: list[Source] = [path]
    if path.is_dir():
        inside = _files_in(path, DEFAULT_LIMITS)
        files, _ = _one_log(inside, "folder")
        files = [*(file for file in inside if file.name == METADATA and len(files) > 1), *files]
    together = [part for file in files for part in (file, journal_of(file))]
    return [file for file in together if isinstance(file, Path)]


def parts_of(path: Path, limits: Limits = DEFAULT_LIMITS) -> tuple[Sequence[Source], Container | Reader]:
    """Return the files of the log at ``path``, in order, and their format.

    Raises :class:`ReadError` if there is no log, or several.
    """
    if path.is_dir():
        files, kind = _one_log(_files_in(path, limits), "folder")
    elif (archived := archive_members(path, limits)) is not None:
        files, kind = _one_log(archived[0], "archive")
    else:
        return [path], _kind_of(path)
    return in_order(files) if isinstance(kind, Container) else files, kind


def _reading(path: Path, limits: Limits, also: MessageSink | None = None) -> Reading:
    """Return a function that reads the log at ``path``; raise :class:`MapperError` if there is none, or several."""
    if path.is_dir():
        return _reading_together(_files_in(path, limits), "folder", path.name, also)
    if (archived := archive_members(path, limits)) is not None:
        files, notes = archived
        if notes and not files:
            raise ReadError("log.archive", "The tar archive is damaged, or ends, before the first file in it.")
        return _noting(notes, _reading_together(files, "archive", path.name, also))
    return partial(_reader(_kind_of(path), also), path)


def _files_in(folder: Path, limits: Limits) -> list[Source]:
    """Return a folder's own files, except hidden ones."""
    try:
        inside = sorted(islice(folder.iterdir(), limits.max_archive_files + 1))
    except OSError as error:
        raise ReadError("log.unreadable", f"The folder cannot be read: {error.strerror}.") from error
    if len(inside) > limits.max_archive_files:
        raise LimitError("log.too_many_files", f"The folder has more than {limits.max_archive_files} files.")
    shown = [path_ for path_ in inside if not path_.name.startswith(".")]
    files: list[Source] = [path_ for path_ in shown if path_.is_file()]
    if shown and not files:
        names = ", ".join(repr(path_.name)[:80] for path_ in shown[:6])
        raise ReadError("log.folder", f"The folder holds folders alone, {names}: open the one with the recording.")
    return files


def _reading_together(files: Sequence[Source], where: str, name: str, also: MessageSink | None) -> Reading:
    """Return a function that reads these files as one log."""
    logs, kind = _one_log(files, where)
    if len(logs) == 1:
        return partial(_reader(kind, also), logs[0])
    if isinstance(kind, Container):
        is_stated = any(file.name == METADATA for file in files)
        return partial(kind.read_split, logs, name, also=also, by_name=not is_stated)
    return partial(_one_sensor, partial(sonar.read_sonar, poses=logs[1]), logs[0])


def _one_log(files: Sequence[Source], where: str) -> tuple[list[Source], Container | Reader]:
    """Return the files of the only log among these, and their kind; raise :class:`ReadError` if there is none."""
    by_place = {(_folder_of(file), file.name): file for file in files}
    for (folder, last), readings in by_place.items():
        if last == sonar.READINGS and (folder, sonar.POSES) in by_place:
            return [readings, by_place[folder, sonar.POSES]], sonar.read_sonar
    kinds: dict[Source, Container | Reader] = {}
    why_not: list[MapperError] = []
    for file in files:
        try:
            kinds[file] = _kind_of(file)
        except MapperError as error:
            if len(files) == 1:
                raise
            if error.code not in ("log.unknown_format", "log.binary") and file.name != METADATA:
                why_not.append(type(error)(error.code, f"{file.name}: {error.message}"))
    if not kinds and why_not:
        raise min(why_not, key=lambda why: why.code == "log.empty")  # reports the error of a non-empty file
    if not kinds:
        clouds = sorted(file.name for file in files if file.name.lower().endswith(CLOUD_ENDINGS))
        if clouds:
            what = f"{len(clouds)} clouds, as {clouds[0]!r:.80}," if len(clouds) > 1 else f"the cloud {clouds[0]!r:.80}"
            raise ReadError(
                "log.folder",
                f"The {where} holds {what} and no log: gridbloom map3d maps such files in the order in which they are "
                "named, with --poses at a pose for each; the page opens each by itself.",
            )
        raise ReadError("log.folder", f"The {where} holds no log of a known kind. {READ_HERE}")
    logs = list(kinds)
    why = _apart(logs, set(kinds.values()), by_place) if len(logs) > 1 else None
    if why is not None:
        names = ", ".join(repr(name)[:80] for name in sorted(log.name for log in logs)[:6])
        raise ReadError("log.folder", f"The {where} holds {len(logs)} recordings, {why}; open one of them: {names}.")
    return logs, kinds[logs[0]]


def _apart(
    logs: Sequence[Source], kinds: Collection[Container | Reader], places: Collection[tuple[str, str]]
) -> str | None:
    """Return why logs are not parts of one recording; None if they are."""
    folders = {_folder_of(log) for log in logs}
    if len(folders) > 1:
        return "in different folders"
    if len(kinds) > 1:
        return "of different kinds"
    if not all(isinstance(kind, Container) for kind in kinds):
        return "each a log by itself"
    if (*folders, METADATA) not in places and not are_parts_by_name([log.name for log in logs]):
        return f"and no {METADATA} that would make them parts of one, nor names of one kind, numbered from 0"
    return None


def _folder_of(file: Source) -> str:
    return file.folder if isinstance(file, Member) else str(file.parent)


def _noting(notes: Sequence[str], reading: Reading) -> Reading:
    """Return ``reading`` with notes added to its log."""

    def noted(limits: Limits, progress: Progress | None, selection: Selection) -> RobotLog:
        robot = reading(limits, progress, selection)
        logs = {name: with_notes(log, notes, first=True) for name, log in robot.sensors.items()}
        return replace(robot, sensors=logs)

    return noted if notes else reading


def _reader(kind: Container | Reader, also: MessageSink | None) -> RobotReader:
    if isinstance(kind, Container):
        return partial(kind.read, also=also)
    reader = carmen.read_carmen_sensors if kind is carmen.read_carmen else partial(_one_sensor, kind)
    return partial(_without_transforms, reader)


def _without_transforms(
    reader: RobotReader, file: Source, limits: Limits, progress: Progress | None, selection: Selection
) -> RobotLog:
    """Return the log of a format without transforms. Raises :class:`ReadError` if a topic of transforms is named."""
    if selection.tf is not None:
        raise ReadError("log.tf", f"The log has no transforms on {selection.tf!r:.80}: its format has none.")
    return reader(file, limits, progress, selection)


def _one_sensor(
    reader: Reader, file: Source, limits: Limits, progress: Progress | None, selection: Selection
) -> RobotLog:
    """Return the log of a format with one sensor. Raises :class:`ReadError` if a topic is named."""
    topic = selection.topics[0] if selection.topics else None
    return RobotLog.of_one(reader(file, limits, progress, topic))


def _kind_of(file: Source) -> Container | Reader:
    """Return the format of the beginning of the file; raise :class:`ReadError` if it is unknown."""
    head, broken = _head(file)
    for magic, container in BINARY:
        if head.startswith(magic):
            return container
    archive = archive_of(head)
    if zipped_document(head) is not None:
        raise not_a_log(head)
    if archive is not None:  # an archive may contain the lines of a log
        raise ReadError("log.archive", f"The file is {archive}: unpack it, and take the log (or the folder) in it.")
    words = _first_words(head)
    for format_words, reader in TEXT:
        if words & format_words:
            return reader
    if not broken or b"\n" in head:  # half a line of numbers looks like another format
        for begins, reader in NUMBERS:
            if begins(head):
                return reader
    if broken:
        raise ReadError("log.truncated", f"The packed data {broken}, before the kind of log is known.")
    raise not_a_log(head)


def _head(file: Source) -> tuple[bytes, str | None]:
    """Return the log's first bytes, and the error in its compressed data if no more can be read."""
    if isinstance(file, Member) and file.head is not None:
        head = _head_of(io.BytesIO(file.head))
        if len(head[0]) >= HEAD or len(file.head) == file.size:
            return head
    with opened(file) as stream:
        return _head_of(stream)


def _head_of(stream: BinaryIO) -> tuple[bytes, str | None]:
    head = b""
    unpacked = Unpacked(stream, lambda: "at the beginning", DEFAULT_LIMITS)
    for piece in unpacked:
        head += piece
        if len(head) >= HEAD:
            break
    return with_line_feeds(head[:HEAD].removeprefix(BOM)), unpacked.broken


def _first_words(head: bytes) -> set[str]:
    return {line.split(None, 1)[0].decode("latin-1") for line in head.split(b"\n") if line.strip()}
