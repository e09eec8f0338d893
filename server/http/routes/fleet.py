"""``/api/fleet``: read, examine and map all logs of the library with several workers."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field

from mapper.mapping.parameters import MappingConfig
from server.http.services import Logs, Visitor
from server.library.library import Library
from server.library.logs.records import Record
from server.library.processing.fleet import fleet_jobs
from server.library.processing.fleet.fleet_jobs import FleetState

router = APIRouter(prefix="/api/fleet", tags=["fleet"])


Name = Annotated[str, Field(min_length=1, max_length=255)]


class FleetOptions(BaseModel, extra="forbid"):
    """How each log is read and mapped, with the options of ``gridbloom fleet``; metres, radians, seconds."""

    topic: Name | None = Field(None, description="The sensor of each log; null: the one with most scans.")
    tf: Name | None = Field(None, description="The topic of transforms, where there are several.")
    trajectory: Name | None = Field(None, description="The poses; null: each log’s first.")
    mount_x: float = 0.0
    mount_y: float = 0.0
    mount_yaw: float = 0.0
    mount_upside_down: bool = False
    time_offset: float = 0.0

    def checked(self) -> fleet_jobs.FleetRequest:
        """Return the request of the jobs. Raises :class:`mapper.core.errors.ConfigError`, naming the parameter."""
        values = self.model_dump(exclude={"topic", "tf", "trajectory"})
        mapping = {name: value for name, value in values.items() if value}
        MappingConfig().with_values(mapping)
        return fleet_jobs.FleetRequest(self.topic, self.tf, self.trajectory, mapping)


class FleetRequest(BaseModel, extra="forbid"):
    """Logs to map."""

    again: bool = Field(False, description="Map the logs again that failed.")
    options: FleetOptions | None = Field(
        None, description="Map also those again that were mapped, or failed, with other options."
    )


@dataclass(frozen=True, slots=True)
class QueuedLogs:
    """Number of queued logs."""

    queued: int


def _logs(library: Library, visitor: str) -> Sequence[Record]:
    """Return the logs that can be mapped, without the maps, costmaps and clouds among them."""
    return [
        log
        for log in library.files(visitor)
        if (summary := log.summary) is None or not (summary.map or summary.costmaps or summary.clouds)
    ]


@router.get("")
async def state(
    library: Logs,
    visitor: Visitor,
    since: Annotated[int, Query(ge=0, description="Revision from an earlier answer; 0: all logs.")] = 0,
) -> FleetState:
    """Return how many logs of this visitor and of the shared folder are mapped, and those that changed."""
    if since == 0:
        await library.list(visitor)  # reads the folder
    pictured = await asyncio.to_thread(library.pictured)
    return library.fleet.state(_logs(library, visitor), since, pictured)


@router.post("", status_code=202)
async def begin(library: Logs, visitor: Visitor, body: FleetRequest) -> QueuedLogs:
    """Queue all unmapped logs; return their number. Each is mapped once for everyone who may open it."""
    await library.list(visitor)
    request = None if body.options is None else body.options.checked()
    return QueuedLogs(await library.fleet.begin(_logs(library, visitor), again=body.again, request=request))


@router.delete("", status_code=204)
async def stop(library: Logs, visitor: Visitor) -> None:
    """Stop mapping the waiting logs. Results so far are kept."""
    await library.fleet.stop(_logs(library, visitor))
