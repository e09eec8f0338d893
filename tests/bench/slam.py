"""SLAM of the real logs that are there: errors over known relations, processor time, sharpness before and after."""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from mapper.diagnosis.verdict import sharpness_of
from mapper.evaluation import evaluate_relations
from mapper.io.logs import odometry_records, open_log
from mapper.io.trajectories import read_relations
from mapper.sensors.scan import Trajectory
from mapper.sensors.timed_poses import TimedPoses
from mapper.slam import LOOP, SlamResult, slam_log
from mapper.slam.optimise import optimise

#: Log, relations, and the same log with poses that another program corrected.
LOGS = (
    ("carmen/intel_merged.log.gz", "relations/intel.relations", ""),
    ("carmen/intel.log.gz", "relations/intel.relations", "carmen/intel-corrected.log.gz"),
    ("carmen/aces.log.gz", "", "carmen/aces-corrected.log.gz"),
    ("carmen/fhw.log.gz", "", "carmen/fhw-corrected.log.gz"),
    ("carmen/loop5.log.gz", "", ""),
    ("carmen/intel-robotlaser.log.gz", "", ""),
    ("breezyslam/exp1.dat.gz", "", ""),
    # Without odometry.
    ("bags/scans_demo.bag", "", ""),
    ("bags/b0-tiny.bag", "", ""),
    ("bags/b0-2014-07-21-12-42-53-short.bag", "", ""),
)


def over_relations(path: Path, relations: Path, poses: TimedPoses) -> str:
    found = evaluate_relations(read_relations(relations), poses, odometry_records(path))
    clear = found.only_unambiguous()
    figures = [(len(clear[0].errors), *clear), (len(found.translation.errors), found.translation, found.rotation)]
    return (
        " | ".join(
            f"{t.statistics.mean:.4f} m, {np.degrees(r.statistics.mean):.3f}° ({count})" for count, t, r in figures
        )
        + f" | {found.policy}"
    )


def without_a_loop(found: SlamResult) -> str:
    """Return how long the graph takes to be solved again after its first loop was removed, the median of five."""
    loops = np.flatnonzero(found.graph.kind == LOOP)
    if not len(loops):
        return "–"
    solved = optimise(found.graph)
    changed = solved.without_edge(int(loops[0]))
    seconds = []
    for _ in range(5):
        began = time.process_time()
        optimise(changed)
        seconds.append(time.process_time() - began)
    return f"{1000.0 * float(np.median(seconds)):.0f} ms"


def slam() -> None:
    """Print a row for each log. The processor time is that of a second run, whose kernels are loaded."""
    folder = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data"))
    columns = (
        "log", "scans", "unambiguous relations", "all relations", "stamps by", "CPU s", "× real time", "loops",
        "sharpness before", "after", "corrected log's", "solved without a loop",
    )  # fmt: skip
    print(f"\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    for name, relations, corrected in LOGS:
        path = folder / name
        if not path.is_file():
            print(f"{name}: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
            continue
        log = open_log(path)
        slam_log(log.take(slice(0, 100)))
        found = slam_log(log)
        after = replace(log, trajectories={"slam": Trajectory(found.poses)})
        has_relations = relations and (folder / relations).is_file()
        errors = (
            over_relations(path, folder / relations, TimedPoses(log.stamps_ns, found.poses))
            if has_relations
            else "– | – | –"
        )
        span = float(np.ptp(log.stamps_ns)) / 1e9
        theirs = (
            f"{sharpness_of(open_log(folder / corrected), None):.3f}"
            if corrected and (folder / corrected).is_file()
            else "–"
        )
        print(
            f"| {name} | {log.n_scans} | {errors} | {found.cpu_seconds:.2f} | "
            f"{f'{span / found.cpu_seconds:.0f}' if span else '–'} | {found.graph.n_loops} | "
            f"{sharpness_of(log, found.odometry):.3f} | {sharpness_of(after, None):.3f} | {theirs} | "
            f"{without_a_loop(found)} |",
            flush=True,
        )
