"""``python -m tests.bench``: times of the mapping core and of the peers, measured in one run, as ratios."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.grid.metrics import map_metrics
from mapper.io.logs import open_log
from mapper.mapping.integrate import geometry_for, grid_for, integrate_log
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.mapping.provenance import provenance
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.tools.bench import bench_map
from tests.bench.calibration import calibration
from tests.bench.causes import causes
from tests.bench.chunk_files import chunk_files
from tests.bench.costmap import costmap
from tests.bench.doctor import doctor
from tests.bench.events import events
from tests.bench.feel import feel
from tests.bench.fleet import fleet
from tests.bench.hard import hard
from tests.bench.held_out import held_out
from tests.bench.inspecting import inspecting
from tests.bench.limits import mapping_limit, page_faults
from tests.bench.localization import localization
from tests.bench.matching import matching
from tests.bench.opening import opening
from tests.bench.orbit import orbit
from tests.bench.peer import PeerAbsentError, build_mrpt, mrpt_ms, versions
from tests.bench.reading import reading
from tests.bench.reports import reports
from tests.bench.sensors import sensors
from tests.bench.service_start import service_start
from tests.bench.sharing import sharing
from tests.bench.size import size
from tests.bench.slam import slam
from tests.bench.slam_calibration import slam_calibration
from tests.bench.terrain import terrain
from tests.bench.tsdf import tsdf
from tests.bench.volume import volume

RANGE_MAX = 30.0
ROUNDS = 8  #: in which ours and the peer's have five passes each by turns: these machines have good and bad moments
REAL_LOGS = ("intel-corrected", "aces-corrected", "fhw-corrected")


def hall(n_scans: int = 1000, n_beams: int = 1080) -> ScanLog:
    """A round of an empty hall of 40 m × 25 m with a 270° scanner: what each beam reads is a line through a box."""
    random = np.random.default_rng(7)
    round_trip = np.linspace(0, 2 * np.pi, n_scans)
    poses = np.column_stack([20 + 12 * np.cos(round_trip), 12.5 + 6 * np.sin(round_trip), round_trip + np.pi / 2])
    angle_min, increment = -np.deg2rad(135), np.deg2rad(270) / (n_beams - 1)
    bearing = poses[:, 2:] + angle_min + increment * np.arange(n_beams)
    cos, sin = np.cos(bearing), np.sin(bearing)
    along_x = (np.where(cos > 0, 40.0, 0.0) - poses[:, :1]) / cos
    along_y = (np.where(sin > 0, 25.0, 0.0) - poses[:, 1:2]) / sin
    ranges = np.minimum(along_x, along_y) + random.normal(0, 0.01, bearing.shape)
    stamps = np.arange(n_scans, dtype=np.int64)
    return ScanLog(ranges.astype(np.float32), angle_min, increment, 0.05, 80.0, stamps, {"true": Trajectory(poses)})


def logs() -> Iterator[tuple[str, ScanLog, float]]:
    """Yield name, log and resolution of each case."""
    folder = os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data")
    for name in REAL_LOGS:
        path = Path(folder) / "carmen" / f"{name}.log.gz"
        if path.is_file():
            log = open_log(path)
            yield name, replace(log, range_min=max(log.range_min, 0.0501)), 0.05
        else:
            print(f"{name}: not in the folder that GRIDBLOOM_TEST_DATA names", file=sys.stderr)
    yield "hall, 1,080 beams", hall(), 0.025


def best_ms(work: Callable[[], object], repeats: int) -> float:
    """Return the milliseconds that ``work`` takes, the best of ``repeats``."""
    best = float("inf")
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - began)
    return 1e3 * best


def side_by_side() -> None:
    """Print each log's times and their ratio to the peer's."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            peer = build_mrpt(Path(folder))
        except PeerAbsentError as absent:
            peer = None
            print(f"MRPT is left out: {absent}", file=sys.stderr)
        columns = (
            "log", "scans × beams", "cell updates", "per beam", "updates a second", "per scan", "MRPT",
            "per beam, ratio", "per scan, ratio",
        )  # fmt: skip
        print(f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
        for name, log, resolution in logs():
            beam, scan, theirs, cells = np.inf, np.inf, np.inf, 0
            for _ in range(ROUNDS):
                ours = bench_map(log, MappingConfig(range_max=RANGE_MAX, resolution=resolution), repeats=5)
                beam, scan = min(beam, ours["per_beam_ms"]), min(scan, ours["per_scan_ms"])
                cells = int(ours["cells"])
                theirs = min(theirs, mrpt_ms(peer, log, RANGE_MAX, resolution)) if peer else np.inf
            against = f"{theirs:.1f} ms | {theirs / beam:.2f} × | {theirs / scan:.2f} ×" if peer else "– | – | –"
            print(
                f"| {name} | {log.n_scans} × {log.n_beams} | {cells / 1e6:.1f} M | {beam:.1f} ms | "
                f"{1e-6 * cells / beam:.1f} G | {scan:.1f} ms | {against} |"
            )


def beside_the_limit() -> None:
    """Print each log's times beside the limit, and what else takes time: planning, and first touches of memory."""
    print("\n| log | update | entries | time | limit | ratio | planning of beams | pages touched first |")
    print(f"|{'---|' * 8}")
    for (name, log, resolution), update in itertools.product(logs(), ("per_beam", "per_scan")):
        config = MappingConfig(update=update, range_max=RANGE_MAX, resolution=resolution)
        limit, planning, entries = mapping_limit(log, config)
        ours = bench_map(log, config, repeats=5 * ROUNDS)[f"{update}_ms"]
        faults, faults_ms = page_faults(partial(integrate_log, grid_for(log, config), log, config))
        planned = "–" if np.isnan(planning) else f"{planning:.1f} ms"
        print(
            f"| {name} | {update} | {entries / 1e6:.1f} M | {ours:.1f} ms | {limit:.1f} ms | {ours / limit:.2f} | "
            f"{planned} | {faults}, {faults_ms:.2f} ms |",
            flush=True,
        )


def cost_against_size(rounds: int = 40) -> None:
    """Print what the same scans cost in maps of growing size, which take turns: it should not matter."""
    log = hall(400, 360)
    sides, updates = (50, 100, 250, 500, 1000), ("per_beam", "per_scan")
    passes = {}
    for side, update in itertools.product(sides, updates):
        config = MappingConfig(update=update, range_max=RANGE_MAX, resolution=0.1)
        cells = round(side / 0.1)
        grid = OccupancyGrid(GridGeometry(0.1, cells, cells, (20 - side / 2, 12 - side / 2, 0.0)))
        passes[side, update] = partial(integrate_log, grid, log, config)
    best = dict.fromkeys(passes, np.inf)
    for _, (what, one) in itertools.product(range(rounds), passes.items()):
        best[what] = min(best[what], best_ms(one, 1))
    print("\n| side of the map | per beam | per scan |\n|---|---|---|")
    for side in sides:
        print(f"| {side} m | {' | '.join(f'{best[side, update]:.1f} ms' for update in updates)} |")


def cost_of_statistics(repeats: int = 5) -> None:
    """Print the CPU time of a large map's statistics beside that of mapping: best of some fresh maps of 1 cm cells.

    Mapping is all that it takes to get the map of a log that is in memory: its bounds, an empty grid, and the scans.
    """
    print("\n| statistics of a map | cells | mapping, CPU | statistics, CPU | ratio |\n|---|---|---|---|---|")
    for (name, log, _), update in itertools.product(logs(), ("per_beam", "per_scan")):
        config = MappingConfig(update=update, range_max=RANGE_MAX, resolution=0.01)
        mapping, statistics, cells = np.inf, np.inf, 0
        for _ in range(repeats):
            began = time.process_time()
            grid = grid_for(log, config)
            integrate_log(grid, log, config)
            mapped = time.process_time()
            map_metrics(grid)
            mapping, statistics = min(mapping, mapped - began), min(statistics, time.process_time() - mapped)
            cells = grid.log_odds.size
        print(
            f"| {name}, {update} | {cells / 1e6:.1f} M | {1e3 * mapping:.0f} ms | {1e3 * statistics:.0f} ms | "
            f"{statistics / mapping:.3f} |"
        )


def cost_of_asking_why(n_cells: int = 40) -> None:
    """Print how long the provenance of a cell over the whole first log takes, for each way of mapping: the worst cell.

    Half of the cells are the sensor's own, which are touched most, the others lie around. Moravec and Elfes' grids are
    left out: what a reading adds to a cell depends there on all cells of its cone, so the whole map must be made again.
    """
    name, log, resolution = next(logs())
    random = np.random.default_rng(7)
    print(f"\n| provenance of a cell, {name} | median | worst |\n|---|---|---|")
    ways = itertools.product(*(BY_NAME[axis].choices for axis in ("model", "update", "traversal")))
    for model, update, traversal in ways:
        if model == "moravec_elfes":
            continue
        config = MappingConfig(
            model=model, update=update, traversal=traversal, window=0.2, no_return="free", resolution=resolution
        )
        geometry = geometry_for(log, config)
        own = geometry.world_to_cell(log.sensor_poses()[:: max(1, 2 * log.n_scans // n_cells), :2])
        around = own + random.integers(-60, 60, own.shape)
        cells = [tuple(cell) for cell in np.concatenate([own, around]) if geometry.contains(cell)]
        times = sorted(best_ms(partial(provenance, geometry, log, config, cell), 3) for cell in cells)
        print(f"| {model}, {update}, {traversal} | {times[len(times) // 2]:.2f} ms | {times[-1]:.2f} ms |")


def cost_of_starting(processes: int = 10) -> None:
    """Print the time from the start of a process to the end of its first kernel call, its kernels in numba's cache."""
    times = []
    for _ in range(processes + 1):  # the first may still have to compile
        began = time.time()
        done = subprocess.run([sys.executable, "-m", "tests.bench.start"], capture_output=True, text=True, check=True)
        times.append(float(done.stdout) - began)
    print(f"\nprocess start to first kernel call: {min(times[1:]):.2f} s, the best of {processes}")


def mapping() -> None:
    """Print the times of mapping beside the peer's, and on grids of several sizes."""
    side_by_side()
    beside_the_limit()
    cost_against_size()


def starting() -> None:
    """Print the cost of starting a process that uses the mapping core, and the service."""
    cost_of_starting()
    service_start()


BENCHES: dict[str, Callable[[], None]] = {
    "mapping": mapping,
    "held-out": lambda: held_out(logs()),
    "statistics": cost_of_statistics,
    "why": cost_of_asking_why,
    "start": starting,
    "reading": reading,
    "reports": reports,
    "opening": opening,
    "inspecting": lambda: inspecting(hall(20_000, 360)),
    "sharing": lambda: sharing(hall(800, 360)),
    "calibration": calibration,
    "causes": causes,
    "doctor": doctor,
    "events": events,
    "match": matching,
    "slam": slam,
    "slam-calibration": slam_calibration,
    "localization": localization,
    "costmap": costmap,
    "volume": volume,
    "tsdf": tsdf,
    "chunks": chunk_files,
    "terrain": terrain,
    "size": size,
    "sensors": lambda: sensors(hall(1000, 720)),
    "feel": feel,
    "orbit": orbit,
    "hard": hard,
    "fleet": fleet,
}


def main() -> int:
    """Run the benchmarks that the command line names, all of them where it names none.

    After ``match`` come the names of logs.
    """
    if sys.argv[1:2] == ["match"]:
        print(versions())
        matching(sys.argv[2:])
        return 0
    unknown = [name for name in sys.argv[1:] if name not in BENCHES]
    if unknown:
        print(f"There is no benchmark {unknown[0]!r}; there are {', '.join(BENCHES)}.", file=sys.stderr)
        return 2
    print(versions())
    for name in sys.argv[1:] or BENCHES:
        BENCHES[name]()
    return 0


if __name__ == "__main__":
    sys.exit(main())
