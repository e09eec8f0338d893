"""SLAM of a long log in a process of its own: cancelled over HTTP it ends at once, and the log stays as it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mapper.sensors.scan import ScanLog
from tests.mapper.slam.worlds import along, drive
from tests.server.service import once_read, running, settings_for, until

ROOM = [(3.4, 3.6), (6.4, 3.6), (6.4, 5.4), (3.4, 5.4), (3.4, 3.6)]
ROUNDS = 40  #: of the same scans: SLAM of them takes many seconds


def carmen_of(log: ScanLog, rounds: int) -> bytes:
    """The scans again and again as a CARMEN log of half a circle."""
    lines, odometry = [], log.trajectory("true").poses
    for k in range(rounds * log.n_scans):
        ranges = " ".join(f"{min(float(r), 81.0):.3f}" for r in np.nan_to_num(log.ranges[k % log.n_scans], posinf=81.0))
        pose = " ".join(f"{value:.4f}" for value in odometry[k % log.n_scans])
        lines.append(f"FLASER {log.n_beams} {ranges} {pose} {pose} {0.2 * k:.1f} robot {0.2 * k:.1f}\n")
    return "".join(lines).encode()


def test_a_cancelled_job_of_a_long_log_ends_and_the_log_stays_usable(tmp_path: Path) -> None:
    data = carmen_of(drive("room", along(ROOM, 0.3)), ROUNDS)
    with running(settings_for(tmp_path)) as service:
        http = service.http
        log_id = http.put("/api/logs", params={"name": "long.log"}, content=data).json()["id"]
        before = once_read(http, log_id)
        address = f"/api/logs/{log_id}/slam"
        assert http.post(address, json={}).status_code == 202
        until(lambda: 0.0 < http.get(address).json()["fraction"] < 0.5)
        assert http.delete(address).json()["state"] == "cancelled"
        assert http.get(address).json()["state"] == "cancelled"
        assert http.get(f"/api/logs/{log_id}").json() == before
        service.begin(kind="log", log=log_id, playing=False)
