"""A round robot with a differential drive: how it moves, and what stops it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mapper.simulation.kernels.raycast import nearest_edge
from mapper.simulation.worlds import World

PoseTuple = tuple[float, float, float]

MAX_LINEAR = 1.0  #: m/s
MAX_ANGULAR = 1.5  #: rad/s
LINEAR_ACCELERATION = 1.2  # m/s²
BRAKING = 2.0  # m/s²
ANGULAR_ACCELERATION = 5.0  # rad/s²
STALLED = 0.3  # share of the commanded speed below which the robot stops at a wall instead of sliding along it
SKIN = 1e-4  # metres kept from every wall, so that rounding never lets the robot touch


@dataclass(slots=True)
class Robot:
    """The state of a differential drive: pose ``T_map_base`` (x, y, yaw) and velocities, in m, rad, m/s and rad/s.

    It turns about its centre and is a disc of ``radius`` metres, so a turn on the spot is always possible.
    """

    pose: PoseTuple
    radius: float
    linear: float = 0.0
    angular: float = 0.0

    def step(self, world: World, linear: float, angular: float, dt: float) -> None:
        """Move for ``dt`` seconds towards the commanded velocities, as fast as the accelerations allow.

        Where the motion would touch a wall the robot slides along it, and where it cannot slide it stops: its
        centre never comes nearer than ``radius`` to anything solid. Source of the motion: Probabilistic Robotics,
        section 5.3.3, with the arc replaced by its chord.
        """
        slowing = abs(linear) < abs(self.linear) or linear * self.linear < 0.0
        rate = BRAKING if slowing else LINEAR_ACCELERATION
        self.linear = _towards(self.linear, _clip(linear, MAX_LINEAR), rate * dt)
        self.angular = _towards(self.angular, _clip(angular, MAX_ANGULAR), ANGULAR_ACCELERATION * dt)
        x, y, yaw = self.pose
        heading = yaw + 0.5 * self.angular * dt
        to_x, to_y = x + self.linear * dt * math.cos(heading), y + self.linear * dt * math.sin(heading)
        to_x, to_y, touched = self._kept_free(world, x, y, to_x, to_y)
        moved = math.hypot(to_x - x, to_y - y) / dt
        if touched and moved < STALLED * abs(self.linear):
            self.linear = math.copysign(moved, self.linear)  # pushing against a wall stops the wheels
        turned = yaw + self.angular * dt
        self.pose = (to_x, to_y, math.remainder(turned, 2.0 * math.pi))

    def stop(self) -> None:
        """Stop at once, without deceleration."""
        self.linear = self.angular = 0.0

    def _kept_free(self, world: World, x: float, y: float, to_x: float, to_y: float) -> tuple[float, float, bool]:
        """Return a place near (to_x, to_y) where the robot fits, and whether a wall blocked the motion."""
        least = self.radius + SKIN
        nearest = np.zeros(2)
        touched = False
        for _ in range(3):  # a corner has two walls; a place that three corrections do not free is too tight
            clearance = nearest_edge(world.segments, to_x, to_y, nearest)
            if clearance >= least:
                return to_x, to_y, touched
            touched = True
            if clearance <= 0.0:
                break
            push = (least - clearance + 1e-9) / clearance
            to_x += (to_x - nearest[0]) * push
            to_y += (to_y - nearest[1]) * push
        if nearest_edge(world.segments, to_x, to_y, nearest) >= least:
            return to_x, to_y, True
        return x, y, True


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


def _towards(value: float, target: float, step: float) -> float:
    return value + _clip(target - value, step)
