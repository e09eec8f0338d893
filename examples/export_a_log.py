"""Read a log and write its map for map_server (pgm and yaml), as a picture, and as an MCAP file for ROS 2 viewers."""

from __future__ import annotations

import argparse
from pathlib import Path

from mapper.grid import OccupancyGrid
from mapper.io.export import GrowingMap, write_mcap
from mapper.io.logs import open_log
from mapper.io.maps import png_bytes, save_map
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import sample_log


def write_csv(path: Path) -> Path:
    """Write a short simulated log in Gridbloom's CSV format, for who has no log at hand."""
    log = sample_log(40)
    lines = [
        f"angle_min,{log.angle_min}", f"angle_increment,{log.angle_increment}",
        f"range_min,{log.range_min}", f"range_max,{log.range_max}", "stamp,x,y,theta,ranges",
    ]  # fmt: skip
    for index, (x, y, theta) in enumerate(log.trajectory().poses):
        ranges = ",".join(f"{z:.3f}" for z in log.ranges[index])
        lines.append(f"{log.stamps_ns[index] * 1e-9:.3f},{x:.4f},{y:.4f},{theta:.5f},{ranges}")
    path.write_text("\n".join(lines) + "\n")
    return path


def main(out: Path, log_path: Path | None = None) -> None:
    """Write map.pgm, map.yaml, map.png and run.mcap."""
    out.mkdir(parents=True, exist_ok=True)
    log = open_log(log_path or write_csv(out / "run.csv"))
    print(f"{log.name}: {log.format}, {log.n_scans} scans of {log.n_beams} beams")
    for note in log.notes:
        print(" ", note)
    config = MappingConfig(range_max=min(log.range_max, 30.0))
    grid = OccupancyGrid(geometry_for(log, config))
    integrate_log(grid, log, config)

    save_map(grid, out / "map")
    (out / "map.png").write_bytes(png_bytes(grid))
    with (out / "run.mcap").open("wb") as file:
        write_mcap(file, log, GrowingMap(grid, config))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", type=Path, nargs="?", help="log of any format that Gridbloom reads")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the files that are written")
    arguments = parser.parse_args()
    main(arguments.out, arguments.log)
