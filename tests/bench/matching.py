"""Scan matching: every method on pairs of scans whose relative pose is known, from first guesses that are off.

Pairs are the relations of the Freiburg benchmark (Kümmerle et al. 2009) of which both ends are scans of Intel's log of
3,461: each stamp is mapped to an odometry message (the policy of ``gridbloom evaluate``), and a message that a scan
follows directly is that scan's. Where several messages have a stamp, which one is meant is a guess by the odometry, so
that some of these relations belong to another scan: the pairs without a choice are told apart. As a second judge the
logs with poses that a SLAM program has corrected: scans within 3 m of each other and more than 20 scans apart, of each
of which half the points are within 0.3 m of points of the other, with the corrected poses taken for true, which they
are to a few centimetres only.

A first guess is the true pose times a random motion, uniform in the disc of so many metres and in so many degrees to
either side, three draws for each pair with a fixed seed. Methods with a window search it as wide as the
guess is off and a tenth more. A match succeeds below 0.10 m and 2°; medians are those of all matches that do. Times are
of the processor, on one thread, points and normals of the scans prepared before.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.core.errors import MapperError
from mapper.core.parallel import single_threaded
from mapper.core.se2 import compose, inverse, transform_points
from mapper.evaluation.relations import records_of_relations
from mapper.io.logs import odometry_records, open_log
from mapper.io.trajectories import read_relations
from mapper.matching.beams import prepare_scans
from mapper.matching.kernels.types import ScanArrays
from mapper.matching.match import match_scan
from mapper.matching.parameters import METHODS, MatchConfig
from mapper.matching.target import scan_target
from mapper.sensors.scan import ScanLog

OFF = ((0.2, 10.0), (0.5, 30.0), (1.0, 60.0))  #: m, degrees: how far the first guess is off
DRAWS = 3
WIDER = 1.1  #: the window, beside how far the guess is off
SUCCESS = (0.10, 2.0)  #: m, degrees
CORRECTED = ("aces-corrected", "fhw-corrected", "intel-corrected")
NEAR_M, LATER_SCANS, MOST_PAIRS = 3.0, 20, 100
OVERLAP_M, LEAST_OVERLAP = 0.3, 0.5

Matcher = Callable[[int, int, Float64Array, float, float], Float64Array]  # scans, guess, window → pose


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pairs of scans of a log with their relative poses ``T_first_second`` (n, 3); ``clear`` (n,): without a choice."""

    name: str
    log: ScanLog
    scans: np.ndarray
    motions: Float64Array
    clear: np.ndarray


def related(data: Path) -> Pairs:
    """Return the pairs of Intel's relations."""
    path = data / "carmen/intel_merged.log.gz"
    relations = read_relations(data / "relations/intel.relations")
    records = odometry_records(path)
    if records is None:
        raise SystemExit(f"{path} has no odometry messages.")
    indices, clear = records_of_relations(relations.stamps_ns, relations.motions, records.messages)
    scan_of: dict[int, int] = {}
    for scan, record in enumerate(records.before_scan):
        scan_of.setdefault(int(record), scan)
    on_scans = np.array([[int(record) in scan_of for record in ends] for ends in indices]).all(axis=1)
    scans = np.array([[scan_of[int(record)] for record in ends] for ends in indices[on_scans]])
    return Pairs("intel.relations", open_log(path), scans, relations.motions[on_scans], clear[on_scans])


def corrected(data: Path, name: str) -> Pairs:
    """Return pairs of scans from places near each other, with the poses of a SLAM program."""
    log = open_log(data / f"carmen/{name}.log.gz")
    poses = log.trajectory("scan").poses
    i, j = np.triu_indices(log.n_scans, LATER_SCANS)
    motions = compose(inverse(poses[i]), poses[j])
    near = np.flatnonzero((np.hypot(*motions[:, :2].T) < NEAR_M) & (np.abs(motions[:, 2]) < np.pi / 2))
    scans, chosen = prepare_scans(log), list[int]()
    for k in np.random.default_rng(3).permutation(near):
        if len(chosen) < MOST_PAIRS and overlap(scans, int(i[k]), int(j[k]), motions[k]) >= LEAST_OVERLAP:
            chosen.append(int(k))
    ends = np.stack([i[chosen], j[chosen]], axis=-1)
    return Pairs(name, log, ends, motions[chosen], np.ones(len(chosen), dtype=np.bool_))


def overlap(scans: ScanArrays, i: int, j: int, motion: Float64Array) -> float:
    """Return the share of the points of two scans that are near points of the other, of the scan with the less."""
    first = scans.points[i][scans.kind[i] > 0].astype(np.float64)
    second = transform_points(motion, scans.points[j][scans.kind[j] > 0])
    if not len(first) or not len(second):
        return 0.0
    near = np.hypot(*np.moveaxis(first[:, np.newaxis] - second, -1, 0)) < OVERLAP_M
    return float(min(near.any(axis=0).mean(), near.any(axis=1).mean()))


def matchers(log: ScanLog) -> Iterator[tuple[str, Matcher]]:
    """Yield the methods by name, and those of others where they are installed."""
    scans = prepare_scans(log)

    def of(method: str) -> Matcher:
        def match(i: int, j: int, guess: Float64Array, metres: float, radians: float) -> Float64Array:
            config = MatchConfig(
                method=method, window_m=metres, window_rad=radians, first_gate=max(0.3, 2.0 * metres), min_cosine=0.0
            )
            if METHODS[method].search != "guess":
                config = MatchConfig(method=method, window_m=metres, window_rad=radians)
            try:
                return match_scan(scans, j, scan_target(scans, i), guess, config).pose
            except MapperError:  # nothing found
                return guess

        return match

    yield from ((name, of(name)) for name in METHODS if name != "exhaustive")  # which finds what correlative does
    try:
        import small_gicp  # type: ignore[import-not-found]
    except ImportError:
        return
    clouds: dict[int, Any] = {}

    def cloud(k: int) -> Any:
        if k not in clouds:
            points = scans.points[k][scans.kind[k] > 0]
            clouds[k] = small_gicp.preprocess_points(
                np.column_stack([points, np.zeros(len(points))]), downsampling_resolution=0.02, num_threads=1
            )
        return clouds[k]

    def theirs(i: int, j: int, guess: Float64Array, metres: float, _radians: float) -> Float64Array:
        first = np.eye(4)
        c, s = math.cos(guess[2]), math.sin(guess[2])
        first[:2, :2], first[:2, 3] = [[c, -s], [s, c]], guess[:2]
        target, tree = cloud(i)
        found = small_gicp.align(
            target, cloud(j)[0], tree, init_T_target_source=first, max_correspondence_distance=max(0.5, metres),
            num_threads=1,
        ).T_target_source  # fmt: skip
        return np.array([found[0, 3], found[1, 3], math.atan2(found[1, 0], found[0, 0])])

    yield "small_gicp", theirs


def measured(pairs: Pairs, match: Matcher, metres: float, degrees: float) -> tuple[np.ndarray, float]:
    """Return the errors (n · draws, 2), metres and degrees, and the milliseconds of processor time per match."""
    random, errors, seconds = np.random.default_rng(1), [], 0.0
    for (i, j), motion in zip(pairs.scans, pairs.motions, strict=True):
        for _ in range(DRAWS):
            way, length = random.uniform(-np.pi, np.pi), metres * math.sqrt(random.uniform())
            turn = math.radians(degrees) * random.uniform(-1.0, 1.0)
            guess = compose(motion, [length * math.cos(way), length * math.sin(way), turn])
            began = time.process_time()
            pose = match(int(i), int(j), guess, WIDER * metres, WIDER * math.radians(degrees))
            seconds += time.process_time() - began
            off = compose(inverse(motion), pose)
            errors.append([np.hypot(off[0], off[1]), abs(np.degrees(off[2]))])
    return np.array(errors), 1e3 * seconds / len(errors)


def table(pairs: Pairs) -> None:
    """Print a row for each method."""
    clear = np.repeat(pairs.clear, DRAWS)
    sure = np.count_nonzero(pairs.clear)
    print(f"{pairs.name}: {len(pairs.scans)} pairs × {DRAWS} draws, {sure} pairs without a choice")
    print(f"  {'first guess off by':<18}" + "".join(f"{f'{m:g} m / {d:g}°':>34}" for m, d in OFF))
    print(f"  {'':<18}" + f"{'all (clear)  median       ms':>34}" * len(OFF))
    with single_threaded():
        for name, match in matchers(pairs.log):
            i, j = pairs.scans[0]
            match(int(i), int(j), pairs.motions[0], 0.1, 0.1)  # kernels are compiled before the clock runs
            cells = []
            for metres, degrees in OFF:
                errors, ms = measured(pairs, match, metres, degrees)
                good = np.asarray((errors < SUCCESS).all(axis=1))
                medians = np.median(errors[good], axis=0) if good.any() else np.full(2, np.nan)
                rates = f"{100 * good.mean():5.1f} ({100 * good[clear].mean():5.1f})"
                rates = f"{100 * np.mean(good):5.1f} ({100 * np.mean(good[clear]):5.1f})"
                cells.append(f"{rates} {medians[0]:.4f} m {medians[1]:.2f}° {ms:5.2f}")
            print(f"  {name:<18}" + "".join(f"{cell:>34}" for cell in cells), flush=True)


def matching(names: Sequence[str] = ()) -> None:
    """Print the tables, of the logs that are named or of all."""
    data = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data"))
    if not (data / "relations/intel.relations").is_file():
        print("The data that GRIDBLOOM_TEST_DATA names is absent: nothing to match.")
        return
    wanted = names or ["intel.relations", *CORRECTED]
    for name in wanted:
        table(related(data) if name == "intel.relations" else corrected(data, name))
