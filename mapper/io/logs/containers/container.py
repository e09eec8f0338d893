"""Recording containers, and the log of one file or of all files of a split recording."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.archives.archive import Source
from mapper.io.logs.archives.unpacking import Progress, part_of
from mapper.io.logs.recording.recorded_streams import Streams, streams_of, with_streams
from mapper.io.logs.recording.recording import Recording
from mapper.io.logs.recording.sink import BothSinks, MessageSink
from mapper.io.logs.selection import Selection
from mapper.sensors.robot_log import RobotLog

MAX_NOTES = 20
NO_SENSOR = "\0"  #: a name that no topic has


@dataclass(frozen=True, slots=True)
class Container:
    """A container format: its name, and a function that passes on the messages of one file."""

    form: str
    take: Callable[[Source, MessageSink, Limits, Progress | None], None]

    def read(
        self,
        file: Source,
        limits: Limits,
        progress: Progress | None,
        selection: Selection,
        *,
        also: MessageSink | None = None,
    ) -> RobotLog:
        """Return the recording in ``file`` as the log of the selected sensors; see :class:`Recording`.

        ``also`` receives the messages in the same pass. For a cut or damaged file, this is the readable part, with
        notes on what is missing. Raises :class:`ReadError` if there is no scan, and :class:`LimitError`.
        """
        recording = Recording(limits, selection)
        self.take(file, _with(recording, also), limits, progress)
        return with_streams(recording.robot_log(file.name, self.form), [file], self.take, recording.parts)

    def read_split(
        self,
        files: Sequence[Source],
        name: str,
        limits: Limits,
        progress: Progress | None,
        selection: Selection,
        *,
        also: MessageSink | None = None,
        by_name: bool = False,
    ) -> RobotLog:
        """Return the recording ``name``, split into ``files`` in the order of their numbers, as one log.

        Unreadable files are skipped, with a note. Raises the errors of :meth:`read`; with ``by_name``, when only their
        names indicate that they belong together, also if they have no topic in common.
        """
        recording = Recording(limits, selection)
        sink = _with(recording, also)
        files = in_order(files)
        why = ", as their names say" if by_name else ""
        recording.notes.append(f"{len(files)} files are read as one recording{why}.{_missing(files)}")
        common: set[str] = set()
        for done, file in enumerate(files):
            before = len(recording.notes)
            try:
                self.take(file, sink, limits, part_of(progress, done, len(files)))
            except LimitError:
                raise
            except ReadError as error:
                recording.notes.append(f"It is left out: {error.message}")
            new_notes = recording.notes[before : max(before, MAX_NOTES)]
            recording.notes[before:] = [f"{file.name}: {note}" for note in new_notes]
            topics = recording.topics_of_file
            if by_name and common and topics and not common & topics:
                raise ReadError(
                    "log.folder",
                    f"{files[0].name!r:.80} and {file.name!r:.80} are named as parts of one recording, and have no "
                    "topic in common: open one of them.",
                )
            common |= topics
            sink.next_file()
            if progress is not None:
                progress((done + 1) / len(files))
        log = recording.robot_log(name, f"{self.form}, {len(files)} files")
        return with_streams(log, files, self.take, recording.parts)

    def streams(
        self,
        files: Sequence[Source],
        limits: Limits,
        progress: Progress | None,
        *,
        tf: str | None = None,
        trajectory: str | None = None,
        also: MessageSink | None = None,
    ) -> Streams:
        """Return the point clouds, IMUs and images of a recording by topic; only poses are read now.

        ``tf`` names the topic of transforms if there are several, ``trajectory`` the poses of clouds; ``also`` receives
        the messages in the same pass. Raises :class:`ReadError` if the recording has no transforms on that topic.
        """
        recording = Recording(limits, Selection((NO_SENSOR,), tf=tf))
        sink = _with(recording, also)
        for done, file in enumerate(files):
            self.take(file, sink, limits, part_of(progress, done, len(files)))
            sink.next_file()
        recording.finish()
        return streams_of(files, self.take, recording.parts, trajectory)


def _with(recording: Recording, also: MessageSink | None) -> MessageSink:
    return recording if also is None else BothSinks(recording, also)


def in_order(files: Sequence[Source]) -> list[Source]:
    """Return the files of a split recording in the order of the numbers in their names."""
    return sorted(files, key=lambda file: _numbered(file.name))


_BEGUN = re.compile(r"\d{4}(?:-\d{2}){5}\Z")


def are_parts_by_name(names: Sequence[str]) -> bool:
    """Return whether files are numbered from 0 and otherwise equally named, like the parts of a rosbag2 recording.

    The rosbag of ROS 1 adds the start time of each part to its name, ``run_2024-01-31-12-00-05_1.bag``, and ``.active``
    if it was not closed.
    """
    closed = [name.removesuffix(".active") for name in names]
    matches = [re.fullmatch(r"(.+)_([0-9]{1,9})(\.[a-z0-9.]+)", name) for name in closed]
    parts = {(_BEGUN.sub("", match[1]), match[3]) for match in matches if match}
    numbers = {int(match[2]) for match in matches if match}
    return None not in matches and len(parts) == 1 and len(numbers) == len(names) and min(numbers) == 0


def _numbered(name: str) -> list[int | str]:
    """Return a sort key for names with numeric order: ``run_10`` comes after ``run_2``."""
    return [int(part) if at % 2 else part for at, part in enumerate(re.split(r"([0-9]{1,18})", name))]


def _missing(files: Sequence[Source]) -> str:
    """Return a sentence on the first missing number between two files, or nothing."""
    numbers = [int(match[1]) for file in files if (match := re.search(r"_([0-9]{1,9})\.", file.name))]
    pairs = pairwise(numbers)
    gap = next((pair for pair in pairs if pair[1] > pair[0] + 1), None) if len(numbers) == len(files) else None
    return f" Between number {gap[0]} and number {gap[1]} files are missing." if gap else ""
