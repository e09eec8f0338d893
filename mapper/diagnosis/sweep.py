"""Check of the motion within a scan: whether the log's time between beams is correct."""

from __future__ import annotations

from dataclasses import replace

from mapper.diagnosis.consistency import Examined, consistency
from mapper.diagnosis.finding import Finding
from mapper.diagnosis.timing import BETTER, BY
from mapper.sensors.joint_log import sensors_of, with_trajectories
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses

CHECK = "timing.increment"
DELAYS_S = (-0.3, -0.2, -0.1, -0.05, 0.05, 0.1, 0.2, 0.3)  #: delays with which deskewed beams may agree as well


def check_sweep(log: ScanLog, seen: Examined) -> list[Finding]:
    """Compare the map of deskewed beams with that of beams all measured at the scan's stamp.

    An error found when the log was read is the finding (:func:`mapper.io.logs.understanding.understood`). Otherwise
    ``log`` states its time increment. If the poses around the sweeps are not dense, nothing is deskewed, and there is
    no finding. With different clocks, correctly deskewed beams may agree less than others by chance, so they have to
    agree less for every delay.
    """
    stated_error = next((part.wrong_sweep for part in sensors_of(log) if part.wrong_sweep), "")
    if stated_error:
        return [
            Finding(
                CHECK,
                stated_error,
                "The map is right without; correct time_increment, the times of the points of clouds, or the order of "
                "the beams, in the sensor’s driver.",
                0.95,
            )
        ]
    name = seen.trajectory
    if not log.can_deskew(name):
        return []
    trajectory = log.trajectory(name)
    timed = (
        trajectory.timed
        if trajectory.timed is not None and len(trajectory.timed)
        else TimedPoses(log.stamps_ns, trajectory.poses)
    )
    stated = with_trajectories(log, {name: replace(trajectory, timed=timed)}).take(seen.scans)
    swept = replace(seen, log=stated)
    now = consistency(swept, deskew="auto")
    without = consistency(swept, deskew="off")

    def is_better(than: float) -> bool:
        return without >= BETTER * than and without >= than + BY

    if not is_better(now) or any(not is_better(consistency(swept, deskew="auto", time_offset=s)) for s in DELAYS_S):
        return []
    sweep = max(abs(part.time_increment) * (part.n_beams - 1) for part in sensors_of(log))
    return [
        Finding(
            CHECK,
            f"The time_increment of the scans is wrong: by it a scan takes {sweep:.2f} s, but its beams fit better as "
            f"if all were measured at once: beams end where others end in {100 * without:.0f} % instead of "
            f"{100 * now:.0f} % of all cases.",
            "Map without deskewing (--deskew off), and correct time_increment in the sensor’s driver.",
            min(0.97, 0.5 + 4.0 * (without - now)),
            (),
            {"deskew": "off"},
        )
    ]
