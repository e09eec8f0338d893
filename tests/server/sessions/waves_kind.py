"""An example of a session kind in one file: a wave on water, and floats on it.

It shows a grid layer (the height of the water), a point layer (the floats) and a 3D drawing (the surface). The page's
side is ``static/src/tools/example/waves.ts``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from pydantic import Field

from mapper.grid import GridGeometry
from server.sessions.drawings import Drawing, Mesh
from server.sessions.kind import Kind, Plan, Resources, SessionRequest
from server.sessions.model import Footprint, SessionModel
from server.sessions.tick import TickResult
from server.stream.commands import StepCommand
from server.stream.grid_layer import GridLayer
from server.stream.layers import Layer, TableLayer
from server.stream.messages import FrameMessage
from server.stream.protocol import ProtocolError

GEOMETRY = GridGeometry(0.25, 80, 120)  #: cells of 0.25 m, 80 rows and 120 columns, from the origin of the map frame
AMPLITUDE = 0.5  #: metres
STEP_S = 0.1  #: seconds of one step


class NewWaves(SessionRequest):
    """The body of ``POST /api/sessions`` for this kind."""

    kind: Literal["waves"]
    wavelength: float = Field(6.0, ge=1.0, le=30.0, description="Metres from one crest to the next.")


class WavesModel(SessionModel):
    """A wave that travels along x by one wavelength a second."""

    kind: ClassVar[str] = "waves"

    def __init__(self, wavelength: float) -> None:
        super().__init__()
        self.wavelength = wavelength
        self.time_s = 0.0
        rows, cols = np.mgrid[0 : GEOMETRY.rows, 0 : GEOMETRY.cols]
        cells = np.column_stack([rows.ravel(), cols.ravel()])
        self._cells_xy = GEOMETRY.cell_to_world(cells).reshape(*GEOMETRY.shape, 2)
        self._height = GridLayer("height", "Height of the water", style="height")
        self._floats = TableLayer("floats", "Floats", style="floats", columns=("x", "y", "value"))
        self._floats_x = np.arange(1.0, 30.0, 2.0)
        self._faces = _faces()
        self.draw(TickResult())

    def height(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the height of the water at ``x``, metres."""
        return AMPLITUDE * np.sin(2.0 * np.pi * (x / self.wavelength - self.time_s))

    # -- what every kind says -------------------------------------------------------------------------------------

    @property
    def layers(self) -> Sequence[Layer]:
        """The grid, then the points."""
        return (self._height, self._floats)

    def advance(self, dt: float, result: TickResult) -> None:
        """Let the wave travel."""
        self.time_s += dt * self.playback.speed
        result.changed |= dt > 0.0

    # -- what this kind adds --------------------------------------------------------------------------------------

    def draw(self, result: TickResult) -> None:
        """Write both layers."""
        self._height.set(GEOMETRY, self.height(self._cells_xy[..., 0]).astype(np.float32), -AMPLITUDE, AMPLITUDE)
        x = self._floats_x
        self._floats.set([x, np.full_like(x, 10.0), self.height(x)])

    def handle(self, command: Struct, result: TickResult) -> None:
        """Go forward or back by some steps."""
        if not isinstance(command, StepCommand):
            super().handle(command, result)
            return
        if abs(command.scans) > 100:
            raise ProtocolError("command.scans", "The wave goes by 1 to 100 steps, forward or back.")
        self.playback.playing = False
        self.time_s += command.scans * STEP_S
        result.changed = True

    def complete_frame(self, frame: FrameMessage) -> None:
        """The time of the wave, seconds."""
        frame.stamp = self.time_s

    @property
    def footprint(self) -> Footprint:
        """Memory, for the budgets."""
        return Footprint(cells=GEOMETRY.rows * GEOMETRY.cols)

    def drawings(self) -> list[Drawing]:
        """The surface of the water in 3D."""
        corners = self._cells_xy[::4, ::4].reshape(-1, 2)
        vertices = np.column_stack([corners, self.height(corners[:, 0])]).astype(np.float32)
        return [Mesh(name="surface", label="Surface", vertices=vertices, faces=self._faces, color=(60, 120, 190))]


def _faces() -> NDArray[np.uint32]:
    """Return two triangles for each square of the surface (n, 3), counter-clockwise seen from above."""
    rows, cols = GEOMETRY.rows // 4, GEOMETRY.cols // 4
    corner = np.arange(rows * cols).reshape(rows, cols)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    triangles = [np.stack(one, axis=-1).reshape(-1, 3) for one in ((a, b, c), (a, c, d))]
    return np.concatenate(triangles).astype(np.uint32)


async def _plan(wanted: NewWaves, _: Resources) -> Plan:
    return Plan(lambda host, making: WavesModel(wanted.wavelength), playing=wanted.playing)


WAVES = Kind(NewWaves, _plan)
