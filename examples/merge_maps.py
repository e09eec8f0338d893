"""Map the two halves of a log apart, save both, and add the evidence of the two map files."""

from __future__ import annotations

import argparse
from pathlib import Path

from mapper.grid import OccupancyGrid
from mapper.grid.compare import compare
from mapper.grid.merge import merged
from mapper.io.maps import load_map, png_bytes, save_map
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from mapper.simulation import sample_log


def mapped(log: ScanLog, config: MappingConfig, start: int, stop: int) -> OccupancyGrid:
    """Return the map of the scans [start, stop) of a log."""
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config, start=start, stop=stop)
    return grid


def main(out: Path) -> None:
    """Write first.yaml, second.yaml, their images, and merged.png."""
    log = sample_log(200)
    config = MappingConfig(range_max=8.0, clamp=False)  # the clamp forgets evidence
    half = log.n_scans // 2
    for name, start, stop in (("first", 0, half), ("second", half, log.n_scans)):
        save_map(mapped(log, config, start, stop), out / name, mode="raw")  # probabilities, in hundredths
    both = merged(load_map(out / "first.yaml").grid, load_map(out / "second.yaml").grid)
    result = compare(mapped(log, config, 0, log.n_scans), both)

    print(f"{int(both.observed.sum())} cells are known from the two maps.")
    print(
        f"{result.same} cells are in the same state as in the map of the whole log, {sum(result.changed.values())} not."
    )
    (out / "merged.png").write_bytes(png_bytes(both))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the files that are written")
    main(parser.parse_args().out)
