"""List every beam that touched the most often hit cell of a map, with what it added, and draw the beams."""

from __future__ import annotations

import argparse
import io
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from mapper.grid import OccupancyGrid
from mapper.io.maps import png_bytes
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.mapping.provenance import provenance
from mapper.simulation import sample_log


def main(out: Path) -> None:
    """Write why.png: the map, and in red the beams that ended in the cell."""
    log = sample_log(100)
    config = MappingConfig(range_max=8.0, clamp=False)
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)
    row, col = (int(n) for n in np.unravel_index(grid.log_odds.argmax(), grid.log_odds.shape))
    why = provenance(grid.geometry, log, config, (row, col))

    x, y = grid.geometry.cell_to_world((row, col))
    print(f"Cell (row {row}, column {col}) at ({x:.2f}, {y:.2f}) m holds {grid.log_odds[row, col]:.2f}.")
    print(f"{len(why.scans)} beams touched it, {why.hits.sum()} of them argued for occupied. The first ten:")
    for n in range(min(10, len(why.scans))):
        reading = f"scan {why.scans[n]:3d}  beam {why.beams[n]:3d}  {why.ranges[n]:5.2f} m"
        print(f"  {reading}  {why.increments[n]:+.2f}  log-odds {why.log_odds[n]:+.2f}")

    picture = Image.open(io.BytesIO(png_bytes(grid))).convert("RGB")
    draw = ImageDraw.Draw(picture)
    for scan in np.unique(why.scans[why.hits]):
        from_row, from_col = grid.geometry.world_to_cell(log.sensor_poses()[scan, :2])
        draw.line([(from_col, grid.geometry.rows - 1 - from_row), (col, grid.geometry.rows - 1 - row)], (200, 30, 30))
    out.mkdir(parents=True, exist_ok=True)
    picture.save(out / "why.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the files that are written")
    main(parser.parse_args().out)
