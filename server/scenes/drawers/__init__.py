"""The drawers, one class for each type of drawing. A new drawer is added to :data:`DRAWERS`."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from server.scenes.drawer import Drawer
from server.scenes.drawers.chunks import SurfaceDrawer, VoxelsDrawer
from server.scenes.drawers.gizmo import GizmoDrawer
from server.scenes.drawers.grid_columns import GridColumnsDrawer
from server.scenes.drawers.robot_body import RobotBodyDrawer
from server.scenes.drawers.shapes import ImageDrawer, MeshDrawer, PathDrawer, PointsDrawer, SegmentsDrawer
from server.scenes.drawers.walls import WallsDrawer
from server.sessions import drawings

Drawers = Mapping[type[drawings.Drawing], type[Drawer[Any, Any]]]

DRAWERS: Drawers = MappingProxyType(
    {
        drawings.Gizmo: GizmoDrawer,
        drawings.GridColumns: GridColumnsDrawer,
        drawings.Image: ImageDrawer,
        drawings.Mesh: MeshDrawer,
        drawings.Path: PathDrawer,
        drawings.Points: PointsDrawer,
        drawings.RobotBody: RobotBodyDrawer,
        drawings.Segments: SegmentsDrawer,
        drawings.Surface: SurfaceDrawer,
        drawings.Voxels: VoxelsDrawer,
        drawings.Walls: WallsDrawer,
    }
)
