"""A recording of a lidar that drives and turns through the points of a real cloud, in messages of several layouts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.mapper.io.logs.recorded import SECOND, Said, cloud, transform, written

T0 = 1_700_000_000 * SECOND
SWEEP_S = 0.1
SPEED, TURN = 1.0, 1.5  #: m/s, rad/s
XYZ = [("x", "f4"), ("y", "f4"), ("z", "f4")]
#: Fields, byte order, rows and padding of the messages, in turn, as drivers have them: Ouster, Velodyne, Hesai, Livox.
LAYOUTS = (
    ([*XYZ, ("intensity", "f4"), ("t", "u4"), ("ring", "u1")], "<", 8, (3, 0)),
    ([("ring", "u2"), ("z", "f8"), ("x", "f8"), ("y", "f8"), ("time", "f4")], ">", 1, (0, 5)),
    ([*XYZ, ("timestamp", "f8")], "<", 1, (4, 0)),
    ([("offset_time", "u4"), *XYZ, ("tag", "u1")], ">", 4, (0, 0)),
)


def poses(seconds: np.ndarray) -> np.ndarray:
    """``T_odom_velodyne`` (n, 4, 4): the sensor is 0.5 m above a base that drives an arc."""
    yaw = TURN * seconds
    out = np.tile(np.eye(4), (len(seconds), 1, 1))
    out[:, :3, :3] = Rotation.from_euler("z", yaw[:, None]).as_matrix()
    out[:, 0, 3], out[:, 1, 3] = SPEED / TURN * np.sin(yaw), SPEED / TURN * (1.0 - np.cos(yaw))
    out[:, 2, 3] = 0.5
    return out


@dataclass(frozen=True, slots=True)
class MovingLidar:
    """The file, and for each of its clouds the points (n, 3) where they are in the world."""

    path: Path
    truth: list[np.ndarray]
    origins: np.ndarray


def record(folder: Path, world: np.ndarray, kind: str, sweeps: int = 4) -> MovingLidar:
    """Record the points (n, 3) of the world, dealt out to the sweeps, as a file of this kind."""
    said: list[Said] = [transform(T0, "base_link", "velodyne", z=0.5, topic="/tf_static")]
    end = sweeps * SWEEP_S
    for second in np.arange(0.0, end + 0.03, 0.02):
        at = poses(np.array([second]))[0]
        stamp = T0 + round(second * SECOND)
        said.append(transform(stamp, "odom", "base_link", at[0, 3], at[1, 3], TURN * second))
    truth = []
    for k in range(sweeps):
        layout, order, rows, padding = LAYOUTS[k % len(LAYOUTS)]
        mine = world[k::sweeps]
        mine = mine[: len(mine) // 8 * 8]
        begin = k * SWEEP_S
        bearing = np.arctan2(mine[:, 1], mine[:, 0])
        mine = mine[np.argsort(bearing)]
        after = np.linspace(0.0, SWEEP_S, len(mine), endpoint=False)
        back = np.linalg.inv(poses(begin + after))
        seen = np.einsum("nij,nj->ni", back[:, :3, :3], mine) + back[:, :3, 3]
        stamp = T0 + round(begin * SECOND)
        times = {
            "t": np.round(after * 1e9), "offset_time": np.round(after * 1e9),
            "time": after, "timestamp": stamp * 1e-9 + after,
        }  # fmt: skip
        said.append(cloud(stamp, seen, layout=layout, order=order, rows=rows, padding=padding, others=times))
        truth.append(mine)
    said.sort(key=lambda one: one.stamp_ns)
    return MovingLidar(written(folder, said, kind), truth, poses(SWEEP_S * np.arange(sweeps))[:, :3, 3])
