"""Request and plan of log sessions."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from mapper.sensors.scan import ScanLog
from server.sessions.kind import Kind, Plan, Resources, SessionRequest
from server.sessions.making import Making
from server.sessions.view import LogView
from server.sources.volume_kind import volume_plan

if TYPE_CHECKING:
    from mapper.io.costmaps import CostmapStream
    from server.library.packs.reference_map import ReferenceMap
    from server.sessions.hosting import ModelHost
    from server.sessions.model import SessionModel


class NewLog(SessionRequest):
    """A session of a log."""

    kind: Literal["log"]
    playing: bool = Field(True, description="Whether the log plays from the start.")
    whole: bool = Field(False, description="Whether the log is paused at its end, with the map of all scans.")
    log: str = Field(max_length=200, description="Id of the log, as in /api/logs.")
    topic: str | None = Field(
        None,
        max_length=8000,
        description="Sensor of the log, if it has several; ' + ' between several makes one map of them.",
    )
    trajectory: str | None = Field(None, max_length=200, description="Trajectory of the log to map with.")
    cut: dict[str, float] | None = Field(
        None,
        max_length=20,
        description="How scans are cut out of clouds and depth images, see /api/parameters; else as by default.",
    )


def log_plan(
    log: ScanLog,
    *,
    log_id: str = "",
    title: str = "",
    view: LogView | None = None,
    playing: bool = True,
    name: str | None = None,
) -> Plan:
    """Return the plan of a session that shows ``view`` of a log. Creating it raises like the mapper.

    If the view has many scans, the session computes the map and shows it meanwhile.
    """
    shown = view or LogView()

    def make(host: ModelHost, making: Making) -> SessionModel:
        from server.sources.log import LogModel  # noqa: PLC0415 - imported with the first session
        from server.sources.log_recording import first_replay  # noqa: PLC0415

        making.watched = lambda: ("Preparing the map", None)
        replay = first_replay(log, shown, host.limits(), making.may_continue)
        return LogModel(host, replay, shown, log_id=log_id, title=title)

    return Plan(make, logs=(log,), name=name, playing=playing)


async def _plan(request: NewLog, resources: Resources) -> Plan:
    library, making = resources.library, resources.making
    view = LogView(request.topic, request.trajectory, cut=request.cut)
    making.watched = lambda: library.opening(request.log)
    try:
        costmaps = await library.costmaps(resources.visitor, request.log)
        if costmaps is not None:
            title = library.get(resources.visitor, request.log).name
            view = LogView(trajectory=request.topic)
            return costmaps_plan(costmaps, log_id=request.log, title=title, view=view, playing=request.playing)
        reference = await library.reference_map(resources.visitor, request.log)
        if reference is not None:
            return _map_plan(reference)
        summary = library.get(resources.visitor, request.log).summary
        if summary is not None and summary.clouds:
            return await volume_plan(resources, request.log, request.topic, name=request.name, playing=request.playing)
        log = await library.load(resources.visitor, request.log, request.topic, view.planar_cut)
    finally:
        making.watched = None
    title = resources.library.get(resources.visitor, request.log).name
    if request.whole:
        view = replace(view, index=log.n_scans)
    return log_plan(log, log_id=request.log, title=title, view=view, playing=request.playing and not request.whole)


def costmaps_plan(
    streams: dict[str, CostmapStream], *, log_id: str, title: str, view: LogView, playing: bool, name: str | None = None
) -> Plan:
    """Return the plan of a session that shows ``view`` of the costmaps of a recording without scans."""

    def make(host: ModelHost, making: Making) -> SessionModel:  # noqa: ARG001 - as all plans
        from server.sources.costmaps import CostmapsModel  # noqa: PLC0415 - few logs have them

        return CostmapsModel(streams, log_id=log_id, title=title, topic=view.trajectory, index=view.index)

    return Plan(make, name=name, playing=playing)


def _map_plan(reference: ReferenceMap) -> Plan:
    """Return the plan of a session that shows and edits a map."""

    def make(host: ModelHost, making: Making) -> SessionModel:  # noqa: ARG001 - as all plans
        from server.sources.map import MapModel  # noqa: PLC0415 - few uploads are maps

        return MapModel(host, reference)

    return Plan(make, playing=False)


LOG = Kind(NewLog, _plan)
