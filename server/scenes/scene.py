"""The 3D view of one session: a viser server behind the proxy that follows the session.

Nothing is computed while no browser shows it. Otherwise the robot is drawn at most :data:`POSE_HZ` times a second and
the map at most :data:`MAP_HZ` times a second, within a share :data:`MAP_SHARE` of the time.
"""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from typing import Any

import numpy as np
import structlog
import viser
from numpy.typing import NDArray

from mapper.mapping.parameters import PARAMETERS
from mapper.simulation import SENSOR_PARAMETERS
from server.logging import short_hash
from server.scenes.drawing import PATH, MapDrawing, RobotDrawing, WorldDrawing, path_segments
from server.scenes.panel import Clock, NamedChoice, ParameterControls, add_layers
from server.scenes.state import SceneState, read_state
from server.scenes.viser_server import ViserServer
from server.sessions import SessionHost

POSE_HZ = 15.0
MAP_HZ = 4.0
MAP_SHARE = 0.1  #: most of the time that drawing the map may take
WIDE = 1.3  #: width over height of a picture in which the first camera has the whole world in view
MARGIN = 5.0  #: metres around a log's path that the first camera shows
SETTLE_S = 0.25  #: seconds after which a control that waits for the session is looked at again

_log = structlog.get_logger(__name__)


class Scene:
    """The viser server of one session. Created by :meth:`open`; :meth:`close` ends its threads and its socket."""

    def __init__(self, session: SessionHost, server: ViserServer) -> None:
        self._session = session
        self._server = server
        self._loop = asyncio.get_running_loop()
        self._changed = asyncio.Event()
        self._map_due = 0.0
        self.idle_since = time.monotonic()  #: when the last browser left, or the scene was made
        self._watching = 0
        self._task: asyncio.Task[None] | None = None
        self._world: WorldDrawing | None = None
        self._is_simulation = False
        self._path: NDArray[np.float64] | None = None
        self._choice: NamedChoice | None = None

    @classmethod
    async def open(cls, session: SessionHost) -> Scene:
        """Create the scene of ``session`` and start to follow it."""
        server = await asyncio.to_thread(ViserServer)
        scene = cls(session, server)
        try:
            await asyncio.to_thread(scene._build, await read_state(session, with_map=True))
        except BaseException:
            await asyncio.to_thread(server.stop)
            raise
        scene._task = asyncio.create_task(scene._follow(), name="scene")
        return scene

    @property
    def path(self) -> Path:
        """The Unix socket of the viser server."""
        return self._server.path

    @property
    def watched(self) -> bool:
        """Whether a browser shows the scene."""
        return self._watching > 0

    async def close(self) -> None:
        """Stop following the session, end viser's threads and close its socket."""
        self._ignore()
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await asyncio.to_thread(self._server.stop)

    def enter(self) -> None:
        """Count a browser that connected, and draw the current state."""
        self._watching += 1
        if self._watching == 1:
            self._session.listen(self._changed.set)  # the session's clock runs while it has listeners
        self._map_due = 0.0
        self._changed.set()

    def leave(self) -> None:
        """Count a browser that disconnected."""
        self._watching -= 1
        self.idle_since = time.monotonic()
        if not self._watching:
            self._ignore()

    def _ignore(self) -> None:
        self._session.ignore(self._changed.set)

    # -- building -----------------------------------------------------------------------------------------------

    def _build(self, state: SceneState) -> None:
        self._build_scene(state)
        self._build_panels(state)
        self._server.scene.on_click()(self._clicked)
        self._server.on_client_connect(self._welcome)

    def _build_scene(self, state: SceneState) -> None:
        self._is_simulation, self._path = state.world is not None, state.path
        scene = self._server.scene
        # Two lights of our own: the environment map is a photograph that takes long to light up on a slow machine.
        scene.configure_environment_map(None)
        scene.configure_default_lights(cast_shadow=False)
        scene.add_light_hemisphere("/sky", sky_color=(255, 255, 255), ground_color=(150, 150, 160), intensity=2.2)
        scene.world_axes.visible = False
        self._map = MapDrawing(scene)
        self._show_map(state)
        self._robot = RobotDrawing(scene)
        self._robot.show(state.pose, state.beams)
        self._layers: dict[str, viser.SceneNodeHandle] = {"Map": self._map.node}
        if state.world is not None:
            self._world = WorldDrawing(scene)
            self._world.show(state.world)
            self._layers["True world"] = self._world.node
        self._layers |= {"Robot": self._robot.node, "Beams": self._robot.beams}
        if self._path is not None:
            self._trajectory = scene.add_line_segments(
                "/trajectory", path_segments(self._path), PATH, thickness=1.0, thickness_units="screen"
            )
            self._layers["Path"] = self._trajectory
        self._aim(state)

    def _build_panels(self, state: SceneState) -> None:
        gui = self._server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(47, 150, 130))
        gui.set_panel_label("Gridbloom")
        gui.main_panel.dock_right()  # beside the scene, not over it
        is_log = state.world is None
        hint = "Click near the path to go to that scan." if is_log else "Click the floor to put the robot there."
        gui.add_markdown(hint)
        self._clock = Clock(
            gui, self._post, count=state.count if is_log else None, playing=state.playing, index=state.index
        )
        choice = state.choice
        if choice is not None:
            self._choice = NamedChoice(gui, choice.label, choice.names, choice.current, self._post, choice.command)
        add_layers(gui, self._layers)
        # The parameters have a panel of their own: on a phone it stays folded, and the scene in view.
        panel = gui.add_panel()
        with panel.add_tab("Mapping"):
            self._controls = [
                ParameterControls(gui, PARAMETERS, state.config, self._post, "parameters", open_groups=("model",))
            ]
        if state.sensor is not None:
            with panel.add_tab("Sensor"):
                self._controls.append(
                    ParameterControls(
                        gui, SENSOR_PARAMETERS, state.sensor, self._post, "sensor", open_groups=("sensor",)
                    )
                )
        panel.dock_below(gui.main_panel)

    def _aim(self, state: SceneState) -> None:
        """Set the initial camera: from the south and above, at the centre of the world (of the path, for a log)."""
        if state.world is not None:
            x0, y0, x1, y1 = state.world.bounds
        else:
            path = state.geometry.cell_to_world([(0, 0), state.geometry.shape]) if state.path is None else state.path
            (x0, y0), (x1, y1) = path[:, :2].min(axis=0) - MARGIN, path[:, :2].max(axis=0) + MARGIN
        x, y, size = (x0 + x1) / 2, (y0 + y1) / 2, max(x1 - x0, y1 - y0, 2.0)
        camera = self._server.initial_camera
        camera.up = (0.0, 0.0, 1.0)
        camera.fov = 0.8
        camera.look_at = (x, y, 0.0)
        camera.position = (x, y - 0.75 * size, 0.95 * size)
        camera.far = max(1000.0, 10.0 * size)

    async def _welcome(self, client: viser.ClientHandle) -> None:
        """Move the camera back on a narrow screen, so that the whole world is in view."""
        aim = self._server.initial_camera
        if client.camera.aspect < WIDE:
            back = min(WIDE / client.camera.aspect, 4.0)
            client.camera.position = aim.look_at + (aim.position - aim.look_at) * back
            client.camera.look_at = aim.look_at  # viser moved it along with the position

    # -- from the browser ---------------------------------------------------------------------------------------

    def _post(self, command: dict[str, Any]) -> None:
        """Post a command to the session, and redraw soon, since it may be refused."""
        self._session.post(command)
        self._loop.call_soon_threadsafe(self._changed.set)

    def _clicked(self, event: viser.SceneClickEvent) -> None:
        """Teleport the robot to the clicked point of the floor; in a log, seek to the nearest pose of the path."""
        (ox, oy, oz), (dx, dy, dz) = event.ray_origin, event.ray_direction
        if dz * oz >= 0.0:  # the ray does not come down (or up) to the floor
            return
        x, y = ox - dx * oz / dz, oy - dy * oz / dz
        if self._is_simulation:
            self._post({"type": "teleport", "x": x, "y": y})
        elif self._path is not None:
            gaps = (self._path[:, 0] - x) ** 2 + (self._path[:, 1] - y) ** 2
            self._post({"type": "seek", "index": int(gaps.argmin()) + 1})

    # -- from the session ---------------------------------------------------------------------------------------

    async def _follow(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            if self._watching:
                try:
                    state = await read_state(self._session, with_map=self._map_due <= time.monotonic())
                    await asyncio.to_thread(self._draw, state)
                except Exception:  # noqa: BLE001 - a scene that cannot be drawn must not end the session's view for good
                    _log.exception("scene not drawn", session=short_hash(self._session.id))
            await asyncio.sleep(1.0 / POSE_HZ)

    def _show_path(self, path: NDArray[np.float64] | None) -> None:
        if path is not None and path is not self._path:
            self._path = path
            self._trajectory.points = path_segments(path)

    def _show_map(self, state: SceneState) -> None:
        if state.picture is not None:
            self._map.show(state.geometry, state.picture)

    def _draw(self, state: SceneState) -> None:
        """Draw what changed (a thread)."""
        with self._server.atomic():
            self._robot.show(state.pose, state.beams)
            self._clock.show(playing=state.playing, index=state.index)
            if self._world is not None and self._world.show(state.world):
                self._aim(state)
            self._show_path(state.path)
        if self._choice is not None and state.choice is not None:
            self._choice.show(state.choice.current)
        self._controls[0].show(state.config)
        if state.sensor is not None:
            self._controls[1].show(state.sensor)
        wait = self._map_due - state.read_at
        if state.picture is not None:
            with self._server.atomic():
                self._show_map(state)
            took = time.monotonic() - state.read_at
            self._map_due = state.read_at + max(1.0 / MAP_HZ, took / MAP_SHARE)
        if state.picture is None or any(controls.unsettled for controls in self._controls):
            self._loop.call_soon_threadsafe(self._loop.call_later, max(wait, SETTLE_S), self._changed.set)
