"""The terrain of a session's points: grids of patches, and a message with the numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mapper.core.errors import MapperError, WorkCancelledError
from mapper.grid import OccupancyGrid
from server.parts.terrain.assessment import TABLE, Assessed, TerrainParameters, assessed
from server.parts.terrain.messages import TerrainCommand, TerrainCounts, TerrainMessage
from server.parts.terrain.patch import first_asked, patch_at, patch_mark
from server.sessions.part import Cloud, Offers, OtherMap, Part
from server.sessions.tick import TickResult
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer
from server.stream.message_parts import rows_of
from server.stream.protocol import ProtocolError, place_of

if TYPE_CHECKING:
    from server.sessions.drawings import Drawing

SCANS_BETWEEN = 8  #: scans of the 3D sensor between two assessments


class TerrainPart(Part):
    """A terrain. The session's ``terrain`` command begins and ends it; it also ends if there are no points.

    If there are points from the start, the parameters suit their density, and an unsafe patch is explained before a
    visitor queries one.
    """

    commands = (TerrainCommand,)
    subject = "terrain"
    is_on = False

    @classmethod
    def of(cls, offers: Offers) -> TerrainPart | None:
        """Return the part of a source with points."""
        return None if offers.cloud is None else cls(offers, offers.cloud)

    def __init__(self, offers: Offers, source: Cloud) -> None:
        self._host, self._source = offers.host, source
        self._asks_first = source.count > 0
        self._first = TerrainParameters.for_cloud(source.points()) if self._asks_first else TerrainParameters()
        self.tables = {"terrain": rows_of(replace(row, initial=self._first.values[row.name]) for row in TABLE)}
        offers.maps["terrain"] = OtherMap("the classes of the terrain, while there is one", lambda: self.grid)
        offers.costs["terrain_layer"] = lambda: None if self._assessment is None else self._assessment.terrain
        self._share: float | None = None  #: completed share of the current assessment
        self._parameters: TerrainParameters | None = None
        self._costs = GridLayer("terrain_costs", "Terrain", "costs")
        self._values = GridLayer("terrain_values", "Property of the terrain")
        self._assessment: Assessed | None = None
        self._taken = -1  #: number of scans at the last assessment; −1: it must be assessed
        self._asked: tuple[float, float] | None = None
        self._mark: tuple[object, list[Drawing]] = (None, [])  #: the last mark, and its drawings
        self._problem: str | None = None
        self._before: TerrainCounts | None = None  #: the latest change of a value, and the classes before it
        self.grid: OccupancyGrid | None = None  #: its classes as a map, replaced when they change; None if it is off

    @property
    def progress(self) -> float | None:
        """Completed share of the current assessment."""
        return self._share

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Costs and the chosen property; none while it is off."""
        return () if self._parameters is None else (self._costs, self._values)

    @property
    def cells(self) -> int:
        """Number of cells that it uses, including ten moments per patch and the ground points."""
        assessment = self._assessment
        return 0 if assessment is None else 24 * assessment.terrain.classes.size + 6 * len(assessment.ground_points)

    def drawings(self) -> list[Drawing]:
        """Return a mark around the queried patch; empty without one."""
        if self._assessment is None or self._asked is None:
            return []
        marked = self._assessment, *self._asked
        if self._mark[0] != marked:
            drawn = patch_mark(*marked)
            self._mark = marked, [] if drawn is None else [drawn]
        return self._mark[1]

    def handle(self, command: TerrainCommand, result: TickResult) -> None:
        """Begin the terrain, change it, query a patch, or end it. Raises :class:`ConfigError`."""
        if not command.value:
            self._end(result)
            return
        if not self._source.count:
            raise ProtocolError("terrain.no_points", "There are no points yet: begin the 3D map first.")
        parameters = (self._parameters or self._first).with_values(command.values)
        if parameters != self._parameters:
            self._note_change(parameters)
            self._parameters, self._taken, self.is_on = parameters, -1, True
        if (place := place_of(command)) is not None:
            self._asked = place[0], place[1]
        result.changed = True
        result.slot(*self.messages())

    def _end(self, result: TickResult) -> None:
        self._parameters = self._assessment = self.grid = self._asked = self._problem = self._before = None
        self.is_on = False
        result.changed = True
        result.slot(*self.messages())

    def _note_change(self, parameters: TerrainParameters) -> None:
        """Store the numbers of patches of each class, for comparison with those of other values."""
        if self._assessment is None or self._parameters is None:
            return
        old, new = self._parameters.values, parameters.values
        names = [row.name for row in TABLE if old[row.name] != new[row.name] and row.name != "shown"]
        if names:
            self._before = TerrainCounts(names, **self._assessment.terrain.counts())

    def changed(self, result: TickResult) -> None:
        """Assess the terrain again if there are enough new scans or other parameters."""
        if self._parameters is None:
            return
        count = self._source.count
        if not count:
            self._end(result)
            return
        if self._taken >= 0 and 0 <= count - self._taken < SCANS_BETWEEN:
            return
        self._taken = count
        try:
            with self._host.cancellable(by_newer=False):
                points, bounds, truth = self._source.read()
                self._assessment = assessed(points, bounds, self._parameters, truth, self._note_share)
            self._problem = None
        except MapperError as error:
            self._assessment, self._problem = None, error.message
        self._share = None
        self.grid = None if self._assessment is None else self._assessment.grid()
        if self._assessment is not None:
            if self._asks_first and self._asked is None:
                self._asked = first_asked(self._assessment)
            self._show(self._assessment, self._parameters.values["shown"])
        result.changed = True
        result.slot(*self.messages())

    def _note_share(self, share: float) -> None:
        """Record the progress. Raises :class:`WorkCancelledError` once a visitor has cancelled it."""
        self._share = share
        if not self._host.may_continue():
            raise WorkCancelledError(
                "terrain.cancelled", "The assessment was cancelled; a change of a value begins it."
            )

    def _show(self, assessment: Assessed, name: str) -> None:
        geometry = assessment.terrain.patches.geometry
        if name in ("costs", "costmap"):
            costs = assessment.terrain.costs() if name == "costs" else assessment.costmap.costs
            self._costs.set_bytes(geometry, np.ascontiguousarray(costs))
        else:
            shown, most = assessment.shown(name)
            self._values.set(geometry, shown, 0.0, most)

    def messages(self) -> tuple[TerrainMessage]:
        """Return the ``terrain`` message."""
        assessment, patch = self._assessment, None
        if assessment is not None and self._asked is not None:
            try:
                patch = patch_at(assessment, *self._asked)
            except MapperError:
                self._asked = None
        counts = {"safe": 0, "unsafe": 0, "unknown": 0} if assessment is None else assessment.terrain.counts()
        message = TerrainMessage(
            is_on=self._parameters is not None,
            values=dict((self._parameters or self._first).values),
            points=0 if assessment is None else assessment.points,
            ground=0 if assessment is None else len(assessment.ground_points),
            unsure=0 if assessment is None else assessment.unsure,
            left_out=0 if assessment is None else int((~assessment.is_fitted).sum()),
            kappa=_rounded(None if assessment is None else assessment.kappa),
            total_error=_rounded(None if assessment is None else assessment.total_error),
            truth=None if assessment is None or assessment.kappa is None else self._source.truth,
            **counts,
            size=0.0 if assessment is None else assessment.terrain.patches.size,
            before=self._before,
            patch=patch,
            problem=self._problem,
        )
        return (message,)


def _rounded(percent: float | None) -> float | None:
    return None if percent is None else round(percent, 2)


part_of = TerrainPart.of
