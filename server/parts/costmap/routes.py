"""``/api/sessions/{id}/costmap/…``: the costs of a session as files, and the robot's footprint."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field, FiniteFloat

from mapper.core.errors import MapperError
from mapper.io import maps
from server.downloads import Content, Download
from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.routes.maps import requester_of, stem_of
from server.http.services import FileDownloads, Sessions
from server.parts.costmap.messages import CostmapCommand
from server.sessions.parts import Costed, FootprintAnswer

if TYPE_CHECKING:
    from server.sessions import SessionHost

router = APIRouter(prefix="/api/sessions", tags=["sessions"])


class FootprintOfCostmap(BaseModel, extra="forbid"):
    """The outline of the robot."""

    footprint: list[tuple[FiniteFloat, FiniteFloat]] = Field(
        description="Corners [x, y] in the robot's frame, metres, without padding: 3 to 24, around (0, 0)."
    )


_NAMES = ("costmap.pgm", "costmap.yaml", "costmap.mcap", "keepout.pgm", "keepout.yaml", "speed.pgm", "speed.yaml")
_UNPAINTED = {"keepout": "No keepout zone is painted.", "speed": "No speed limit is painted."}


@router.get("/{session_id}/costmap/footprint")
@guests_may(GuestRight.LINKED_SESSION)
async def footprint(sessions: Sessions, session_id: str) -> FootprintAnswer:
    """Return the footprint of the session's costmap, with the inscribed and circumscribed radius of the padded one."""
    return await _footprint(sessions.get(session_id))


@router.put("/{session_id}/costmap/footprint")
@guests_may(GuestRight.LINKED_SESSION)
async def change_footprint(sessions: Sessions, session_id: str, body: FootprintOfCostmap) -> FootprintAnswer:
    """Change the footprint of the session's costmap; answer as GET does."""
    from server.parts.costmap.parameters import footprint_of  # noqa: PLC0415 - with the first session

    session = sessions.get(session_id)
    await _footprint(session)  # without a costmap, the command would begin one
    footprint_of(body.footprint)
    session.enqueue(CostmapCommand(footprint=body.footprint))
    return await _footprint(session)


async def _footprint(session: SessionHost) -> FootprintAnswer:
    await session.carried_out()
    async with session.locked():
        costed = session.model.find(Costed)
        present = None if costed is None else costed.present_footprint()
    if present is None:
        raise MapperError("costmap.off", "This session has no costmap with a footprint: begin one first.")
    return present


@router.get("/{session_id}/costmap/{name}", **file_answer("application/octet-stream"))
@guests_may(GuestRight.LINKED_SESSION)
async def file(request: Request, sessions: Sessions, downloads: FileDownloads, session_id: str, name: str) -> Response:
    """Return the session's costs as a file.

    ``costmap.pgm`` has the costs 0 to 255 as grey values, described by ``costmap.yaml``. ``costmap.mcap`` contains the
    messages nav2_msgs/Costmap and nav_msgs/OccupancyGrid. ``keepout.pgm`` and ``keepout.yaml`` are the painted zones as
    a mask, ``speed.pgm`` and ``speed.yaml`` the painted speed limits.
    """
    session = sessions.get(session_id)
    if name not in _NAMES:
        raise MapperError("costmap.no_file", f"There is no file {name!r:.80}: there are {', '.join(_NAMES)}.")
    kind, _, ending = name.partition(".")
    # The masks are named as in the Nav2 parameter file of the session.
    stem = f"{stem_of(session)}_{kind}" if kind == "costmap" else kind

    async def make() -> Content:
        async with session.settled():
            costed = session.model.find(Costed)
            costs = None if costed is None else costed.present_costs()
            mask = None if costed is None else costed.present_masks().get(kind)
        if costs is None:
            raise MapperError("costmap.off", "This session has no costmap: begin it first.")
        if kind in _UNPAINTED and mask is None:
            raise MapperError("costmap.no_zones", _UNPAINTED[kind])

        def work(check: Callable[[], None]) -> bytes:  # noqa: ARG001 - as all downloads
            from mapper.costmap.files import costmap_mcap, costmap_pgm, mask_pgm  # noqa: PLC0415 - few take costs

            if ending == "yaml":
                return maps.yaml_text(costs.geometry, f"{stem}.pgm", "raw", frame=costs.frame).encode()
            if ending == "mcap":
                return costmap_mcap(costs)
            return costmap_pgm(costs.costs) if mask is None else mask_pgm(mask)

        data = await downloads.run(work)
        return Content(f"{stem}.{ending}", iter([data]), len(data))

    return Download(downloads, requester_of(request, session), make, "application/octet-stream")
