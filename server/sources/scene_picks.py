"""The object that a click in a log's 3D view selects: a loop of the pose graph, a pose of the path, or a cell."""

from __future__ import annotations

import math

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from server.sessions.commands import on_floor
from server.sessions.drawings import Point
from server.sessions.parts import ShownLoops
from server.stream.messages import PickedMessage

REACH = math.radians(1.0)  #: largest angle from a line of sight at which a thin object is selected
SLACK_M = 0.3  #: objects behind the side of a column by less than this do not count as hidden


class ScenePick(Struct):
    """A click in the 3D view of a log. Only the service sends it.

    The line of sight starts at ``origin`` and has the given ``direction``. It ends at ``met`` on a column of the map,
    in map metres; None if it meets no column.
    """

    origin: Point
    direction: Point
    met: Point | None


def picked_by(pick: ScenePick, poses: NDArray[np.float64], loops: ShownLoops | None) -> PickedMessage | None:
    """Return what a click selects; None if its line of sight does not even meet the floor.

    ``poses`` (n, 3) are those of the scans, ``T_map_base``.
    """
    origin, direction = pick.origin, pick.direction
    far = math.inf if pick.met is None else math.dist(origin, pick.met) + SLACK_M
    if loops is not None and (nearest := _nearest_to_ray(loops.ends, origin, direction, far)) is not None:
        x, y, _ = loops.ends[nearest].mean(axis=0).tolist()
        return PickedMessage("loop", x, y, yaw=None, index=None, edge=int(loops.edges[nearest]))
    flat = np.column_stack([poses[:, :2], np.zeros(len(poses))])
    scan = _nearest_to_ray(np.stack([flat, flat], axis=1), origin, direction, far)
    if scan is not None:
        x, y, yaw = poses[scan].tolist()
        return PickedMessage("pose", x, y, yaw=yaw, index=scan + 1, edge=None)
    place = pick.met or on_floor(origin, direction)
    if place is None:
        return None
    return PickedMessage("cell", place[0], place[1], yaw=None, index=None, edge=None)


def _nearest_to_ray(ends: NDArray[np.float64], origin: Point, direction: Point, far: float) -> int | None:
    """Return the segment at the least angle from a line of sight; None if none is within :data:`REACH`.

    ``ends`` (n, 2, 3) are in metres; two equal ends are a point. ``far`` is the length of the line, metres. The angle
    is measured where the segment is closest to the line.
    """
    away = np.asarray(direction, dtype=np.float64)
    away = away / np.linalg.norm(away)
    from_eye = np.asarray(ends, dtype=np.float64) - np.asarray(origin, dtype=np.float64)
    across = from_eye - (from_eye @ away)[..., None] * away  # the components perpendicular to the line
    start, along = across[:, 0], across[:, 1] - across[:, 0]
    length = np.einsum("ij,ij->i", along, along)
    share = -np.einsum("ij,ij->i", start, along) / np.where(length > 0.0, length, 1.0)
    share = np.clip(share, 0.0, 1.0)[:, None]
    depth = (from_eye[:, 0] + share * (from_eye[:, 1] - from_eye[:, 0])) @ away
    angle = np.arctan2(np.linalg.norm(start + share * along, axis=1), depth)
    angle[depth > far] = np.inf
    return int(angle.argmin()) if len(angle) and angle.min() <= REACH else None
