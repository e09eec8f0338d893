"""Draw the README's moving picture, a map that fills in: ``python -m tests.pictures.moving``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from mapper import MappingConfig, OccupancyGrid, geometry_for, integrate_scan, sample_log

N_SCANS, EVERY = 600, 8  #: scans, and scans from one frame to the next
RESOLUTION = 0.08  #: metres of a cell
ZOOM = 2  #: pixels of a cell's side
BEAM, ROBOT, PATH = (214, 120, 40), (20, 90, 160), (120, 160, 200)


def frames() -> list[Image.Image]:
    """Return pictures of the map after each eighth scan, with the scan's beams, the robot and its path."""
    log = sample_log(N_SCANS)
    config = MappingConfig(resolution=RESOLUTION, range_max=log.range_max)
    grid = OccupancyGrid(geometry_for(log, config))
    poses = log.sensor_poses()
    made = []
    for index in range(N_SCANS):
        scan = log.scan(index)
        integrate_scan(grid, scan, poses[index], config)
        if index % EVERY == EVERY - 1:
            made.append(_picture(grid, scan.ranges, scan.angles, poses[: index + 1]))
    rows, cols = np.nonzero(grid.observed)
    top, bottom = grid.geometry.rows - rows.max() - 1, grid.geometry.rows - rows.min()
    left, right = cols.min(), cols.max() + 1
    box = (ZOOM * left, ZOOM * top, ZOOM * right, ZOOM * bottom)
    return [picture.crop(box).quantize(16, dither=Image.Dither.NONE) for picture in made]


def _picture(grid: OccupancyGrid, ranges: np.ndarray, angles: np.ndarray, poses: np.ndarray) -> Image.Image:
    belief = np.where(grid.observed, 1.0 / (1.0 + np.exp(-grid.log_odds)), 0.5)
    grey = np.where(grid.observed, 245 - 225 * belief, 200).astype(np.uint8)
    picture = Image.fromarray(np.kron(grey[::-1], np.ones((ZOOM, ZOOM), dtype=np.uint8))).convert("RGB")
    draw = ImageDraw.Draw(picture, "RGBA")

    def pixels(xy: np.ndarray) -> list[tuple[float, float]]:
        lattice = grid.geometry.to_lattice(xy).tolist()
        return [(ZOOM * u, ZOOM * (grid.geometry.rows - v)) for u, v in lattice]

    x, y, yaw = poses[-1]
    seen = np.isfinite(ranges)
    bearings = yaw + angles[seen]
    ends = np.column_stack([x + ranges[seen] * np.cos(bearings), y + ranges[seen] * np.sin(bearings)])
    (robot,) = pixels(np.array([[x, y]]))
    for end in pixels(ends[::6]):
        draw.line([robot, end], fill=(*BEAM, 70), width=1)
    draw.line(pixels(poses[:, :2]), fill=PATH, width=2)
    radius = 0.2 / RESOLUTION * ZOOM
    draw.ellipse([robot[0] - radius, robot[1] - radius, robot[0] + radius, robot[1] + radius], fill=ROBOT)
    return picture


def main() -> None:
    """Write ``map.gif``; the last picture stays for two seconds."""
    first, *rest = frames()
    durations = [80] * len(rest) + [2000]
    path = Path(__file__).parent / "map.gif"
    first.save(path, save_all=True, append_images=rest, duration=durations, loop=0, optimize=True)


if __name__ == "__main__":
    main()
