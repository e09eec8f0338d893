"""``/api/sessions/{id}/costmap/terrain``: the upload whose terrain a log's costmap uses."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from pydantic import BaseModel, Field

from mapper.core.errors import ConfigError, LimitError
from server.downloads import Downloads
from server.http.clients import while_connected
from server.http.services import FileDownloads, Logs, Sessions
from server.http.session_access import writable_session
from server.library.library import Library
from server.library.packs.reference_map import ChosenMap
from server.sessions.commands import UseCosts

if TYPE_CHECKING:
    from server.sessions.parts import UploadedCosts

MOST_CELLS = 1 << 24  #: of a terrain map

router = APIRouter(prefix="/api/sessions", tags=["sessions"])


class TerrainOfUpload(BaseModel, extra="forbid"):
    """A terrain among the visitor's uploads."""

    log: str | None = Field(max_length=200, description="Id of the cloud or map, as in /api/logs; null: none.")


async def uploaded_terrain(library: Library, downloads: Downloads, owner: str, log_id: str) -> UploadedCosts:
    """Return the terrain of a map of ``owner``, or of a cloud, whose points are assessed on a worker thread.

    Raises :class:`mapper.core.errors.MapperError` for other logs, for a map with too many cells, and for a cloud that
    is unsuitable.
    """
    from mapper.volume.scans.scan_sequence import ScanSequence  # noqa: PLC0415 - few sessions have a terrain
    from server.parts.terrain.costs import TerrainMap, TerrainOfCloud  # noqa: PLC0415
    from server.parts.volume.cloud_points import CloudPoints  # noqa: PLC0415
    from server.parts.volume.start import bounds_of  # noqa: PLC0415

    reference = await library.reference_map(owner, log_id)
    if reference is not None:
        if reference.values.size > MOST_CELLS:
            raise LimitError(
                "terrain.cells", f"The map has {reference.values.size:,} cells; at most {MOST_CELLS:,} are used."
            )
        return TerrainMap(log_id, reference)
    record = library.get(owner, log_id)
    if record.summary is None or not record.summary.clouds:
        message = "This is a log: choose a cloud, or the map that gridbloom terrain has written."
        raise ConfigError("terrain.no_map", message)
    source = await library.volume(owner, log_id)
    if not isinstance(source, ScanSequence):
        raise ConfigError("terrain.octree", "An octree has voxels and no points: choose a cloud.")

    def assess(check: Callable[[], None]) -> TerrainOfCloud:
        cloud = CloudPoints(source, *bounds_of(source))
        return TerrainOfCloud.of(log_id, record.name, cloud, source.offset, lambda _: check())

    return await downloads.run(assess, takes_long=True)


@router.put("/{session_id}/costmap/terrain")
async def terrain(
    request: Request,
    library: Logs,
    sessions: Sessions,
    downloads: FileDownloads,
    session_id: str,
    body: TerrainOfUpload,
) -> ChosenMap:
    """Choose the terrain layer of a log's costmap: a cloud of the library, or a map from ``gridbloom terrain``.

    The patches of a cloud are assessed. Free cells of a map are safe, occupied ones unsafe. Either must be in the frame
    of the log's poses. ``map`` of the answer is the grid of the terrain; for a cloud it includes the number of patches
    of each class.
    """
    of_log = writable_session(sessions, session_id)
    terrain = None
    if body.log is not None:
        terrain = await while_connected(request, uploaded_terrain(library, downloads, of_log.owner, body.log))
    of_log.session.enqueue(UseCosts(terrain))
    return ChosenMap(None if terrain is None else terrain.public())
