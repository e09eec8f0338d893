"""Series that are not topics of a recording, but computed from the log's scans, its map and its pose graph."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mapper.evaluation import Comparison, ComparisonOptions, compare_trajectories
from mapper.io.contents.model import Column, Series
from mapper.io.contents.scan_series import plot_stamps, scan_columns, scan_series
from mapper.sensors.timed_poses import TimedPoses
from server.http.session_access import part_of_log
from server.imports import imported
from server.sessions.parts import Graphed, GraphSource, Recording

if TYPE_CHECKING:
    from mapper.sensors.scan import ScanLog
    from server.library.library import Library
    from server.sessions import SessionHost

#: Names used like topics; ROS topics contain no parentheses.
MAP, SLAM, ERRORS, SCANS = COMPUTED = ("(map)", "(slam)", "(errors)", "(scans)")

_OF_PATHS = (
    Column("relative error distance", "m", "relative error distance"),
    Column("relative error angle", "rad", "relative error angle"),
)


def recording_of(session: SessionHost) -> Recording:
    """Return the log of a session. Raises :class:`MapperError` for a simulation."""
    return part_of_log(session, Recording, "Only the recording of a log has series to plot, not a live world.")


def errors_between(log: ScanLog, reference: str, estimate: str, options: ComparisonOptions | None = None) -> Comparison:
    """Return the errors of a log's trajectory against another one, at the times of its scans' plots.

    Raises like :func:`mapper.evaluation.compare_trajectories`.
    """
    first, other = (TimedPoses(plot_stamps(log), log.trajectory(name).poses) for name in (reference, estimate))
    return compare_trajectories(first, other, options)


def _relative_errors(log: ScanLog, reference: str, estimate: str) -> Series:
    """Return the relative errors over 1 m of ``estimate``, each at the end of its metre."""
    errors = errors_between(log, reference, estimate)
    distance, angle = errors.relative_translation, errors.relative_rotation
    order = np.argsort(distance.stamps_ns, kind="stable")
    values = np.column_stack([distance.errors, angle.errors])[order]
    return Series("errors", "trajectories", _OF_PATHS, distance.stamps_ns[order], values)


def graph_source(library: Library, owner: str, log_id: str) -> GraphSource:
    """Return the function that reads the file of a trajectory's pose graph; it returns None if there is none."""
    added = library.trajectories

    async def source(trajectory: str) -> bytes | None:
        known = any(candidate.name == trajectory for candidate in added.of(owner, log_id))
        return await added.graph(owner, log_id, trajectory) if known else None

    return source


async def computed_fields(library: Library, session: SessionHost, owner: str) -> Mapping[str, Sequence[str]]:
    """Return the names of the computable series of a session's log, by :data:`COMPUTED`."""
    await imported("mapper.replay.map_series", "mapper.slam.residuals")
    from mapper.replay.map_series import COLUMNS as OF_MAP  # noqa: PLC0415 - SciPy and SLAM, which few sessions need
    from mapper.slam.residuals import COLUMNS as OF_GRAPH  # noqa: PLC0415

    recording = recording_of(session)
    added = library.trajectories.of(owner, recording.log_id)
    has_graph = any(trajectory.name == recording.trajectory and trajectory.has_graph for trajectory in added)
    of_scans = scan_columns(recording.log, recording.trajectory)
    fields = {
        MAP: OF_MAP,
        **({SLAM: OF_GRAPH} if has_graph else {}),
        **({ERRORS: _OF_PATHS} if _compared(recording) else {}),
        SCANS: of_scans,
    }
    return {name: [column.label for column in columns] for name, columns in fields.items()}


def _compared(recording: Recording) -> tuple[str, str] | None:
    """Return the two trajectories whose errors are shown first; None for a log with one path."""
    pair = recording.compared()
    return None if pair is None or recording.same_paths().get(pair[1]) == pair[0] else pair


async def computed_series(library: Library, session: SessionHost, owner: str, name: str) -> Series | float:
    """Return a series of :data:`COMPUTED`, or its completed share while it is computed.

    Raises like :func:`mapper.replay.map_series.map_series` and :func:`errors_between`, and :class:`MapperError` for a
    trajectory without a graph.
    """
    recording = recording_of(session)
    if name == MAP:
        return recording.map_series()
    graph = session.model.find(Graphed) if name == SLAM else None
    if graph is not None:
        return await graph.residuals(graph_source(library, owner, recording.log_id))
    pair = _compared(recording) if name == ERRORS else None
    if pair is not None:
        return await asyncio.to_thread(_relative_errors, recording.log, *pair)
    return await asyncio.to_thread(scan_series, recording.log, recording.trajectory)
