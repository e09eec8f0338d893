"""Reading a log in a job process: the contents of the file, its pack and its picture."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mapper.core.array_types import UInt8Array
from mapper.core.errors import LimitError, ReadError
from mapper.io import logs
from mapper.io.logs.summary import LogSummary, summarise
from mapper.sensors.planar.options import PlanarCut
from server.jobs.process import BoundedJob, JobLimits, note_progress
from server.library.packs.costmaps import costmap_codes, summarise_costmaps, write_costmap_pack
from server.library.packs.log import write_pack
from server.library.packs.map_files import is_map, read_map


@dataclass(frozen=True, slots=True)
class Job(BoundedJob[LogSummary]):
    """Read the log file ``source``, pack it into ``pack`` if there is one; ``topic`` names one of several sensors.

    A picture of its map is drawn into ``picture`` if there is one.
    """

    source: str
    pack: str | None
    topic: str | None
    limits: JobLimits
    cut: PlanarCut | None = None  #: options for cutting scans out of clouds and depth images; None: the defaults
    picture: str | None = None
    volume: bool = False  #: whether the clouds are read for a 3D map instead of the scans
    folder: str | None = None  #: folder for temporary files; None: the system's folder

    def compute(self) -> LogSummary:
        """Return the contents of the log. Raises :class:`ReadError` or :class:`LimitError`."""
        from mapper.io.logs.selection import ALL_SENSORS, Selection  # noqa: PLC0415

        tempfile.tempdir = self.folder  # of this process, which only reads; readers of packed databases write there too
        if self.volume:
            return _read_volume(self)
        if self.topic is None and is_map(Path(self.source)):
            return _read_map(self)
        if self.topic is None and _holds_volume(self):
            return _read_volume(self)
        selection = ALL_SENSORS if self.topic is None else Selection.of(self.topic, self.cut)
        try:
            log = logs.open_robot_log(Path(self.source), selection=selection, progress=note_progress)
        except ReadError as error:
            if error.code != "log.no_scans" or self.topic is not None:
                raise
            return _read_others(self, error)
        note_progress(1.0)  # a cancelled job ends here and leaves no pack
        _pack(self, lambda path: write_pack(log, path))
        if self.picture is not None:
            from server.library.packs.picture import write_picture  # noqa: PLC0415 - Pillow is loaded only for pictures

            with contextlib.suppress(OSError, ValueError, MemoryError):  # a log without a picture can still be opened
                write_picture(log.first, Path(self.picture))
        return summarise(log.first)


def _holds_volume(job: Job) -> bool:
    from server.library.packs.volume_files import holds_volume  # noqa: PLC0415 - only the process that reads needs the readers

    return holds_volume(Path(job.source))


def _read_volume(job: Job) -> LogSummary:
    """Read the source of a 3D map."""
    from server.library.packs.volume_files import read_volume, store_volume, summarise_volume  # noqa: PLC0415

    source = Path(job.source)
    volume = read_volume(source, job.topic, note_progress)
    summary = summarise_volume(volume, source.name)
    note_progress(1.0)
    store_volume(
        volume, None if job.pack is None else Path(job.pack), None if job.picture is None else Path(job.picture)
    )
    return summary


def _read_others(job: Job, no_scans: ReadError) -> LogSummary:
    """Read the clouds or costmaps of a recording without scans; raise ``no_scans`` if it has neither."""
    try:
        return _read_volume(job)
    except ReadError as error:
        if error.code == "clouds.none":
            return _read_costmaps(job, no_scans)
        raise


def _read_costmaps(job: Job, no_scans: ReadError) -> LogSummary:
    """Read the costmaps of a recording without scans; raise ``no_scans`` if it has none."""
    from mapper.io.costmaps import open_costmaps  # noqa: PLC0415 - few logs have them

    try:
        streams = open_costmaps(Path(job.source), progress=note_progress)
    except ReadError:
        raise no_scans from None
    note_progress(1.0)
    _pack(job, lambda path: write_costmap_pack(streams, path))
    _draw(job, lambda: costmap_codes(streams))
    return summarise_costmaps(streams, Path(job.source).name)


def _read_map(job: Job) -> LogSummary:
    """Read map files."""
    from server.library.packs.map import map_codes, summarise_map  # noqa: PLC0415 - few uploads are maps

    reference = read_map(Path(job.source), "map", Path(tempfile.gettempdir()))
    note_progress(1.0)
    _pack(job, reference.write)
    _draw(job, lambda: map_codes(reference))
    return summarise_map(reference)


def _pack(job: Job, write: Callable[[Path], None]) -> None:
    """Write the pack of a job that has one. Raises :class:`LimitError` if there is no room for it."""
    if job.pack is not None:
        try:
            write(Path(job.pack))
        except OSError as error:
            message = "What was read of the log could not be stored; the server’s disk may be full."
            raise LimitError("log.storage", message) from error


def _draw(job: Job, codes: Callable[[], UInt8Array]) -> None:
    """Draw the picture of a job that has one; the log can be opened without it."""
    if job.picture is not None:
        from server.library.packs.picture import write_codes  # noqa: PLC0415 - Pillow is loaded only for pictures

        with contextlib.suppress(OSError, ValueError, MemoryError):
            write_codes(codes(), Path(job.picture))
