"""Map a log with a sensor model of one's own: a Gaussian wall instead of a single cell."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.grid import OccupancyGrid
from mapper.io.maps import png_bytes
from mapper.mapping.integrate import geometry_for, integrate_scan
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import sample_log


class GaussianWall:
    """Free before the reading, occupied around it with a standard deviation of 0.1 m."""

    reach = 0.3  # metres behind the reading up to which the model gives evidence

    def increments(self, r: NDArray[np.float64], z: NDArray[np.float64], range_max: float) -> NDArray[np.float64]:
        """Return log-odds to add for cells at distance r (m,) on a beam that read z (m,); both in metres."""
        del range_max  # only of use for beams without return
        wall = 0.9 * np.exp(-0.5 * ((r - z) / 0.1) ** 2)
        return np.where(r < z - self.reach, -0.4, wall)


def main(out: Path) -> None:
    """Write custom_model.png."""
    log = sample_log(100)
    config = MappingConfig(resolution=0.05, range_max=8.0)
    grid = OccupancyGrid(geometry_for(log, config))
    for index, pose in enumerate(log.sensor_poses()):
        integrate_scan(grid, log.scan(index), pose, config, GaussianWall())

    print(grid)
    out.mkdir(parents=True, exist_ok=True)
    (out / "custom_model.png").write_bytes(png_bytes(grid))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the files that are written")
    main(parser.parse_args().out)
