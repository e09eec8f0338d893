"""Mounts of a recording's sensors on the robot, at each of their scans."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.io.logs.recording.cutting import IMAGE, is_forward
from mapper.io.logs.recording.poses3 import Poses3, identity
from mapper.io.logs.recording.sensor_scans import SensorScans
from mapper.io.logs.recording.taken import Taken
from mapper.io.logs.recording.transforms import FrameTree
from mapper.io.logs.ros.cloud_messages import CLOUD_DECODERS

#: ``T_optical_scan``: a camera looks along z, with x to the right (REP 103); a scan has x forward and y left.
AHEAD_IN_OPTICAL = Poses3(np.zeros((1, 3)), np.array([[0.5, -0.5, 0.5, 0.5]]))
MOVED_M, MOVED_RAD = 0.002, 0.002  #: a sensor that moves no more than this on the robot has a fixed mount
LEVEL = 0.9986  #: z component of the z axis of a sensor tilted by 3°
TILTED = 0.01  #: variation of the z component of a frame's z axis above which the sensor tilts


@dataclass(frozen=True, slots=True)
class Mounting:
    """``mount`` (m, m, rad) is ``T_base_sensor`` at the first scan, ``mounts`` (n_scans, 3) at each if it moves.

    ``tilting`` are the sensor's poses in the base frame at each scan if it tilts, so that its scans are not level.
    """

    mount: tuple[float, float, float]
    mounts: NDArray[np.float64] | None
    upside_down: bool
    tilting: Poses3 | None
    notes: list[str]


def mounting_of(taken: Taken, tree: FrameTree, base: str, sensor: SensorScans) -> Mounting:
    """Return the mount of a sensor on the robot with base frame ``base``, from the transforms in ``tree``."""
    notes = _notes_on_frames(taken, tree, base, sensor)
    when = sensor.moments
    if sensor.kind in CLOUD_DECODERS:
        mounts = sensor.mounts
        return _mounting(mounts, False, None, [*notes, *_note_on_moving(tree, base, sensor, mounts)])
    poses = tree.relative(sensor.frame, base, when) or identity()
    if sensor.kind == IMAGE and base != sensor.frame and is_forward(poses.up):
        poses = poses @ AHEAD_IN_OPTICAL
    up = poses.up
    if float(np.ptp(up)) > TILTED and sensor.kind != IMAGE and sensor.beam_width == 0.0:
        level = np.column_stack([poses.positions[:, :2], np.zeros(len(up))])
        tilt = np.degrees(np.arccos(np.clip(np.abs(up), 0.0, 1.0)))
        notes.append(
            f"The sensor tilts by {tilt.min():.0f}° to {tilt.max():.0f}°: each scan is cut to a level one by the "
            "heights of its points, as a cloud is."
        )
        return _mounting(level, False, poses, notes)
    planar = poses.planar
    notes += _note_on_moving(tree, base, sensor, planar)
    upright = min(1.0, abs(float(up[0])))
    if upright < LEVEL:
        tilt = np.degrees(np.arccos(upright))
        farther = f"up to {100.0 * (1.0 / upright - 1.0):.1f} % too far away" if upright > 0.5 else "at wrong distances"
        notes.append(
            f"The sensor is tilted by {tilt:.0f}°, in all scans alike. The map takes it to be level: walls are drawn "
            f"{farther}, and where it looks down the floor is drawn as a wall."
        )
    missing = int(np.count_nonzero(~tree.covers_relative(sensor.frame, base, when))) if _moves(planar) else 0
    if missing:
        notes.append(
            f"{missing} scan{'s are' if missing > 1 else ' is'} before the first or after the last transform of the "
            "moving sensor, and taken from the nearest."
        )
    return _mounting(planar, bool(up[0] < 0.0), None, notes)


def is_assumed(taken: Taken, tree: FrameTree, base: str, sensor: SensorScans) -> bool:
    """Return whether no transform states the mount of a sensor, so that it is assumed at the robot's centre."""
    return base == sensor.frame and bool(tree.frames) and not tree.is_base(base, taken.children)


def _mounting(mounts: NDArray[np.float64], upside_down: bool, tilting: Poses3 | None, notes: list[str]) -> Mounting:
    x, y, yaw = (float(value) for value in mounts[0])
    return Mounting((x, y, yaw), mounts if _moves(mounts) else None, upside_down, tilting, notes)


def _moves(mounts: NDArray[np.float64]) -> bool:
    """Return whether any of the mounts (n, 3) differs from the first."""
    far, turn = _greatest_change(mounts)
    return far > MOVED_M or turn > MOVED_RAD


def _greatest_change(mounts: NDArray[np.float64]) -> tuple[float, float]:
    """Return the maximum difference of the mounts (n, 3) from the first, metres and radians."""
    away = mounts - mounts[0]
    turn = np.abs(np.mod(away[:, 2] + np.pi, 2.0 * np.pi) - np.pi)
    return float(np.hypot(away[:, 0], away[:, 1]).max()), float(turn.max())


def _note_on_moving(tree: FrameTree, base: str, sensor: SensorScans, mounts: NDArray[np.float64]) -> list[str]:
    if not _moves(mounts):
        return []
    far, turn = _greatest_change(mounts)
    by = f"by up to {far:.2f} m and {np.degrees(turn):.0f}°"
    replaced = tree.replaced_statics(tree.path(sensor.frame, base) or ())
    if replaced:
        frames = ", ".join(f"{frame!r:.100}" for frame in replaced[:4])
        note = f"While it was recorded, static transforms were replaced ({frames}), and the sensor’s mount changed {by}"
        return [f"{note}: each scan has the mount that held when it came."]
    return [f"The frame {sensor.frame!r:.100} moves on the robot, {by}; each scan has the mount at its stamp."]


def _notes_on_frames(taken: Taken, tree: FrameTree, base: str, sensor: SensorScans) -> list[str]:
    notes = []
    loop = tree.loop_above(sensor.frame)
    if loop:
        frames = " in ".join(frame[:100] for frame in loop[:8])
        notes.append(f"The transforms form a loop, {frames}: they are followed up to {loop[-2]!r:.100}.")
    if sensor.frame in taken.unplaced:
        notes.append(
            f"tf did not say where the frame {sensor.frame!r} sits on the robot before its clouds were cut: their "
            "heights are those in that frame."
        )
    if is_assumed(taken, tree, base, sensor):
        alike = tree.named_alike(base)
        has = f", only where {', '.join(map(repr, alike))} sits" if alike else ""
        what = f"tf does not say where the frame {base!r} sits on the robot{has}"
        if not base:
            what = "The scans name no frame (frame_id is empty), so tf cannot say where they were made on the robot"
        notes.append(
            f"{what}; the sensor is taken to be at its centre, looking ahead. If it is not, set mount_x, mount_y and "
            "mount_yaw."
        )
    return notes
