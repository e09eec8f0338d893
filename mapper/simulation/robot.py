"""Round robot with a differential drive."""

from __future__ import annotations

from dataclasses import dataclass

PoseTuple = tuple[float, float, float]

#: A hexagon around the simulated robot of radius 0.2 m: corners in its frame, metres.
HEXAGON = ((0.231, 0.0), (0.1155, 0.2), (-0.1155, 0.2), (-0.231, 0.0), (-0.1155, -0.2), (0.1155, -0.2))


@dataclass(slots=True)
class Robot:
    """State of a differential drive: pose ``T_map_base`` (x, y, yaw) and velocities, in m, rad, m/s and rad/s.

    It is a disc of ``radius`` metres that turns about its centre, so turning in place is always possible.
    :mod:`mapper.simulation.textbook_driving` is the motion model.
    """

    pose: PoseTuple
    radius: float
    linear: float = 0.0
    angular: float = 0.0

    def stop(self) -> None:
        """Stop immediately, without deceleration."""
        self.linear = self.angular = 0.0
