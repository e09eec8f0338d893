"""Drawings of the scene. Each remembers what it sent last, so that only changes go to the browser.

Colours are those of the pages: orange for occupied, blue for free, teal for the robot, magenta for its beams.
"""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse
from mapper.grid import GridGeometry
from mapper.simulation import World
from server.scenes.belief import Picture, changed_tiles, tile_columns
from server.scenes.shapes import arrow, boxes, extruded
from server.sessions import SessionView
from server.sessions.view import Pose

SOLID = (150, 160, 178)
GROUND = (228, 224, 212)
COLUMN = (214, 112, 44)
ROBOT = (47, 150, 130)
NOSE = (236, 250, 246)
BEAM = (216, 137, 198)
PATH = (71, 78, 96)

WALL_HEIGHT = 0.16  #: metres: the map's columns stand above the true walls
GROUND_DEPTH = 0.1
FLOOR_Z = 0.01
MAX_BEAMS = 120  #: beams drawn of one scan
MAX_PATH = 4000  #: segments drawn of a trajectory
LASER_Z = 0.2  #: metres: where beams are drawn
BEAM_START = 0.35  #: metres from the sensor at which a beam is drawn: close to it they would hide the robot


def wxyz(yaw: float) -> tuple[float, float, float, float]:
    """Return the rotation by ``yaw`` radians about z as a unit quaternion."""
    return (float(np.cos(yaw / 2)), 0.0, 0.0, float(np.sin(yaw / 2)))


class WorldDrawing:
    """The true world's solids, seen from above as low walls."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.node = scene.add_frame("/world", show_axes=False)
        self._shown: World | None = None

    def show(self, world: World | None) -> bool:
        """Show ``world``; return whether it changed."""
        if world is self._shown:
            return False
        self._shown = world
        if world is None:
            self._scene.remove_by_name("/world/solids")
            self._scene.remove_by_name("/world/ground")
            return True
        vertices, faces = extruded(world.solids, WALL_HEIGHT)
        self._scene.add_mesh_simple("/world/solids", vertices, faces, color=SOLID, flat_shading=True)
        x0, y0, x1, y1 = world.bounds
        slab = boxes(np.array([[x0, y0, -GROUND_DEPTH]]), np.array([[x1, y1, 0.0]]))
        self._scene.add_mesh_simple("/world/ground", *slab, color=GROUND, flat_shading=True)
        return True


class MapDrawing:
    """The occupancy grid: a floor and columns. Only tiles that changed are sent again."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.node = scene.add_frame("/map", show_axes=False)
        self._floor: viser.ImageHandle | None = None
        self._tiles: dict[tuple[int, int], viser.MeshHandle] = {}
        self._geometry: GridGeometry | None = None
        self._shown: Picture | None = None

    def show(self, geometry: GridGeometry, new: Picture) -> None:
        """Draw what differs from the picture that was shown before."""
        if geometry != self._geometry:
            self._start_again(geometry)
        old, self._shown = self._shown, new
        if old is None or not np.array_equal(old.floor, new.floor):
            self._show_floor(new)
        for tile in changed_tiles(new.levels, old.levels if old else None):
            self._show_tile(new, tile)

    def _start_again(self, geometry: GridGeometry) -> None:
        for tile in self._tiles.values():
            tile.remove()
        self._tiles.clear()
        if self._floor is not None:
            self._floor.remove()
            self._floor = None
        self._geometry, self._shown = geometry, None
        x, y, yaw = geometry.origin
        self.node.position = (x, y, 0.0)
        self.node.wxyz = wxyz(yaw)

    def _show_floor(self, new: Picture) -> None:
        image = np.ascontiguousarray(GridGeometry.to_image(new.floor))
        if self._floor is not None:
            self._floor.image = image
            return
        width, height = new.size_m
        self._floor = self._scene.add_image(
            "/map/floor",
            image,
            width,
            height,
            format="png",
            cast_shadow=False,
            # viser's images have their first row at the smallest y of their own frame: half a turn about x.
            wxyz=(0.0, 1.0, 0.0, 0.0),
            position=(width / 2, height / 2, FLOOR_Z),
        )

    def _show_tile(self, new: Picture, tile: tuple[int, int]) -> None:
        vertices, faces = tile_columns(new.levels, tile, new.cell)
        if len(faces):
            name = f"/map/{tile[0]}_{tile[1]}"
            self._tiles[tile] = self._scene.add_mesh_simple(
                name, vertices, faces, color=COLUMN, flat_shading=True, cast_shadow=False
            )
        elif tile in self._tiles:
            self._tiles.pop(tile).remove()


class RobotDrawing:
    """The robot's body with an arrow for its heading, and the beams of the newest scan, which move with it."""

    def __init__(self, scene: viser.SceneApi, radius: float = 0.25) -> None:
        self._base = scene.add_frame("/robot", show_axes=False)
        self.node = scene.add_frame("/robot/body", show_axes=False)
        scene.add_cylinder("/robot/body/base", radius, 0.14, color=ROBOT, position=(0.0, 0.0, 0.11))
        scene.add_cylinder("/robot/body/laser", 0.45 * radius, 0.08, color=PATH, position=(0.0, 0.0, LASER_Z))
        vertices, faces = arrow(1.5 * radius, 1.1 * radius, 0.02)
        scene.add_mesh_simple(
            "/robot/body/heading", vertices, faces, color=NOSE, flat_shading=True, position=(0, 0, 0.245)
        )
        self.beams = scene.add_line_segments(
            "/robot/beams", np.zeros((0, 2, 3), np.float32), BEAM, thickness=1.0, thickness_units="screen"
        )

    def show(self, pose: Pose, beams: NDArray[np.float32]) -> None:
        """Move the robot to ``pose`` and draw ``beams`` (n, 2, 3), in the base frame."""
        x, y, yaw = pose
        self._base.position = (x, y, 0.0)
        self._base.wxyz = wxyz(yaw)
        self.beams.points = beams


def beam_segments(view: SessionView) -> NDArray[np.float32]:
    """Return the beams that hit something as segments (n, 2, 3) in the base frame, at most :data:`MAX_BEAMS`."""
    step = -(-len(view.ranges) // MAX_BEAMS) or 1
    ranges = np.asarray(view.ranges, dtype=np.float64)[::step]
    x, y, yaw = compose(inverse(view.pose), compose(view.sensor_pose, view.config.mount))
    angles = yaw + view.angles[::step]
    hit = np.isfinite(ranges) & (ranges > BEAM_START) & (ranges <= view.range_max)
    ranges, angles = ranges[hit], angles[hit]
    segments = np.full((len(ranges), 2, 3), LASER_Z, dtype=np.float32)
    for end, distance in enumerate((BEAM_START, ranges)):
        segments[:, end, 0] = x + distance * np.cos(angles)
        segments[:, end, 1] = y + distance * np.sin(angles)
    return segments


def path_segments(poses: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the path along ``poses`` (n, 3) as segments (m, 2, 3) on the floor, at most :data:`MAX_PATH`."""
    step = -(-len(poses) // MAX_PATH) or 1
    points = np.column_stack([poses[::step, :2], np.full(len(poses[::step]), 0.03)]).astype(np.float32)
    return np.stack([points[:-1], points[1:]], axis=1)
