"""Open a log of any format that is known: the kind is read from the bytes, never from the name."""

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

HEAD = 1 << 16  #: bytes that the kind is read from

Reader = Callable[[Source, Limits, Progress | None, str | None], ScanLog]
RobotReader = Callable[[Source, Limits, Progress | None, Selection], RobotLog]
Reading = Callable[[Limits, Progress | None, Selection], RobotLog]  #: of files that are known already

#: First bytes of the binary formats.
BINARY: tuple[tuple[bytes, Container], ...] = (
    (ros1_bag.MAGIC, ros1_bag.ROS1_BAG),
    (mcap_file.MAGIC, mcap_file.MCAP),
    (ros2_db3.MAGIC, ros2_db3.ROS2_DB3),
)

#: First words of the lines of the text formats.
TEXT: tuple[tuple[frozenset[str], Reader], ...] = (
    (gfs.WORDS, gfs.read_gfs),  # before CARMEN's: its lines may be among them
    (carmen.WORDS, carmen.read_carmen),
    (dpslam.WORDS, dpslam.read_dpslam),
)

#: What tells a text of numbers by its beginning.
NUMBERS: tuple[tuple[Callable[[bytes], bool], Reader], ...] = (
    (cmu.is_cmu, cmu.read_cmu),
    (csv_scans.is_csv_scans, csv_scans.read_csv_scans),
    (breezyslam.is_breezyslam, breezyslam.read_breezyslam),
    (sonar.is_sonar, sonar.read_sonar),
)

CLOUD_ENDINGS = (".bin", ".pcd", ".ply", ".las", ".laz", ".xyz", ".pts")  #: of files that no log has
METADATA = "metadata.yaml"  #: what rosbag2 writes next to the files that a recording was split into


def is_log(path: str | os.PathLike[str]) -> bool:
    """Return whether the file at ``path`` begins as a log of a known format does; only its beginning is read.

    False for a file that cannot be opened. A log may begin well and still be one that :func:`open_log` refuses.
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

    Of a folder, or a tar archive of one, plain or packed, the log in it is read: the one file that is a log, the files
    that ROS 2 split a recording into, a ring of sonars' two.
    ``topic`` names the sensor where there are several (``log.topics`` lists them); without it, the one with most scans
    is taken. ``tf`` names the topic of transforms, where there are several. ``progress`` is called with the share of
    the file that has been read, 0 … 1. Raises :class:`ReadError`, which names the place, for a file that is missing, no
    log, damaged or without scans, or a topic that it lacks, and :class:`LimitError` for one that is larger than
    ``limits`` allow.
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
    """Return the log at ``path`` with the sensors that ``selection`` names; otherwise as :func:`open_log`.

    ``also`` takes the messages of a recording in the same pass; of a text format it gets none.
    """
    return understood(_reading(Path(path), limits, also)(limits, progress, selection))


def odometry_records(
    path: str | os.PathLike[str], *, topic: str | None = None, limits: Limits = DEFAULT_LIMITS
) -> OdometryRecords | None:
    """Return the odometry messages of the log at ``path`` in the order of its records, around its scans.

    None for logs of other formats than CARMEN, in a folder or a tar archive, or without such messages. Raises as
    :func:`open_log`.
    """
    file = Path(path)
    if file.is_dir() or is_archive(file) or _kind_of(file) is not carmen.read_carmen:
        return None
    return carmen.read_carmen(file, limits, None, topic).odometry


def log_files(path: Path) -> list[Path]:
    """Return the files that are the log in a folder, or the file at ``path``, with all that belongs to them.

    That is what tells that several files are one log, and what a recorder that was killed left beside a database.
    Raises :class:`ReadError` where there is no log in a folder, or several.
    """
    files: list[Source] = [path]
    if path.is_dir():
        inside = _files_in(path, DEFAULT_LIMITS)
        files, _ = _one_log(inside, "folder")
        files = [*(file for file in inside if file.name == METADATA and len(files) > 1), *files]
    together = [part for file in files for part in (file, journal_of(file))]
    return [file for file in together if isinstance(file, Path)]


def parts_of(path: Path, limits: Limits = DEFAULT_LIMITS) -> tuple[Sequence[Source], Container | Reader]:
    """Return the files that are the log at ``path``, in their order, and the format that they are in.

    Raises :class:`ReadError` where there is no log, or several.
    """
    if path.is_dir():
        files, kind = _one_log(_files_in(path, limits), "folder")
    elif (archived := archive_members(path, limits)) is not None:
        files, kind = _one_log(archived[0], "archive")
    else:
        return [path], _kind_of(path)
    return in_order(files) if isinstance(kind, Container) else files, kind


def _reading(path: Path, limits: Limits, also: MessageSink | None = None) -> Reading:
    """Return what reads the log at ``path``; raise :class:`MapperError` where there is none, or several."""
    if path.is_dir():
        return _reading_together(_files_in(path, limits), "folder", path.name, also)
    if (archived := archive_members(path, limits)) is not None:
        files, notes = archived
        if notes and not files:
            raise ReadError("log.archive", "The tar archive is damaged, or ends, before the first file in it.")
        return _noting(notes, _reading_together(files, "archive", path.name, also))
    return partial(_reader(_kind_of(path), also), path)


def _files_in(folder: Path, limits: Limits) -> list[Source]:
    """Return a folder's own files, without hidden ones."""
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
    """Return what reads the one log that these files are."""
    logs, kind = _one_log(files, where)
    if len(logs) == 1:
        return partial(_reader(kind, also), logs[0])
    if isinstance(kind, Container):
        is_stated = any(file.name == METADATA for file in files)
        return partial(kind.read_split, logs, name, also=also, by_name=not is_stated)
    return partial(_one_sensor, partial(sonar.read_sonar, poses=logs[1]), logs[0])


def _one_log(files: Sequence[Source], where: str) -> tuple[list[Source], Container | Reader]:
    """Return which of the files are the one log among them, and of which kind; raise :class:`ReadError` for none."""
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
        raise min(why_not, key=lambda why: why.code == "log.empty")  # what is wrong with a file that holds something
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
    """Return why logs are not the parts of one recording; None where they are."""
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
    """Return ``reading`` with more notes on the log that it returns."""

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
    """Return the log of a format without transforms. Raises :class:`ReadError` where a topic of them is named."""
    if selection.tf is not None:
        raise ReadError("log.tf", f"The log has no transforms on {selection.tf!r:.80}: its format has none.")
    return reader(file, limits, progress, selection)


def _one_sensor(
    reader: Reader, file: Source, limits: Limits, progress: Progress | None, selection: Selection
) -> RobotLog:
    """Return the log of a format of one sensor. Raises :class:`ReadError` where a topic is named."""
    topic = selection.topics[0] if selection.topics else None
    return RobotLog.of_one(reader(file, limits, progress, topic))


def _kind_of(file: Source) -> Container | Reader:
    """Return the format that the file begins in; raise :class:`ReadError` where it begins in none."""
    head, broken = _head(file)
    for magic, container in BINARY:
        if head.startswith(magic):
            return container
    archive = archive_of(head)
    if zipped_document(head) is not None:
        raise not_a_log(head)
    if archive is not None:  # it may contain the lines of a log
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
        raise ReadError("log.truncated", f"The packed data {broken}, before the kind of log is known.")
    raise not_a_log(head)


def _head(file: Source) -> tuple[bytes, str | None]:
    """Return the log's first bytes, and what is wrong with its packed data where they are all that come out."""
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
