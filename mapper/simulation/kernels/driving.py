"""Motion of the simulated robot: physics steps and path following between two plans, in one call.

Twin of :mod:`mapper.simulation.textbook_driving`, to the last bit, because the paths of recorded stories depend on it.
"""

from __future__ import annotations

import math

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.jit import jit
from mapper.simulation.kernels.raycast import arc_clearance, farthest_in_sight, nearest_edge

STEP = 0.02  #: seconds of one physics step
CONTROL_STEPS = 2  #: physics steps between two decisions of the explorer
NOTE_STEPS = 25  #: physics steps between two records of the robot's position

MAX_LINEAR = 1.0  #: m/s
MAX_ANGULAR = 1.5  #: rad/s
LINEAR_ACCELERATION = 1.2  #: m/s²
BRAKING = 2.0  #: m/s²
ANGULAR_ACCELERATION = 5.0  #: rad/s²
STALLED = 0.3  #: fraction of the commanded speed below which the robot stops at a wall instead of sliding along it
SKIN = 1e-4  #: metres kept from every wall, so that rounding never lets the robot touch

CRUISE, CAREFUL = 0.9, 0.6  #: m/s in the open and between walls
MARGIN = 0.03  #: metres beyond the radius that a path needs everywhere
SPARE = 0.005  #: metres beyond the radius that the next half second needs
LOOKAHEAD_POINTS = 6  #: points of a path, 0.1 m from one to the next, within the lookahead
SEARCHED_POINTS = 20  #: points of a path among which the nearest to the robot is searched
GOAL_POINTS = 14  #: points before its end up to which a path is not examined
ARRIVED = 0.7  #: metres before a goal at which the next is chosen, so that the robot does not stop
STUCK_AFTER = 2.5  #: seconds without progress after which the goal is dropped
OPEN = 0.9  #: metres of clearance above which the robot is in open space

MOTION_S, MOTION_SAMPLES = 0.5, 5  #: the motion tested ahead: seconds, and number of positions after the first
MOVED = 0.2  #: metres along an axis after which the nearby edges are selected again
REACH = MOVED + MAX_LINEAR * MOTION_S + 0.05  #: metres along each axis within which positions are tested against them

#: State of a robot that :func:`drive` modifies: ``T_map_base`` (m, m, rad) now and a step ago, velocities (m/s, rad/s),
#: the commanded ones, the position (m, m) and the time (s) of its last progress, and the first point of the path that
#: is not behind it.
(
    X, Y, YAW, LINEAR, ANGULAR, WANTED_LINEAR, WANTED_ANGULAR, PROGRESS_X, PROGRESS_Y, PROGRESS_TIME,
    BEFORE_X, BEFORE_Y, BEFORE_YAW, FIRST,
) = range(14)  # fmt: skip

#: Known steering input at the first step: nothing, a new path, or the commanded velocities.
NOTHING, PATH, VELOCITIES = 0, 1, 2


@jit
def _hypot(x: float, y: float) -> float:
    """Return √(x² + y²), correctly rounded except in rare cases, like Python's ``math.hypot``.

    Source: Borges, An improved algorithm for hypot(a, b), 2019, as in CPython 3.11. The C library's function differs in
    the last bit in one of two hundred cases.
    """
    x, y = abs(x), abs(y)
    greatest = max(x, y)
    if greatest == 0.0 or not math.isfinite(greatest):
        return greatest
    shift = 2.0**600 if greatest < 2.0**-500 else 1.0  # the scale of the smallest numbers would be infinite
    x, y, greatest = x * shift, y * shift, greatest * shift
    scale = 2.0 ** -math.frexp(greatest)[1]
    total, rest_1, rest_2, rest_3 = 1.0, 0.0, 0.0, 0.0
    for value in (x * scale, y * scale):
        high, low = _halves(value)
        total, rest_1 = _added(total, rest_1, high * high)
        total, rest_2 = _added(total, rest_2, 2.0 * high * low)
        rest_3 += low * low
    root = math.sqrt(total - 1.0 + (rest_1 + rest_2 + rest_3))
    high, low = _halves(root)
    total, rest_1 = _added(total, rest_1, -high * high)
    total, rest_2 = _added(total, rest_2, -2.0 * high * low)
    total, rest_3 = _added(total, rest_3, -low * low)
    error = total - 1.0 + (rest_1 + rest_2 + rest_3)
    return (root + error / (2.0 * root)) / scale / shift


@jit
def _halves(value: float) -> tuple[float, float]:
    """Split a number into the sum of two with half of its digits each (Veltkamp)."""
    t = value * 134217729.0
    high = t - (t - value)
    return high, value - high


@jit
def _added(total: float, rest: float, value: float) -> tuple[float, float]:
    """Return ``total`` + ``value``, rounded, and ``rest`` plus the rounding error; |total| ≥ |value|."""
    after = total + value
    return after, rest + ((total - after) + value)


@jit
def _half_turned(angle: float) -> float:
    """Wrap an angle within ±3π to [−π, π]: IEEE 754's remainder by 2π, which is exact here."""
    if angle > math.pi:
        return angle - 2.0 * math.pi
    return angle + 2.0 * math.pi if angle < -math.pi else angle


@jit
def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


@jit
def _near_by(segments: Float64Array, radius: float, x: float, y: float) -> Float64Array:
    """Return the edges, in order, that affect positions within :data:`REACH` of (x, y) along both axes.

    These are the edges within the maximum distance of any decision, and those that a ray to the right, by which
    :func:`nearest_edge` detects the inside of solids, may cross. All edges are returned if the robot does not fit.
    """
    room = REACH + max(OPEN, radius + 0.1) + 1e-6
    near = np.empty((segments.shape[0], 4))
    count = 0
    for k in range(segments.shape[0]):
        ax, ay, bx, by = segments[k, 0] - x, segments[k, 1] - y, segments[k, 2] - x, segments[k, 3] - y
        right, low, high = max(ax, bx), min(ay, by), max(ay, by)
        is_close = (min(ax, bx) <= room) & (right >= -room) & (low <= room) & (high >= -room)
        may_be_crossed = (right >= -room) & (low <= REACH + 1e-6) & (high >= -REACH - 1e-6)
        for i in range(4):
            near[count, i] = segments[k, i]
        count += 1 if is_close | may_be_crossed else 0
    return near[:count] if nearest_edge(near[:count], x, y, np.zeros(2)) >= radius else segments


@jit
def _kept_free(
    segments: Float64Array, radius: float, x: float, y: float, to_x: float, to_y: float
) -> tuple[float, float, bool]:
    """Return a position near (to_x, to_y) where the robot fits, and whether a wall blocked the motion from (x, y)."""
    least = radius + SKIN
    nearest = np.zeros(2)
    touched = False
    for _ in range(3):  # a corner has two walls; a position that three corrections do not free is too tight
        clearance = nearest_edge(segments, to_x, to_y, nearest)
        if clearance >= least:
            return to_x, to_y, touched
        touched = True
        if clearance <= 0.0:
            break
        push = (least - clearance + 1e-9) / clearance
        to_x += (to_x - nearest[0]) * push
        to_y += (to_y - nearest[1]) * push
    if nearest_edge(segments, to_x, to_y, nearest) >= least:
        return to_x, to_y, True
    return x, y, True


@jit
def _step(segments: Float64Array, radius: float, state: Float64Array) -> None:
    """Move for a :data:`STEP` towards the commanded velocities.

    See :meth:`mapper.simulation.textbook_driving.Drive.step`.
    """
    before, target = state[LINEAR], state[WANTED_LINEAR]
    slowing = abs(target) < abs(before) or target * before < 0.0
    rate = BRAKING if slowing else LINEAR_ACCELERATION
    linear = before + _clip(_clip(target, MAX_LINEAR) - before, rate * STEP)
    angular = state[ANGULAR]
    angular += _clip(_clip(state[WANTED_ANGULAR], MAX_ANGULAR) - angular, ANGULAR_ACCELERATION * STEP)
    x, y, yaw = state[X], state[Y], state[YAW]
    heading = yaw + 0.5 * angular * STEP
    to_x, to_y = x + linear * STEP * math.cos(heading), y + linear * STEP * math.sin(heading)
    to_x, to_y, touched = _kept_free(segments, radius, x, y, to_x, to_y)
    moved = _hypot(to_x - x, to_y - y) / STEP
    if touched and moved < STALLED * abs(linear):
        linear = math.copysign(moved, linear)  # pushing against a wall stops the wheels
    state[LINEAR], state[ANGULAR] = linear, angular
    state[BEFORE_X], state[BEFORE_Y], state[BEFORE_YAW] = x, y, yaw
    state[X], state[Y], state[YAW] = to_x, to_y, _half_turned(yaw + angular * STEP)


@jit
def _needs_plan(path: Float64Array, time: float, state: Float64Array) -> bool:
    """Update the last progress and the first point of the path at ``time``, seconds; return whether a path is needed.

    A robot has made progress once it is 0.1 m from the position of its last progress. It needs another path if it has
    none, has made no progress for :data:`STUCK_AFTER`, or is nearer than :data:`ARRIVED` to the end of its path.
    """
    x, y = state[X], state[Y]
    if _hypot(x - state[PROGRESS_X], y - state[PROGRESS_Y]) > 0.1:
        state[PROGRESS_X], state[PROGRESS_Y], state[PROGRESS_TIME] = x, y, time
    first, n = int(state[FIRST]), path.shape[0]
    if first >= n or time - state[PROGRESS_TIME] > STUCK_AFTER:
        return True
    near, least = first, np.inf
    for i in range(first, min(first + SEARCHED_POINTS, n)):
        away = _hypot(path[i, 0] - x, path[i, 1] - y)
        if away < least:
            near, least = i, away
    state[FIRST] = near
    return n - near < GOAL_POINTS and _hypot(path[n - 1, 0] - x, path[n - 1, 1] - y) < ARRIVED


@jit
def _steer(
    segments: Float64Array, near: Float64Array, radius: float, path: Float64Array, state: Float64Array, two: float
) -> None:
    """Command velocities for following the path; ``near`` is :func:`_near_by` of ``segments``, ``two`` is 2.

    See :meth:`mapper.simulation.textbook_driving.Drive.velocities`.
    """
    x, y, yaw = state[X], state[Y], state[YAW]
    left = path[int(state[FIRST]) :]
    ahead = min(left.shape[0] - 1, LOOKAHEAD_POINTS)
    beside = near
    for i in range(1, ahead + 1):
        if not (abs(left[i, 0] - x) <= REACH - MOVED and abs(left[i, 1] - y) <= REACH - MOVED):
            beside = segments
    target = farthest_in_sight(beside, x, y, left, ahead, radius + 0.1)
    if target == 0:
        target = farthest_in_sight(beside, x, y, left, ahead, radius + MARGIN / 2)
    if target == 0:
        target = min(1, ahead)
    target_x, target_y = left[target, 0], left[target, 1]
    bearing = _half_turned(math.atan2(target_y - y, target_x - x) - yaw)
    distance = max(0.3, _hypot(target_x - x, target_y - y))
    clearance = nearest_edge(near, x, y, np.zeros(2))
    speed = CAREFUL + (CRUISE - CAREFUL) * min(1.0, max(0.0, (clearance - 0.4) / (OPEN - 0.4)))
    # A power with an exponent unknown to the compiler, as in Python; a product sometimes differs in the last bit.
    facing = max(0.0, math.cos(bearing)) ** two if abs(bearing) < 1.2 else 0.0
    linear = speed * facing
    curvature = 2.0 * math.sin(bearing) / distance
    if facing > 0.0 and abs(curvature) * linear > MAX_ANGULAR:
        linear = MAX_ANGULAR / abs(curvature)
    angular = linear * curvature if facing > 0.3 else 2.0 * bearing
    angular = max(-MAX_ANGULAR, min(MAX_ANGULAR, angular))
    needed = min(radius + SPARE, clearance) - 1e-6
    for _ in range(3):
        if arc_clearance(near, x, y, yaw, linear, angular, MOTION_S, MOTION_SAMPLES) >= needed:
            state[WANTED_LINEAR], state[WANTED_ANGULAR] = linear, angular
            return
        linear *= 0.5
    state[WANTED_LINEAR], state[WANTED_ANGULAR] = 0.0, 2.0 * bearing


@jit
def drive(
    segments: Float64Array,
    radius: float,
    path: Float64Array,
    state: Float64Array,
    steps: int,
    count: int,
    next_scan: float,
    known: int,
    two: float,
) -> int:
    """Take up to ``count`` physics steps after the first ``steps``; return the number taken.

    ``segments`` (n, 4) as in :mod:`mapper.simulation.kernels.raycast`, ``radius`` metres, ``path`` (n, 2) metres;
    ``state`` (14,) is modified. It ends early before a decision that needs another path, after a step at which a scan
    is due at ``next_scan`` seconds, and after a step at which the explorer records the robot's position. ``known`` is
    the known input of the first decision; ``two`` is 2.
    """
    near = segments
    centre_x = centre_y = np.nan
    for done in range(count):
        number = steps + done
        x, y = state[X], state[Y]
        if known != VELOCITIES and not (abs(x - centre_x) <= MOVED and abs(y - centre_y) <= MOVED):
            centre_x, centre_y = x, y
            near = _near_by(segments, radius, x, y)
        if number % CONTROL_STEPS == 0 and known != VELOCITIES:
            if known == NOTHING and _needs_plan(path, number * STEP, state):
                return done
            _steer(segments, near, radius, path, state, two)
        if known == PATH:
            known = NOTHING
        _step(near, radius, state)
        if number % NOTE_STEPS == 0 or (number + 1) * STEP >= next_scan - 1e-9:
            return done + 1
    return count
