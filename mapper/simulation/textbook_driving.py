"""Motion of the simulated robot in plain Python; the kernel must be identical to the last bit.

The motion of a differential drive: Probabilistic Robotics, section 5.3.3, with the arc replaced by its chord. Steering:
pure pursuit (Coulter 1992), slower between walls, and reduced if the next half second would touch one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.simulation.kernels.driving import (
    ANGULAR_ACCELERATION,
    ARRIVED,
    BRAKING,
    CAREFUL,
    CONTROL_STEPS,
    CRUISE,
    GOAL_POINTS,
    LINEAR_ACCELERATION,
    LOOKAHEAD_POINTS,
    MARGIN,
    MAX_ANGULAR,
    MAX_LINEAR,
    MOTION_S,
    MOTION_SAMPLES,
    NOTE_STEPS,
    OPEN,
    SEARCHED_POINTS,
    SKIN,
    SPARE,
    STALLED,
    STEP,
    STUCK_AFTER,
)
from mapper.simulation.kernels.raycast import arc_clearance, farthest_in_sight, nearest_edge

Pose = tuple[float, float, float]


@dataclass(slots=True)
class Drive:
    """State of a robot of ``radius`` metres among the walls ``segments`` (n, 4): x0, y0, x1, y1, metres.

    ``path`` (n, 2), metres, is the remaining path; ``pose`` and ``before`` are ``T_map_base`` (m, m, rad) now and
    a step ago; ``linear`` (m/s) and ``angular`` (rad/s) are its velocities, ``commanded`` the commanded ones;
    ``progress`` (m, m, s) is the position and time of its last progress.
    """

    segments: Float64Array
    radius: float
    path: Float64Array
    pose: Pose
    before: Pose
    linear: float
    angular: float
    commanded: tuple[float, float]
    progress: tuple[float, float, float]

    def drive(self, steps: int, count: int, next_scan: float, *, planned: bool, given: bool) -> int:
        """Take physics steps like :func:`mapper.simulation.kernels.driving.drive`.

        At the first one the path is new if ``planned``, and the velocities are known if ``given``.
        """
        for done in range(count):
            now = (steps + done) * STEP
            if (steps + done) % CONTROL_STEPS == 0 and not given:
                if not (planned and done == 0) and self._needs_plan(now):
                    return done
                self.commanded = self.velocities()
            self.step()
            if (steps + done) % NOTE_STEPS == 0 or (steps + done + 1) * STEP >= next_scan - 1e-9:
                return done + 1
        return count

    def step(self) -> None:
        """Move for :data:`STEP` seconds towards the commanded velocities, within the acceleration limits.

        If the motion would touch a wall the robot slides along it, or stops if it cannot slide: its centre is never
        nearer than ``radius`` to a solid.
        """
        linear, angular = self.commanded
        slowing = abs(linear) < abs(self.linear) or linear * self.linear < 0.0
        rate = BRAKING if slowing else LINEAR_ACCELERATION
        self.linear = _towards(self.linear, _clip(linear, MAX_LINEAR), rate * STEP)
        self.angular = _towards(self.angular, _clip(angular, MAX_ANGULAR), ANGULAR_ACCELERATION * STEP)
        self.before = x, y, yaw = self.pose
        heading = yaw + 0.5 * self.angular * STEP
        to_x, to_y = x + self.linear * STEP * math.cos(heading), y + self.linear * STEP * math.sin(heading)
        to_x, to_y, touched = self._kept_free(x, y, to_x, to_y)
        moved = math.hypot(to_x - x, to_y - y) / STEP
        if touched and moved < STALLED * abs(self.linear):
            self.linear = math.copysign(moved, self.linear)  # pushing against a wall stops the wheels
        self.pose = (to_x, to_y, math.remainder(yaw + self.angular * STEP, 2.0 * math.pi))

    def _kept_free(self, x: float, y: float, to_x: float, to_y: float) -> tuple[float, float, bool]:
        """Return a position near (to_x, to_y) where the robot fits, and whether a wall blocked the motion."""
        least = self.radius + SKIN
        nearest = np.zeros(2)
        touched = False
        for _ in range(3):  # a corner has two walls; a position that three corrections do not free is too tight
            clearance = nearest_edge(self.segments, to_x, to_y, nearest)
            if clearance >= least:
                return to_x, to_y, touched
            touched = True
            if clearance <= 0.0:
                break
            push = (least - clearance + 1e-9) / clearance
            to_x += (to_x - float(nearest[0])) * push
            to_y += (to_y - float(nearest[1])) * push
        if nearest_edge(self.segments, to_x, to_y, nearest) >= least:
            return to_x, to_y, True
        return x, y, True

    def _needs_plan(self, time: float) -> bool:
        """Update the last progress and drop the passed points of the path; return whether another path is needed."""
        x, y, _ = self.pose
        if math.hypot(x - self.progress[0], y - self.progress[1]) > 0.1:
            self.progress = (x, y, time)
        if not len(self.path) or time - self.progress[2] > STUCK_AFTER:
            return True
        away = [math.hypot(px - x, py - y) for px, py in self.path[:SEARCHED_POINTS].tolist()]
        self.path = self.path[away.index(min(away)) :]
        end_x, end_y = self.path[-1].tolist()
        return len(self.path) < GOAL_POINTS and math.hypot(end_x - x, end_y - y) < ARRIVED

    def velocities(self) -> tuple[float, float]:
        """Return the linear and angular velocity, m/s and rad/s, for following the path."""
        x, y, yaw = self.pose
        target_x, target_y = self._target()
        bearing = math.remainder(math.atan2(target_y - y, target_x - x) - yaw, 2.0 * math.pi)
        distance = max(0.3, math.hypot(target_x - x, target_y - y))
        clearance = nearest_edge(self.segments, x, y, np.zeros(2))
        speed = CAREFUL + (CRUISE - CAREFUL) * min(1.0, max(0.0, (clearance - 0.4) / (OPEN - 0.4)))
        # Pure pursuit: the arc through the target has curvature 2 sin(α) / distance.
        facing = max(0.0, math.cos(bearing)) ** 2 if abs(bearing) < 1.2 else 0.0
        linear = speed * facing
        curvature = 2.0 * math.sin(bearing) / distance
        if facing > 0.0 and abs(curvature) * linear > MAX_ANGULAR:
            linear = MAX_ANGULAR / abs(curvature)
        angular = linear * curvature if facing > 0.3 else 2.0 * bearing
        angular = max(-MAX_ANGULAR, min(MAX_ANGULAR, angular))
        needed = min(self.radius + SPARE, clearance) - 1e-6
        for _ in range(3):
            if arc_clearance(self.segments, x, y, yaw, linear, angular, MOTION_S, MOTION_SAMPLES) >= needed:
                return linear, angular
            linear *= 0.5
        return 0.0, 2.0 * bearing

    def _target(self) -> tuple[float, float]:
        """Return the farthest point of the path within the lookahead that the robot can reach in a straight line."""
        x, y, _ = self.pose
        ahead = min(len(self.path) - 1, LOOKAHEAD_POINTS)
        for spare in (0.1, MARGIN / 2):
            i = farthest_in_sight(self.segments, x, y, self.path, ahead, self.radius + spare)
            if i > 0:
                return float(self.path[i, 0]), float(self.path[i, 1])
        i = min(1, ahead)
        return float(self.path[i, 0]), float(self.path[i, 1])


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


def _towards(value: float, target: float, step: float) -> float:
    return value + _clip(target - value, step)
