"""A camera that moves with the robot. It keeps the place relative to the robot to which a user moved it."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from server.scenes.cameras import Vector, carried, robot_camera_at, seen_from
from server.sessions.scene_controls import Sight
from server.stream.message_parts import RobotCameraName

MOST_ON_THEIR_WAY = 64  #: maximum number of places sent to a browser that it has not reported yet


class Following:
    """The camera ``name`` of a view, updated by the robot's motion and by reports of its browser."""

    def __init__(self, name: RobotCameraName) -> None:
        self._name: RobotCameraName = name
        self._moved: tuple[Vector, Vector] | None = (
            None  #: its position and target relative to the robot; None: the defaults
        )
        self._told: deque[tuple[Vector, Sight]] = deque(maxlen=MOST_ON_THEIR_WAY)  #: the first is the last one reported

    def follow(self, sight: Sight) -> tuple[Vector, Vector] | None:
        """Return the new position and target of the camera, metres; None if unchanged."""
        if self._told and self._told[-1][1] == sight:
            return None
        if self._moved is None:
            place, look_at = robot_camera_at(self._name, sight)
        else:
            place, look_at = (carried(point, sight) for point in self._moved)
        self._told.append((place, sight))
        return place, look_at

    def reported(self, position: ArrayLike, look_at: ArrayLike) -> None:
        """Record a browser's camera. It is where it was sent some time ago, unless a user has moved it."""
        reports = list(self._told)
        for number, (place, _) in enumerate(reports):
            if np.allclose(position, place, atol=1e-3):
                for _ in range(number):
                    self._told.popleft()
                return
        if reports:
            sight = reports[0][1]
            self._moved = seen_from(position, sight), seen_from(look_at, sight)

    def forget_told(self) -> None:
        """Send the place again with the next :meth:`follow`, because another connection shows the view."""
        self._told.clear()
