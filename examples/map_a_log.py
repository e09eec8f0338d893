"""Map a simulated log: write the map as a picture and print it as text."""

from __future__ import annotations

import argparse
from pathlib import Path

from mapper.grid import OccupancyGrid
from mapper.grid.metrics import map_metrics
from mapper.grid.text import density
from mapper.io.maps import png_bytes
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import sample_log


def main(out: Path) -> None:
    """Write map.png."""
    log = sample_log(200)
    config = MappingConfig(resolution=0.1, range_max=8.0)
    grid = OccupancyGrid(geometry_for(log, config))
    updates = integrate_log(grid, log, config)
    metrics = map_metrics(grid)

    print(density(grid))
    print(f"{log.n_scans} scans of {log.n_beams} beams made {updates} cell updates.")
    print(f"{metrics.free} cells are free, {metrics.occupied} occupied; entropy {metrics.entropy_bits:.0f} bit.")
    out.mkdir(parents=True, exist_ok=True)
    (out / "map.png").write_bytes(png_bytes(grid))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the files that are written")
    main(parser.parse_args().out)
