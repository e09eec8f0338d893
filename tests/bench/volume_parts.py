"""What takes the time of an insertion and of casts: the kernels timed one by one, and what they do counted."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from threading import Lock
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

import mapper.volume.blocks
import mapper.volume.occupancy.volume
from mapper.volume import OccupancyVolume, VolumeConfig, cast
from mapper.volume.kernels.blocks import _home_of
from mapper.volume.kernels.rays import CENTRE
from mapper.volume.kernels.types import BlockTable
from tests.bench.volume_limits import BLOCK, cast_reads

VOLUME, HASH, PARTS = mapper.volume.occupancy.volume, mapper.volume.blocks, mapper.volume.occupancy.volume
#: What the kernels of an insertion do, by the modules that call them and their names there.
KERNELS = {
    "keys of the points": (VOLUME, ("voxel_keys", "key_bounds", "pack_keys", "distinct_voxels")),
    "rays followed": (VOLUME, ("mark_rays", "mark_ends")),
    "marks looked for": (VOLUME, ("marked_blocks",)),
    "blocks looked up and entered in the hash": (HASH, ("find_slots", "add_blocks")),
    "parts of blocks numbered": (PARTS, ("add_parts",)),
    "log-odds changed": (VOLUME, ("apply_marks",)),
}
REST = "the rest: new memory, sorting, Python"
ROUNDS = 12
Scan = tuple[NDArray[np.float32], NDArray[np.float32]]


def _touched(whose: int) -> int:
    return resource.getrusage(whose).ru_minflt


@dataclass
class Spent:
    """Processor time, seconds, and first touches of pages of each kind of kernel, over all threads."""

    seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(KERNELS, 0.0))
    pages: dict[str, int] = field(default_factory=lambda: dict.fromkeys(KERNELS, 0))
    _lock: Lock = field(default_factory=Lock)

    def timed(self, title: str, kernel: Callable[..., Any], *given: Any) -> Any:
        """Call a kernel, and add what it took."""
        pages, began = _touched(resource.RUSAGE_THREAD), time.thread_time()
        found = kernel(*given)
        took, more = time.thread_time() - began, _touched(resource.RUSAGE_THREAD) - pages
        with self._lock:
            self.seconds[title] += took
            self.pages[title] += more
        return found


@contextmanager
def _timed_kernels() -> Iterator[Spent]:
    spent = Spent()
    with ExitStack() as patches:
        for title, (module, kernels) in KERNELS.items():
            for name in kernels:
                timed = partial(spent.timed, title, getattr(module, name))
                patches.enter_context(mock.patch.object(module, name, timed))
        yield spent


def _inserted(scan: Scan, config: VolumeConfig) -> tuple[Spent, OccupancyVolume]:
    """Insert a scan into an empty map; what no kernel took is in the rest."""
    with _timed_kernels() as spent:
        pages, began = _touched(resource.RUSAGE_SELF), time.process_time()
        volume = OccupancyVolume(config)
        volume.insert_scan(*scan)
        spent.seconds[REST] = time.process_time() - began - sum(spent.seconds.values())
        spent.pages[REST] = _touched(resource.RUSAGE_SELF) - pages - sum(spent.pages.values())
    return spent, volume


def _probes(table: BlockTable) -> float:
    """Return how many places of a hash table are looked at for a block that is in it, in the mean."""
    n = len(table.codes)
    there = np.flatnonzero(table.codes >= 0)
    homes = np.array([_home_of(code, n) for code in table.codes[there].tolist()])
    return float(((there - homes & n - 1) + 1).mean())


def insertion_parts(title: str, scan: Scan, config: VolumeConfig) -> None:
    """Print what each kind of kernel takes of an insertion: that of the least time."""
    runs = [_inserted(scan, config) for _ in range(ROUNDS)]
    spent, volume = min(runs, key=lambda run: sum(run[0].seconds.values()))
    rays, lasts, *_ = volume.rays_of(*scan)
    first = np.floor(scan[1].astype(np.float64) / config.resolution).astype(np.int64) + CENTRE
    steps = int(np.abs(lasts - first).sum())
    whole, blocks = sum(spent.seconds.values()), volume.blocks.count
    print(
        f"\n{title}: {len(rays):,} rays of {steps / len(rays):.0f} steps, {blocks:,} blocks, {volume.n_known:,} voxels"
    )
    print("| part | ms | of all | first touches of pages |\n|---|---:|---:|---:|")
    for name, seconds in spent.seconds.items():
        print(f"| {name} | {1e3 * seconds:.2f} | {100.0 * seconds / whole:.0f} % | {spent.pages[name]} |")
    followed, changed = spent.seconds["rays followed"], spent.seconds["log-odds changed"]
    print(
        f"{1e9 * followed / steps:.2f} ns a step of a ray, {1e9 * changed / volume.n_known:.2f} ns a known voxel; "
        f"{_probes(volume.blocks.table):.2f} places of the hash for each block",
        flush=True,
    )


def cast_parts(volume: OccupancyVolume, origins: NDArray[np.float32], directions: NDArray[np.float32]) -> None:
    """Print what casts take for each ray, each block and each voxel, and of the same rays in order of direction.

    The share of each is that of the least squares over groups of rays from one place. Rays that are alike one after
    another make branches that the processor predicts.
    """
    azimuth = np.arctan2(directions[:, 1], directions[:, 0])
    sorting = np.lexsort((azimuth, np.round(np.arcsin(directions[:, 2] / np.linalg.norm(directions, axis=1)), 1)))
    places = np.unique(origins, axis=0)
    for through in (True, False):
        run = partial(cast, volume, through_unknown=through, range_max=20.0)
        rows, took = [], []
        for place in places:
            own = np.flatnonzero((origins == place).all(axis=1))
            found = run(origins[own], directions[own])
            entries, _ = cast_reads(volume, origins[own], directions[own], found, through_unknown=through)
            blocks = int((entries & BLOCK != 0).sum())
            rows.append((len(own), blocks, len(entries) - blocks))
            took.append(_least_s(partial(run, origins[own], directions[own])))
        (ray, block, voxel), _ = nnls(np.array(rows, dtype=float), np.array(took))
        n, blocks, voxels = np.sum(rows, axis=0).tolist()
        mixed = _least_s(partial(run, origins, directions))
        alike = sum(
            _least_s(partial(run, origins[own], directions[own]))
            for own in (sorting[(origins[sorting] == place).all(axis=1)] for place in places)
        )
        print(
            f"{n} casts to the first obstacle{'' if through else ' or unknown voxel'}: a ray crosses {blocks / n:.1f} "
            f"blocks and reads {voxels / n:.1f} voxels; {1e9 * ray:.0f} ns a ray, {1e9 * block:.1f} a block, "
            f"{1e9 * voxel:.1f} a voxel; {1e3 * mixed:.2f} ms in any order, {1e3 * sum(took):.2f} by place, "
            f"{1e3 * alike:.2f} by place and direction",
            flush=True,
        )


def _least_s(work: Callable[[], object]) -> float:
    """Return the least processor time, seconds, over all threads."""
    times = []
    for _ in range(ROUNDS):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return min(times)
