"""Request and plan of sessions that show a map in 3D."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import Field

from mapper.core.errors import ConfigError
from mapper.volume import OctreeFile
from server.sessions.kind import Kind, Plan, Resources, SessionRequest
from server.sessions.making import Making

if TYPE_CHECKING:
    from server.library.volume_pack import VolumeSource
    from server.sessions.hosting import ModelHost
    from server.sessions.model import SessionModel


class NewVolume(SessionRequest):
    """A session that shows a map in 3D: of a cloud, a depth folder, an octree, or the clouds of a recording."""

    kind: Literal["volume"]
    log: str = Field(max_length=200, description="Id of the log, as in /api/logs.")
    topic: str | None = Field(None, max_length=8000, description="Clouds of a recording that has several.")
    up: Literal["z", "-z", "y", "-y", "x", "-x"] = Field("z", description="The axis of the file that points up.")
    other: str | None = Field(None, max_length=200, description="Id of a log to compare the map with.")


def _turned(source: VolumeSource, up: str) -> VolumeSource:
    if up == "z":
        return source
    if isinstance(source, OctreeFile):
        raise ConfigError("volume.up", "The voxels of an octree cannot be turned: its z points up.")
    return source.with_up(up)


async def _plan(wanted: NewVolume, resources: Resources) -> Plan:
    library, making, visitor = resources.library, resources.making, resources.visitor
    try:
        making.watched = lambda: library.opening(wanted.log)
        source = await library.volume(visitor, wanted.log, wanted.topic)
        source = _turned(source, wanted.up)
        title = library.get(visitor, wanted.log).name
        other = None
        if wanted.other is not None:
            making.watched = lambda: library.opening(wanted.other or "")
            second = await library.volume(visitor, wanted.other)
            other = library.get(visitor, wanted.other).name, _turned(second, wanted.up)
    finally:
        making.watched = None

    def make(host: ModelHost, making: Making) -> SessionModel:  # noqa: ARG001 - as all plans
        from server.sessions.models.volume import VolumeModel  # noqa: PLC0415 - imported with the first one

        return VolumeModel(host, source, log_id=wanted.log, title=title, topic=wanted.topic, other=other)

    return Plan(make, name=wanted.name, playing=wanted.playing)


VOLUME = Kind(NewVolume, _plan)
