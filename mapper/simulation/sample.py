"""Sample log for visitors: a simulated run through an office."""

from __future__ import annotations

import numpy as np

from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation.floor_plans import WORLDS
from mapper.simulation.lidar import RANGE_MIN, SensorConfig
from mapper.simulation.odometry import drifting_odometry
from mapper.simulation.simulation import Simulation

SAMPLE_SENSOR = SensorConfig(n_beams=360, range_max=8.0, range_noise=0.01, scan_rate=2.5)


def sample_log(n_scans: int = 600, world: str = "office", seed: int = 5) -> ScanLog:
    """Return a simulated run of ``n_scans`` scans (600: four minutes), deterministic for its arguments.

    It has two trajectories: "true", and "odometry", with wheel drift.
    """
    simulation = Simulation(WORLDS[world], SAMPLE_SENSOR, seed)
    scans = simulation.advance((n_scans + 1) / SAMPLE_SENSOR.scan_rate)[:n_scans]
    poses = np.array([pose for _, pose in scans])
    odometry = drifting_odometry(poses, np.random.default_rng(seed))
    return ScanLog(
        np.array([scan.ranges for scan, _ in scans]),
        SAMPLE_SENSOR.angle_min,
        SAMPLE_SENSOR.angle_increment,
        RANGE_MIN,
        SAMPLE_SENSOR.range_max,
        np.array([scan.stamp_ns for scan, _ in scans]),
        {
            "true": Trajectory(poses, "Where the simulated robot truly was.", "map"),
            "odometry": Trajectory(odometry, "What its wheels report: the truth with a drift that grows.", "odom"),
        },
        name=f"A simulated run: {WORLDS[world].title.lower()}",
        format="simulation",
        notes=("A simulated log: the robot drove by itself, and its true poses are known.",),
    )
