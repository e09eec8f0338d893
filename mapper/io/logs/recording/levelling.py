"""Poses in a fixed frame that is not level, as of a camera that tracks from where it began: a map needs a level one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mapper.io.logs.recording.pose_sources import PoseSource
from mapper.io.logs.recording.poses3 import Poses3, rotated
from mapper.io.logs.recording.timeline import Moments

LEAST_TILT = math.radians(15.0)  #: of the robot's z axis, on average; ramps are less steep
STEADY = 0.98  #: length of the mean z axis of a robot that stays upright: of one that tips over it is less
LEAST_WAY_M = 0.5  #: that tells in which plane the robot moves
FLAT = 0.2  #: of that way is the most that it rises
MOST = 1000  #: poses that are looked at


def levelled(source: PoseSource) -> tuple[PoseSource, float] | None:
    """Return a source in whose frame the robot stands upright, and by how much it was tilted, radians.

    None where it stands upright as it is (REP 105 has level frames), and where its base does not move perpendicularly
    to its z axis, as an optical frame does that is taken for the base.
    """
    stated = source.stated()
    if stated is None or not len(stated.counted_ns):
        return None
    times = stated.counted_ns
    some = source.at(Moments(times[:: 1 + len(times) // MOST]))
    up = rotated(some.rotations, np.array([[0.0, 0.0, 1.0]])).mean(axis=0)
    length = float(np.linalg.norm(up))
    tilt = math.acos(min(1.0, max(-1.0, float(up[2]) / max(length, STEADY))))
    if length < STEADY or tilt < LEAST_TILT:
        return None
    # The shortest turn from that axis to straight up; upside-down, half a turn about x.
    turn = np.array([[up[1], -up[0], 0.0, length + up[2]]])
    turn = np.array([[1.0, 0.0, 0.0, 0.0]]) if not turn[0, 3] > 1e-6 else turn / np.linalg.norm(turn)
    level = Poses3(np.zeros((1, 3)), turn)
    along, across, rise = np.ptp((level @ some).positions, axis=0)
    if math.hypot(along, across) < LEAST_WAY_M or rise > FLAT * math.hypot(along, across):
        return None
    poses = (level @ source.at(Moments(times))).planar
    return (
        replace(source, at=lambda when: level @ source.at(when), stated=lambda: replace(stated, poses=poses)),
        tilt,
    )
