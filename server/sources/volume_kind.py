"""Request and plan of sessions that show a 3D map."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import Field

from mapper.core.errors import ConfigError
from mapper.volume import OctreeFile
from server.sessions.kind import Kind, Plan, Resources, SessionRequest
from server.sessions.making import Making

if TYPE_CHECKING:
    from server.library.packs.volume import VolumeSource
    from server.sessions.hosting import ModelHost
    from server.sessions.model import SessionModel


Z = "z"  #: the axis that points up by default


def _turned(source: VolumeSource, up: str) -> VolumeSource:
    if up == Z:
        return source
    if isinstance(source, OctreeFile):
        raise ConfigError("volume.up", "The voxels of an octree cannot be turned: its z points up.")
    return source.with_up(up)


async def volume_plan(
    resources: Resources, log: str, topic: str | None, *, up: str | None = None, other: str | None = None,
    name: str | None = None, playing: bool = True,
) -> Plan:  # fmt: skip
    """Return the plan of a session on the log with the id ``log``; the other arguments are those of the request.

    If ``up`` is None, it is the axis that the poses of depth images define, or z. Raises like :meth:`Library.volume`,
    and :class:`ConfigError` for an octree with another axis.
    """
    library, making, visitor = resources.library, resources.making, resources.visitor
    second: VolumeSource | None = None
    try:
        making.watched = lambda: library.opening(log)
        source = await library.volume(visitor, log, topic)
        title = library.get(visitor, log).name
        if other is not None:
            making.watched = lambda: library.opening(other)
            second = await library.volume(visitor, other)
    finally:
        making.watched = None
    if up is None:  # both maps are in one frame, and voxels cannot be rotated
        up = Z if isinstance(source, OctreeFile) or isinstance(second, OctreeFile) else source.first_up
    axis, shown = up, _turned(source, up)
    compared = None if other is None or second is None else (library.get(visitor, other).name, _turned(second, up))

    def make(host: ModelHost, making: Making) -> SessionModel:  # noqa: ARG001 - as all plans
        from server.sources.volume import VolumeModel  # noqa: PLC0415 - imported with the first one

        return VolumeModel(host, shown, log_id=log, title=title, topic=topic, other=compared, up=axis)

    return Plan(make, name=name, playing=playing)


class NewVolume(SessionRequest):
    """A session that shows a 3D map of a cloud, a depth folder, an octree, or the clouds of a recording."""

    kind: Literal["volume"]
    log: str = Field(max_length=200, description="Id of the log, as in /api/logs.")
    topic: str | None = Field(None, max_length=8000, description="Clouds of a recording that has several.")
    up: Literal["z", "-z", "y", "-y", "x", "-x"] | None = Field(
        None, description="The axis of the file that points up; by default what the poses of depth images say, else z."
    )
    other: str | None = Field(None, max_length=200, description="Id of a log to compare the map with.")


async def _plan(request: NewVolume, resources: Resources) -> Plan:
    return await volume_plan(
        resources,
        request.log,
        request.topic,
        up=request.up,
        other=request.other,
        name=request.name,
        playing=request.playing,
    )


VOLUME = Kind(NewVolume, _plan)
