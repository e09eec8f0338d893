"""The 3D view of one session: a viser server behind the proxy, updated after the session's ticks.

It shows the model's ``drawings()`` and ``controls()`` and does not depend on the kind of session. Nothing is computed
while no browser shows it; otherwise data is sent at most :data:`MAX_HZ` times a second, and each drawing at most at its
drawer's rate. Reading the session while there is nothing to send takes at most :data:`SHARE` of the time.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import structlog
import viser
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

from server.logging import short_hash
from server.scenes.axes_and_grid import spacing_of
from server.scenes.cameras import (
    CAMERAS,
    DEFAULT_BOUNDS,
    FOV,
    ROBOT_CAMERAS,
    Aim,
    camera_at,
)
from server.scenes.contents import SceneContents
from server.scenes.drawer import DrawerContext
from server.scenes.drawers import DRAWERS, Drawers
from server.scenes.following import Following
from server.scenes.marks import Mark, Marks
from server.scenes.panel import Panel
from server.scenes.reading import SceneState, read_state
from server.scenes.viser_server import ViserServer
from server.scenes.visitors import Viewer, viewer_of_connection
from server.sessions import SessionHost
from server.sessions.commands import MeasureRay
from server.sessions.drawings import Point, Quaternion
from server.sessions.scene_controls import Bounds, Heights, Sight
from server.stream.message_parts import CameraName, RobotCameraName
from server.stream.messages import SceneMessage

MAX_HZ = 15.0
SHARE = 0.2
SETTLE_S = 0.25  #: interval of checking a control that waits for the session's confirmation

MOST_LEFT = 64  #: disconnected views whose cameras are kept
ASPECT = 1.3  #: aspect ratio for the camera of a browser until it is sent its own

_log = structlog.get_logger(__name__)


@dataclass(slots=True, eq=False)
class View:
    """A view of the scene: its viewer, its camera's position and target, and its last assigned pose; metres."""

    viewer: Viewer
    position: NDArray[np.float64]
    look_at: NDArray[np.float64]
    aim: Aim | None = None  #: until a user moves it
    following: Following | None = None  #: while its camera moves with the robot

    def is_at(self, position: ArrayLike) -> bool:
        """Return whether its camera is at ``position`` (3,)."""
        return np.allclose(self.position, position, atol=1e-3)


class Scene:
    """The viser server of one session, created by :meth:`open`. :meth:`close` ends its threads and its socket."""

    def __init__(self, session: SessionHost, server: ViserServer, drawers: Drawers) -> None:
        self._session = session
        self._server = server
        self._drawers = drawers
        self._loop = asyncio.get_running_loop()
        self._changed = asyncio.Event()
        self.idle_since = time.monotonic()  #: when the last browser left, or the scene was created
        self._watching = 0
        self._task: asyncio.Task[None] | None = None
        self._bounds: Bounds | None = None
        self._heights: Heights = (0.0, 0.0)
        self._sight: Sight | None = None
        self._views: dict[int, View] = {}  #: by viser's client
        self._chosen: dict[str, CameraName | RobotCameraName] = {}  #: the camera that each visitor has chosen last
        self._moved: set[int] = set()  #: clients whose cameras were moved by users, before they are among the views
        self._left: deque[View] = deque(maxlen=MOST_LEFT)  #: disconnected views
        self._marks = Marks(server)
        self._moves: dict[str, tuple[Point, Quaternion]] = {}  #: the newest unposted move of each gizmo
        self._posts_moves = False
        self._announced: SceneMessage | None = None

    @classmethod
    async def open(cls, session: SessionHost, drawers: Drawers = DRAWERS) -> Scene:
        """Create the scene of ``session``, send its settings and start updating it."""
        server = await asyncio.to_thread(ViserServer)
        scene = cls(session, server, drawers)
        try:
            await asyncio.to_thread(scene._build, await read_state(session, drawers, lambda _: True))
        except BaseException:
            await asyncio.to_thread(server.stop)
            raise
        scene._tell()
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
        """Count a connected browser, and draw the current state."""
        self._watching += 1
        if self._watching == 1:
            self._session.listen(self._changed.set)  # the session's clock runs while it has listeners
        self._contents.draw_all_now()
        self._changed.set()

    def leave(self) -> None:
        """Count a disconnected browser."""
        self._watching -= 1
        self.idle_since = time.monotonic()
        if not self._watching:
            self._ignore()

    def _ignore(self) -> None:
        self._session.ignore(self._changed.set)

    # -- setup --------------------------------------------------------------------------------------------------

    def _build(self, state: SceneState) -> None:
        scene = self._server.scene
        # Two lights instead of viser's environment map, a photograph that loads slowly on a slow machine.
        scene.configure_environment_map(None)
        scene.configure_default_lights(cast_shadow=False)
        scene.add_light_hemisphere("/Sky", sky_color=(255, 255, 255), ground_color=(150, 150, 160), intensity=2.2)
        scene.world_axes.visible = False
        self._panel = Panel(self._server.gui, state.controls, self._post, self._note_change)
        context = DrawerContext(scene, self._gizmo_moved)
        self._contents = SceneContents(
            self._server, self._drawers, context, self._panel.switches, short_hash(self._session.id)
        )
        self._contents.show(state)
        self._aim(state.controls.bounds or DEFAULT_BOUNDS, state.controls.heights)
        self._sight = state.controls.sight
        scene.on_click()(self._clicked)
        self._server.on_camera_moved(self._note_moved)
        self._server.on_client_connect(self._welcome)
        self._server.on_client_disconnect(self._dismiss)

    def _aim(self, bounds: Bounds, heights: Heights) -> None:
        """Make unmoved cameras show ``bounds`` and ``heights``, initially from the south and above."""
        if (bounds, heights) == (self._bounds, self._heights):
            return
        self._bounds, self._heights = bounds, heights
        camera = self._server.initial_camera
        camera.up = (0.0, 0.0, 1.0)
        camera.fov = FOV
        camera.position, camera.look_at = camera_at("overview", bounds, ASPECT, heights)
        camera.far = max(1000.0, 10.0 * max(bounds[2] - bounds[0], bounds[3] - bounds[1]))
        for client_id, client in self._server.get_clients().items():
            view = self._views.get(client_id)
            if view is not None and view.aim is not None:
                self._aim_client(client, view.aim.name)

    async def _welcome(self, client: viser.ClientHandle) -> None:
        """Aim the initial camera of a view for the shape of its picture.

        For a view that its page had before, the camera returns to its earlier place, because viser's client starts with
        the first camera again after a lost connection. If a user had moved it before the page was reloaded, it starts
        at the place that the tab has stored (``static/src/pages/sceneCamera.ts``), and is left there, like one from a
        link.
        """
        view = View(viewer_of_connection.get(), client.camera.position, client.camera.look_at)
        before = self._last_of(view.viewer)
        self._views[client.client_id] = view
        if before is not None and before.following is not None:
            before.following.forget_told()
            view.following = before.following
        elif before is not None and before.aim is None:
            client.camera.position, client.camera.look_at = before.position, before.look_at
            view.position, view.look_at = before.position, before.look_at
        elif client.client_id not in self._moved:
            self._go(client, view, before.aim.name if before and before.aim else self._first_of(view.viewer))
        self._moved.discard(client.client_id)
        client.camera.on_update(self._fit)
        self._note_change()  # its page may have selected a place

    def _first_of(self, viewer: Viewer) -> CameraName | RobotCameraName:
        return self._chosen.get(viewer.visitor, "overview")

    def _go(self, client: viser.ClientHandle, view: View, name: CameraName | RobotCameraName) -> None:
        """Move a view's camera to one of :attr:`cameras`."""
        if name == "follow" or name == "first person":  # noqa: PLR1714 - narrows the type
            view.aim, view.following = None, Following(name)
            self._note_change()
        else:
            view.following = None
            self._aim_client(client, name)

    def _note_moved(self, client_id: int) -> None:
        """Leave a camera where a user has moved it."""
        view = self._views.get(client_id)
        if view is None:
            self._moved.add(client_id)
        else:
            view.aim = None

    def _last_of(self, viewer: Viewer) -> View | None:
        """Return the last view of a page; None if it had none.

        The service may not have noticed yet that the view's connection is lost.
        """
        views = [*self._views.values(), *reversed(self._left)]
        return next((view for view in views if viewer.page and view.viewer == viewer), None)

    async def _dismiss(self, client: viser.ClientHandle) -> None:
        if (view := self._views.pop(client.client_id, None)) is not None:
            self._left.append(view)
        self._marks.forget(client.client_id)

    def _aim_client(self, client: viser.ClientHandle, name: CameraName) -> None:
        aspect = client.camera.aspect
        position, look_at = camera_at(name, self._bounds or DEFAULT_BOUNDS, aspect, self._heights)
        view = self._views[client.client_id]
        view.position, view.look_at, view.aim = np.array(position), np.array(look_at), Aim(name, aspect, position)
        client.camera.position = position
        client.camera.look_at = look_at  # viser moves it along with the position

    async def _fit(self, camera: viser.CameraHandle) -> None:
        """Aim a camera that no user has moved again, if it is elsewhere or its picture has another shape.

        A page lays its views out after they have connected, and viser's client uses the first camera of the scene once
        it is ready, perhaps after it was sent another one.
        """
        view = self._views.get(camera.client.client_id)
        if view is None:
            return
        view.position, view.look_at, aim = camera.position, camera.look_at, view.aim
        if view.following is not None:
            view.following.reported(camera.position, camera.look_at)
            return
        if aim is None:
            return
        if aim.aspect != camera.aspect or not view.is_at(aim.position):
            self._aim_client(camera.client, aim.name)

    # -- from the page's own controls ---------------------------------------------------------------------------

    @property
    def cameras(self) -> list[CameraName | RobotCameraName]:
        """The names of the available cameras; those that move with the robot require one."""
        return [*CAMERAS, *(ROBOT_CAMERAS if self._sight is not None else ())]

    def aim(self, visitor: str, name: CameraName | RobotCameraName) -> None:
        """Move the cameras of a visitor's present and future views of this scene to one of :attr:`cameras`."""
        self._chosen[visitor] = name
        for client_id, client in self._server.get_clients().items():
            view = self._views.get(client_id)
            if view is not None and view.viewer.visitor == visitor:
                self._go(client, view, name)

    def chosen(self, visitor: str) -> CameraName | RobotCameraName | None:
        """Return the camera that a visitor has chosen last, in any page; None if none."""
        return self._chosen.get(visitor)

    @property
    def layers(self) -> dict[str, bool]:
        """The labels of the drawings, and whether they are visible."""
        return self._panel.switches.visible

    def set_layer(self, label: str, *, visible: bool) -> None:
        """Show or hide all drawings of a label, in all views of the scene. An unknown label is ignored."""
        self._panel.switches.switch(label, visible=visible)
        self._tell()

    @property
    def height(self) -> float:
        """Height of the map's columns as a multiple of the default."""
        return self._contents.height

    async def set_height(self, height: float) -> None:
        """Draw the map's columns ``height`` times as high as by default, in all views of the scene."""
        await asyncio.to_thread(self._contents.set_height, height)
        self._tell()

    @property
    def grid_spacing(self) -> float:
        """Distance between two lines of the grid, metres."""
        return spacing_of(self._bounds or DEFAULT_BOUNDS)

    def _tell(self) -> None:
        """Send changed settings to the session's pages."""
        settings = SceneMessage(self.cameras, self.layers, self.height, self.grid_spacing)
        if settings != self._announced:
            self._announced = settings
            self._session.announce(settings)

    # -- from the browser, on viser's threads -------------------------------------------------------------------

    def _post(self, command: Struct) -> None:
        """Post a command to the session, and redraw soon, because it may be refused."""
        self._session.post(command)
        self._note_change()

    def _note_change(self) -> None:
        """Draw, and send changed settings (any thread)."""
        self._loop.call_soon_threadsafe(self._changed.set)

    def _clicked(self, event: viser.SceneClickEvent) -> None:
        """Pass the ray of a click, and where it meets a drawing, to the model."""
        met = self._contents.met(event.ray_origin, event.ray_direction)
        view = self._views.get(event.client_id)
        page = "" if view is None else view.viewer.page
        self._loop.call_soon_threadsafe(self._click, page, event.ray_origin, event.ray_direction, met)

    def _gizmo_moved(self, name: str, position: Point, wxyz: Quaternion) -> None:
        self._loop.call_soon_threadsafe(self._note_move, name, position, wxyz)

    # -- from the browser, on the event loop --------------------------------------------------------------------

    def _click(self, page: str, origin: Point, direction: Point, met: Point | None) -> None:
        """Post the command for a click. Its answer goes to the page of the view.

        While that page measures, the click only requests the selected place.
        """
        client = self._session.hub.of_page(page)
        measures = client is not None and client.measured is not None
        ask = MeasureRay if measures else self._session.model.on_scene_ray
        command = ask(origin, direction, met)
        if command is not None:
            self._session.post(command, client)
            self._changed.set()  # it may be refused

    def _note_move(self, name: str, position: Point, wxyz: Quaternion) -> None:
        """Post a gizmo's move, at most :data:`MAX_HZ` times a second; of the moves in between only the last counts."""
        self._moves[name] = (position, wxyz)
        if not self._posts_moves:
            self._post_moves()

    def _post_moves(self) -> None:
        moves, self._moves = self._moves, {}
        self._posts_moves = bool(moves)
        if moves:
            self._loop.call_later(1.0 / MAX_HZ, self._post_moves)
            self._changed.set()
        for name, (position, wxyz) in moves.items():
            command = self._session.model.on_gizmo_moved(name, position, wxyz)
            if command is not None:
                self._post(command)

    # -- from the session ---------------------------------------------------------------------------------------

    async def _follow(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            pause_s = 1.0 / MAX_HZ
            if self._watching:
                queued = self._server.queued
                try:
                    state = await read_state(self._session, self._drawers, self._contents.due)
                    await asyncio.to_thread(self._draw, state, self._marked())
                    self._tell()
                    if self._server.queued == queued:  # the next change need not wait
                        pause_s = min(pause_s, (time.monotonic() - state.read_at) / SHARE)
                except Exception:  # noqa: BLE001 - a scene that cannot be drawn must not end the session's view for good
                    _log.exception("scene not drawn", session=short_hash(self._session.id))
            await asyncio.sleep(pause_s)

    def _marked(self) -> dict[int, Mark]:
        """Return the selected places and measurements of the pages of viser's clients, by the number of the client."""
        pages = {
            client.page: Mark(client.selected, client.measured) for client in self._session.hub.clients if client.page
        }
        viewers = [(number, view.viewer) for number, view in [*self._views.items()]]
        return {number: pages[viewer.page] for number, viewer in viewers if viewer.page in pages}

    def _draw(self, state: SceneState, marks: dict[int, Mark]) -> None:
        """Draw what changed (called on a thread)."""
        wait = self._contents.show(state)
        self._marks.show(marks)
        self._aim(state.controls.bounds or DEFAULT_BOUNDS, state.controls.heights)
        self._sight = state.controls.sight
        self._follow_robot()
        self._panel.show(state.controls)
        self._server.flush()  # viser would wait 17 ms for further messages
        if wait is not None or self._panel.unsettled or self._contents.unsettled:
            later = partial(self._loop.call_later, max(wait or 0.0, SETTLE_S), self._changed.set)
            self._loop.call_soon_threadsafe(later)

    def _follow_robot(self) -> None:
        """Move the cameras that follow the robot (called on a thread)."""
        for client_id, client in self._server.get_clients().items():
            view = self._views.get(client_id)
            if view is None or view.following is None or self._sight is None:
                continue
            camera = view.following.follow(self._sight)
            if camera is not None:
                with client.atomic():
                    client.camera.position, client.camera.look_at = camera
