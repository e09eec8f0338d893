"""The explanation of a cell, for the table: by the core, and from the textbook's maps after each scan."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from mapper.mapping import textbook, textbook_deskew
from mapper.mapping.provenance import provenance
from mapper.sensors.scan import LaserScan, RangeScan
from tests.agreement.inputs import MappingCase


def cells_to_ask(case: MappingCase) -> list[tuple[int, int]]:
    """The sensor's cells, the endpoints' and some between, as far as they lie in the grid."""
    asked = set()
    for scan, pose in zip(case.scans(), case.sensor_poses(), strict=True):
        for z, bearing in zip(scan.ranges.astype(float), scan.angles, strict=True):
            for part in (0.0, 0.5, 1.0):
                if np.isfinite(z):
                    asked.add(textbook.cell_at(case.grid(), pose, bearing, part * z))
    return [cell for cell in sorted(asked) if case.geometry.contains(cell)][:8]


def provenance_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    prior = case.grid().prior()
    found = [
        provenance(case.geometry, case.log, case.config, cell, prior=float(prior[cell])) for cell in cells_to_ask(case)
    ]
    names = [list(zip(p.scans.tolist(), p.beams.tolist(), strict=True)) for p in found]
    values = [np.stack([p.increments, p.log_odds]) for p in found]
    return (names, *values)


Touch = tuple[int, int, float, np.float32]  # scan, beam, what it added, the log-odds after it


def told(found: list[list[Touch]]) -> tuple[Any, ...]:
    names = [[(t, k) for t, k, _, _ in contributions] for contributions in found]
    values = [
        np.array([[e for *_, e, _ in contributions], [v for *_, v in contributions]], np.float32)
        for contributions in found
    ]
    return (names, *values)


def provenance_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    scans, poses = case.scans(), case.sensor_poses()
    return told([textbook.provenance(case.grid(), scans, poses, cell, case.config) for cell in cells_to_ask(case)])


def sweeps(case: MappingCase) -> list[list[tuple[LaserScan, np.ndarray]]]:
    """The beams of each scan, every one by itself, and the pose that it was measured from."""
    return [textbook_deskew.deskewed(case.log, t, case.config) for t in range(case.log.n_scans)]


def beams_and_poses(case: MappingCase) -> list[tuple[LaserScan, np.ndarray]]:
    """Every beam of the log by itself, and the pose that it was measured from."""
    return [one for sweep in sweeps(case) for one in sweep]


def provenance_of_sweeps_by_kernel(case: MappingCase) -> tuple[Any, ...]:
    prior = case.grid().prior()
    found = [
        provenance(case.geometry, case.log, case.config, cell, prior=float(prior[cell])) for cell in swept_cells(case)
    ]
    names = [(p.scans * case.log.n_beams + p.beams).tolist() for p in found]
    return (names, *(np.stack([p.increments, p.log_odds]) for p in found))


def provenance_of_sweeps_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    found = [textbook.provenance_of_views(case.grid(), sweeps(case), cell, case.config) for cell in swept_cells(case)]
    names, *values = told(found)
    return ([[t * case.log.n_beams + k for t, k in touches] for touches in names], *values)


def swept_cells(case: MappingCase) -> list[tuple[int, int]]:
    """Cells on the beams, as :func:`cells_to_ask`."""
    asked = set()
    for beam, pose in beams_and_poses(case):
        z = float(beam.ranges[0])
        asked |= {textbook.cell_at(case.grid(), pose, 0.0, part * z) for part in (0.0, 0.5, 1.0) if np.isfinite(z)}
    return [cell for cell in sorted(asked) if case.geometry.contains(cell)][:8]


def single_threaded(scan: RangeScan, beam: int) -> RangeScan:
    """The scan as if all its other beams had measured nothing."""
    ranges = np.full_like(scan.ranges, np.nan)
    ranges[beam] = scan.ranges[beam]
    return replace(scan, ranges=ranges)


def provenance_of_scans_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    """Each scan updates a cell once; it is named by the first beam that ended there, else by the one that sees it."""
    grid, config = case.grid(), case.config
    found: dict[tuple[int, int], list[Touch]] = {cell: [] for cell in cells_to_ask(case)}
    values = {cell: grid.prior()[cell] for cell in found}
    for t, (scan, pose) in enumerate(zip(case.scans(), case.sensor_poses(), strict=True)):
        if not found:
            break
        whole = textbook.inverse_range_sensor_model(grid, scan, pose, config)
        single = [
            textbook.inverse_range_sensor_model(grid, single_threaded(scan, k), pose, config)
            for k in range(len(scan.ranges))
        ]
        z_max = min(scan.range_max, config.range_max)
        readings = textbook.readings(scan, config)
        ends = [
            textbook.cell_at(grid, pose, bearing, z) if scan.range_min <= z <= z_max else None
            for z, bearing in zip(readings, scan.angles, strict=True)
        ]
        for cell, contributions in found.items():
            if np.isnan(whole[cell]):
                continue
            ended = [k for k, end in enumerate(ends) if end == cell and config.model != "sonar_cone"]
            beam = [*ended, *(k for k, evidence in enumerate(single) if not np.isnan(evidence[cell]))][0]
            values[cell] = textbook.bayes_filter(values[cell], np.float32(whole[cell]), config)
            contributions.append((t, beam, whole[cell], values[cell]))
    return told(list(found.values()))


def provenance_of_counts_by_textbook(case: MappingCase) -> tuple[Any, ...]:
    """A map in which only one beam after the other is counted, and each cell watched."""
    grid = case.grid()
    found: dict[tuple[int, int], list[Touch]] = {cell: [] for cell in cells_to_ask(case)}
    for t, (scan, pose) in enumerate(zip(case.scans(), case.sensor_poses(), strict=True)):
        for k in range(len(scan.ranges)):
            counts, before = textbook.statistics_of(grid, case.config).copy(), grid.log_odds.copy()
            textbook.count_hits_and_misses(grid, single_threaded(scan, k), pose, case.config)
            counted = (textbook.statistics_of(grid, case.config) != counts).any(axis=0)
            for cell, contributions in found.items():
                if counted[cell]:
                    contributions.append((t, k, grid.log_odds[cell] - before[cell], grid.log_odds[cell]))
    return told(list(found.values()))
