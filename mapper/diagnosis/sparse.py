"""Check for poses that are too far apart in time for the robot's turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mapper.diagnosis.consistency import Examined, consistency
from mapper.diagnosis.finding import MOST_SCANS, Finding
from mapper.diagnosis.timing import BETTER, BY
from mapper.sensors.scan import ScanLog
from mapper.sensors.sparse_poses import ADVICE, sparse_turns

CHECK = "timing.sparse"
LEAST_OTHERS = 0.1  #: minimum fraction of scans outside turns, by which the map without turns is judged


def check(stated: ScanLog, seen: Examined) -> list[Finding]:
    """Compare the map of all scans with that of the scans outside turns between sparse poses.

    ``stated`` is the log with the stamps of its poses. The scans in turns are the cause of double walls if the beams of
    the others agree clearly better.
    """
    turns = sparse_turns(stated, seen.trajectory)
    if turns is None:
        return []
    others = ~np.isin(seen.scans, turns.scans)
    if others.mean() < LEAST_OTHERS:
        return []
    without = consistency(replace(seen, log=seen.log.take(np.flatnonzero(others)), scans=seen.scans[others]))
    if without < BETTER * seen.agreement or without < seen.agreement + BY:
        return []
    sure = min(0.95, 0.6 + 4.0 * (without - seen.agreement))
    return [Finding(CHECK, turns.sentence, ADVICE, sure, tuple(turns.scans[:MOST_SCANS].tolist()))]
