"""Request and plan of sessions that show a map in 3D."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from server.sessions.kind import Kind, Plan, Resources, SessionRequest
from server.sources.volume_plan import volume_plan


class NewVolume(SessionRequest):
    """A session that shows a map in 3D: of a cloud, a depth folder, an octree, or the clouds of a recording."""

    kind: Literal["volume"]
    log: str = Field(max_length=200, description="Id of the log, as in /api/logs.")
    topic: str | None = Field(None, max_length=8000, description="Clouds of a recording that has several.")
    up: Literal["z", "-z", "y", "-y", "x", "-x"] | None = Field(
        None, description="The axis of the file that points up; by default what the poses of depth images say, else z."
    )
    other: str | None = Field(None, max_length=200, description="Id of a log to compare the map with.")


async def _plan(wanted: NewVolume, resources: Resources) -> Plan:
    return await volume_plan(
        resources, wanted.log, wanted.topic, up=wanted.up, other=wanted.other, name=wanted.name, playing=wanted.playing
    )


VOLUME = Kind(NewVolume, _plan)
