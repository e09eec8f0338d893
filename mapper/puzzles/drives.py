"""Simulated drives for puzzles: with poses at all times, sweeps that take time, and furniture that is removed."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import LaserScan, ScanLog, Trajectory
from mapper.sensors.timed_poses import TimedPoses
from mapper.simulation.edits import Drawn, Edits, edited
from mapper.simulation.faults import lengthened, with_lengthened
from mapper.simulation.floor_plans import WORLDS
from mapper.simulation.kernels.driving import STEP
from mapper.simulation.kernels.lidar import cast_rays
from mapper.simulation.lidar import RANGE_MIN, SensorConfig
from mapper.simulation.odometry import drifting_odometry
from mapper.simulation.robot import PoseTuple
from mapper.simulation.simulation import Simulation

LIDAR = SensorConfig(n_beams=360, range_max=8.0, range_noise=0.01, scan_rate=2.5)
SHORT_LIDAR = SensorConfig(n_beams=360, range_max=4.0, range_noise=0.01, scan_rate=2.5)
SONARS = SensorConfig(kind="sonar_ring", n_sonars=16, range_max=4.0, range_noise=0.01, scan_rate=2.5)
MOVED_AFTER = 0.85  #: fraction of the scans after which furniture is gone
SWEEP_BEAMS = 10  #: beams of a scan that takes time, measured from one pose
TRUE, ODOMETRY = "cameras", "odometry"
KEPT = 8  #: cached drives
Step = Callable[[float], None]
"""Called from time to time with the completed fraction of a drive, 0 to 1; may raise to cancel the drive."""
_Made = tuple[str, int, int, SensorConfig, tuple[Drawn, ...]]
_drives: OrderedDict[_Made, ScanLog] = OrderedDict()
_keeping = threading.Lock()


def drive(
    world: str,
    seed: int,
    n_scans: int,
    sensor: SensorConfig = LIDAR,
    moved: tuple[Drawn, ...] = (),
    step: Step = lambda _: None,
) -> ScanLog:
    """Return a simulated drive of ``n_scans`` scans, deterministic for its arguments, and cached.

    Its trajectories are "cameras", the true poses, including those between the scans, and "odometry", which drifts
    slightly. The solids in ``moved`` are in the world until :data:`MOVED_AFTER` of the scans are taken.
    """
    key = (world, seed, n_scans, sensor, moved)
    with _keeping:
        known = _drives.get(key)
    driven = _driven(world, seed, n_scans, sensor, moved, step) if known is None else known
    with _keeping:
        _drives[key] = driven
        _drives.move_to_end(key)
        if len(_drives) > KEPT:
            _drives.popitem(last=False)
    return driven


def _driven(world: str, seed: int, n_scans: int, sensor: SensorConfig, moved: tuple[Drawn, ...], step: Step) -> ScanLog:
    plan = WORLDS[world]
    simulation = Simulation(edited(plan, Edits(moved)) if moved else plan, sensor, seed)
    stamps, poses = [0], [simulation.robot.pose]
    scans: list[LaserScan] = []
    at_scans: list[PoseTuple] = []
    while len(scans) < n_scans:
        step(len(scans) / n_scans)
        for scan, pose in simulation.advance(STEP):
            scans.append(scan)
            at_scans.append(pose)
            if moved and len(scans) == round(MOVED_AFTER * n_scans):
                simulation.alter_world(plan)
        stamps.append(round(simulation.steps * STEP * 1e9))
        poses.append(simulation.robot.pose)
    true = np.array(at_scans)
    timed = TimedPoses(np.array(stamps), np.array(poses))
    return ScanLog(
        np.array([scan.ranges for scan in scans]),
        sensor.angle_min,
        sensor.angle_increment,
        RANGE_MIN,
        sensor.range_max,
        np.array([scan.stamp_ns for scan in scans]),
        {
            TRUE: Trajectory(true, "Measured by cameras on the ceiling.", "map", timed=timed),
            ODOMETRY: Trajectory(
                drifting_odometry(true, np.random.default_rng(seed)), "What the wheels report.", "odom"
            ),
        },
        beam_width=sensor.cone,
        name=plan.title,
        format="simulation",
    )


def polished(log: ScanLog, world: str, sensor: SensorConfig = LIDAR) -> ScanLog:
    """Return a drive as reported by its sensor if long walls are polished."""
    plan, poses = WORLDS[world], log.sensor_poses(TRUE)
    longer = np.array([lengthened(plan, sensor, pose) for pose in poses])
    return _with_ranges(log, with_lengthened(log.ranges, longer, sensor.range_max))


def swept(log: ScanLog, world: str, sensor: SensorConfig = LIDAR) -> ScanLog:
    """Return a drive in which a scan takes as long as the time to the next one, without noise.

    Beam i is measured at stamp + i · time_increment, from the robot's pose then, with :data:`SWEEP_BEAMS` beams per
    pose.
    """
    plan, step = WORLDS[world], 1.0 / (sensor.scan_rate * sensor.n_beams)
    first = np.arange(0, sensor.n_beams, SWEEP_BEAMS)
    times = seconds(log)[:, np.newaxis] + step * (first + 0.5 * (SWEEP_BEAMS - 1))
    laser = compose(Motion.of(log, TRUE).at(times), np.array(log.mount))
    ranges = np.empty(log.ranges.shape)
    part = np.empty(SWEEP_BEAMS)
    for scan in range(log.n_scans):
        for k, beam in enumerate(first):
            x, y, yaw = (float(v) for v in laser[scan, k])
            start = sensor.angle_min + float(beam) * sensor.angle_increment
            cast_rays(plan.seen, x, y, yaw, start, sensor.angle_increment, sensor.range_max, part)
            ranges[scan, beam : beam + SWEEP_BEAMS] = part
    return replace(_with_ranges(log, ranges), time_increment=step)


def _with_ranges(log: ScanLog, ranges: NDArray[np.float64] | NDArray[np.float32]) -> ScanLog:
    return replace(log, ranges=np.asarray(ranges, dtype=np.float32))
