"""Double walls, because of drifting or missing poses, and walls that come and go, because objects move."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mapper.diagnosis.consistency import Examined, consistency, contradiction, counts, cut, unthinned
from mapper.diagnosis.finding import MOST_SCANS, POSSIBLE, Finding
from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.kernels.lattice import cell_of
from mapper.mapping.integrate import geometry_for, integrate_scans
from mapper.sensors.joint_log import part_of_scan, sensors_of
from mapper.sensors.scan import ScanLog

STRETCH = 16  #: scans within which motion is negligible
MOVED = 0.88  #: maximum ratio of the whole's consistency to that of its stretches if the robot moved
EVEN_ODDS, SLOPE = 0.08, 0.05  #: of the logistic function from the excess of contradictions to the confidence in drift
LEAST_SURE = 0.35  #: minimum confidence for drift to be reported
STRETCHES = 8  #: stretches of the whole log for moving objects
SOLID, PASSED = 0.6, 0.05  #: hit ratio of a cell that was occupied, and of one that was vacated
LEAST_VISITS = 5
LEAST_CELLS = 12  #: of one moved object
#: Cells around solid cells of a stretch in which moving objects are not searched: poses that drift slightly, too little
#: for a finding, draw a wall next to its earlier position. The middle of a table is farther from solid cells.
BESIDE = 4
LEAST_CONSISTENT = 0.35  #: below this nothing can be said about moving objects

#: remedies for poses, for the advice
CORRECTED_BY = "Heal on the page of the log, or gridbloom slam on the command line"


def check_still(log: ScanLog, seen: Examined) -> list[Finding]:
    """If all poses are equal, compare the consistency of the whole log with that of its short stretches."""
    if np.ptp(seen.log.trajectory().poses, axis=0).any():
        return []
    n = log.n_scans
    starts = np.unique(np.linspace(0, max(0, n - STRETCH), 24).astype(np.int64))
    whole = unthinned(log, seen)
    local = float(np.median([consistency(cut(whole, start, start + STRETCH)) for start in starts.tolist()]))
    far = seen.agreement
    if local <= 0.0 or far >= MOVED * local:
        return []
    return [
        Finding(
            "poses.still",
            f"The poses stay in one place, but the readings do not: over {STRETCH} scans beams agree in "
            f"{100 * local:.0f} % of all cases, over the whole log in {100 * far:.0f} %. The robot moved.",
            "Record /tf and /tf_static, or the odometry, with the scans; or estimate the poses with SLAM: "
            f"{CORRECTED_BY}.",
            float(np.clip(0.5 + 4.0 * (MOVED - far / local), 0.5, 0.99)),
        )
    ]


def check_drift(log: ScanLog, seen: Examined) -> list[Finding]:
    """Compare the contradictions between parts of the log far apart in time with those between parts a moment apart."""
    # Beams with assumed angles contradict each other even along true poses.
    if log.angles_assumed:
        return []
    # A sonar echo comes from anywhere on its arc, so its thin beam does not localise objects.
    if log.beam_width > 0.0 or not np.ptp(seen.log.trajectory().poses, axis=0).any():
        return []
    shares = contradiction(unthinned(log, seen), seen)
    seen.compared(shares)
    sure = drift_confidence(shares.excess)
    if sure < LEAST_SURE:
        return []
    return [
        Finding(
            "walls.drift",
            f"The poses {'may drift' if sure < POSSIBLE else 'drift'}: {100 * shares.far:.0f} % of the readings end "
            "where beams of another time passed freely, against "
            f"{100 * shares.near:.0f} % between scans a moment apart. Walls that the robot comes back to are double.",
            f"Take another trajectory, or correct the poses with SLAM: {CORRECTED_BY}.",
            sure,
            _worst_scans(seen),
        )
    ]


def drift_confidence(excess: float) -> float:
    """Return the confidence, 0 to 0.99, that poses with this :attr:`Contradiction.excess` cause double walls.

    docs/doctor.md lists the logs on which the two constants were tuned.
    """
    return min(0.99, 1.0 / (1.0 + math.exp((EVEN_ODDS - excess) / SLOPE)))


def _worst_scans(seen: Examined) -> tuple[int, ...]:
    """Return the scans with beams ending where most others passed, in order."""
    grid = counts(seen)
    if grid.cell_statistics is None:
        return ()
    hits, misses = grid.cell_statistics
    share = np.divide(hits, hits + misses, out=np.zeros_like(hits), where=hits + misses > 0)
    means = np.ones(len(seen.scans))
    for t, cells in enumerate(_endpoints(seen, grid.geometry)):
        if len(cells):
            means[t] = share[cells[:, 0], cells[:, 1]].mean()
    return tuple(sorted(seen.scans[np.argsort(means)[:MOST_SCANS]].tolist()))


def _endpoints(seen: Examined, geometry: GridGeometry) -> list[NDArray[np.int64]]:
    log = seen.log
    out = []
    parts, owner = sensors_of(log), part_of_scan(log).tolist()
    angles = [part.angles for part in parts]
    for t, (x, y, theta) in enumerate(log.sensor_poses()):
        part, bearings = parts[owner[t]], angles[owner[t]]
        ranges = log.ranges[t, : part.n_beams].astype(np.float64)
        measured = (ranges >= part.range_min) & (ranges <= min(part.range_max, seen.config.range_max))
        bearing = theta + bearings[measured]
        ends = np.stack([x + ranges[measured] * np.cos(bearing), y + ranges[measured] * np.sin(bearing)], axis=-1)
        cells = np.asarray(cell_of(geometry.to_lattice(ends)[:, ::-1]), dtype=np.int64)
        out.append(cells[geometry.contains(cells)])
    return out


def check_moving(log: ScanLog, seen: Examined) -> list[Finding]:  # noqa: ARG001 - as all checks
    """Search for objects that were solid in one stretch of the log and passed through in another."""
    if seen.agreement < LEAST_CONSISTENT:
        return []
    geometry = geometry_for(seen.log, seen.config)
    edges = np.linspace(0, seen.log.n_scans, STRETCHES + 1).astype(int)
    solid, passed = np.zeros((2, STRETCHES, *geometry.shape), dtype=np.bool_)
    for k, (start, stop) in enumerate(pairwise(edges.tolist())):
        grid = OccupancyGrid(geometry)
        integrate_scans(grid, seen.log, seen.config, None, start, stop)
        if grid.cell_statistics is None:
            continue
        hits, misses = grid.cell_statistics
        visits = hits + misses
        # Range noise moves some hits to the next cell, so a vacated cell must have free space around it.
        around = ndimage.maximum_filter(hits, 3)
        solid[k] = (visits >= LEAST_VISITS) & (hits > SOLID * visits)
        passed[k] = (visits >= LEAST_VISITS) & (around < PASSED * visits)
    for k in range(STRETCHES):  # near a wall, vacated cells may be that wall at a drifted pose
        passed[k] &= ~ndimage.binary_dilation(solid[k], structure=np.ones((3, 3)), iterations=BESIDE)
    labels, n = ndimage.label(solid.any(axis=0) & passed.any(axis=0), structure=np.ones((3, 3)))
    sizes = ndimage.sum_labels(labels > 0, labels, np.arange(1, n + 1)) if n else np.zeros(0)
    things = np.flatnonzero(sizes >= LEAST_CELLS) + 1
    if not len(things):
        return []
    largest = labels == things[int(np.argmax(sizes[things - 1]))]
    x, y = geometry.cell_to_world(np.argwhere(largest).mean(axis=0))
    was, left = (np.flatnonzero(seen_in[:, largest].mean(axis=1) > 0.2) for seen_in in (solid, passed))
    went = len(was) and len(left) and was.mean() < left.mean()
    change = (left if went else was).min(initial=STRETCHES - 1)
    more = f"{len(things)} things came or went: the largest" if len(things) > 1 else "Something came or went"
    return [
        Finding(
            "walls.moving",
            f"{more}, {int(sizes.max())} cells around ({x:.1f}, {y:.1f}) m, {'went' if went else 'came'}.",
            "Keep the clamp on, so that the map can change; or map only the part of the log that is needed.",
            0.7,
            (int(seen.scans[min(int(edges[change]), len(seen.scans) - 1)]),),
        )
    ]
