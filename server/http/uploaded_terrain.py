"""The upload that is the terrain of a log's costmap."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from mapper.core.errors import ConfigError, LimitError
from server.downloads import Downloads
from server.library.library import Library

if TYPE_CHECKING:
    from server.sessions.parts import UploadedCosts

MOST_CELLS = 1 << 24  #: of a map of a terrain


async def uploaded_terrain(library: Library, downloads: Downloads, owner: str, log_id: str) -> UploadedCosts:
    """Return the terrain of a map of ``owner``, or of a cloud, whose points are assessed on a worker thread.

    Raises :class:`mapper.core.errors.MapperError` for other logs, for a map with too many cells, and for a cloud of
    which no terrain can be made.
    """
    from mapper.volume.scans.scan_sequence import ScanSequence  # noqa: PLC0415 - few sessions have a terrain
    from server.parts.terrain.costs import TerrainMap, TerrainOfCloud  # noqa: PLC0415
    from server.parts.volume.cloud_points import CloudPoints  # noqa: PLC0415
    from server.parts.volume.start import bounds_of  # noqa: PLC0415

    given = await library.given_map(owner, log_id)
    if given is not None:
        if given.values.size > MOST_CELLS:
            raise LimitError(
                "terrain.cells", f"The map has {given.values.size:,} cells; at most {MOST_CELLS:,} are used."
            )
        return TerrainMap(log_id, given)
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
