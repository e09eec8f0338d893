"""Series that no topic of a recording has: they are computed of the log's scans, its map and its pose graph."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from mapper.io.contents.scan_series import scan_columns, scan_series
from server.http.session_access import part_of_log
from server.imports import imported
from server.sessions.parts import Graphed, GraphSource, Recording

if TYPE_CHECKING:
    from mapper.io.contents.model import Series
    from server.library.library import Library
    from server.sessions import SessionHost

#: Names in place of topics; no topic of ROS has parentheses.
MAP, SLAM, SCANS = COMPUTED = ("(map)", "(slam)", "(scans)")


def recording_of(session: SessionHost) -> Recording:
    """Return the log of a session. Raises :class:`MapperError` for a live world."""
    return part_of_log(session, Recording, "Only the recording of a log has series to plot, not a live world.")


def graph_source(library: Library, owner: str, log_id: str) -> GraphSource:
    """Return the function that reads the file of a trajectory's pose graph; None for one without."""
    added = library.trajectories

    async def source(trajectory: str) -> bytes | None:
        known = any(one.name == trajectory for one in added.of(owner, log_id))
        return await added.graph(owner, log_id, trajectory) if known else None

    return source


async def computed_fields(library: Library, session: SessionHost, owner: str) -> Mapping[str, Sequence[str]]:
    """Return the names of the series that can be computed of a session's log, by :data:`COMPUTED`."""
    await imported("mapper.replay.map_series", "mapper.slam.residuals")
    from mapper.replay.map_series import COLUMNS as OF_MAP  # noqa: PLC0415 - SciPy and SLAM, which few sessions need
    from mapper.slam.residuals import COLUMNS as OF_GRAPH  # noqa: PLC0415

    recording = recording_of(session)
    added = library.trajectories.of(owner, recording.log_id)
    has_graph = any(one.name == recording.trajectory and one.has_graph for one in added)
    of_scans = scan_columns(recording.log, recording.trajectory)
    found = {MAP: OF_MAP, **({SLAM: OF_GRAPH} if has_graph else {}), SCANS: of_scans}
    return {name: [column.label for column in columns] for name, columns in found.items()}


async def computed_series(library: Library, session: SessionHost, owner: str, name: str) -> Series | float:
    """Return a series of :data:`COMPUTED`, or the share that is done while it is computed.

    Raises as :func:`mapper.replay.map_series.map_series`, and :class:`MapperError` for a trajectory without a graph.
    """
    recording = recording_of(session)
    if name == MAP:
        return recording.map_series()
    graph = session.model.find(Graphed) if name == SLAM else None
    if graph is not None:
        return await graph.residuals(graph_source(library, owner, recording.log_id))
    return await asyncio.to_thread(scan_series, recording.log, recording.trajectory)
