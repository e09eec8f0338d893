"""Levelling of poses in a tilted fixed frame, such as that of a camera tracker's start, because maps need a level
one.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mapper.io.logs.recording.pose_sources import PoseSource
from mapper.io.logs.recording.poses3 import Poses3, rotated
from mapper.io.logs.recording.timeline import Moments

LEAST_TILT = math.radians(15.0)  #: mean tilt of the robot's z axis; ramps are less steep
STEADY = 0.98  #: length of the mean z axis of a robot that stays upright; it is less for one that tips over
LEAST_WAY_M = 0.5  #: minimum path length to determine the plane of motion
FLAT = 0.2  #: maximum rise as a fraction of that path
MOST = 1000  #: maximum number of poses examined


def levelled(source: PoseSource) -> tuple[PoseSource, float] | None:
    """Return a source in a frame in which the robot is upright, and the tilt, radians.

    None if it is already upright (frames are level by REP 105), and if its base does not move perpendicularly to its z
    axis, as with an optical frame mistaken for the base.
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
    # The shortest rotation from that axis to vertical; upside-down, half a turn about x.
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
