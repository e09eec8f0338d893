"""Map one log with two sensor models, compare the maps in numbers and put them side by side."""

from __future__ import annotations

import argparse
import io
from pathlib import Path

from PIL import Image

from mapper.grid import OccupancyGrid
from mapper.grid.compare import compare
from mapper.io.maps import png_bytes
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import sample_log


def main(out: Path) -> None:
    """Write compare_models.png: fixed increments on the left, smooth ramp on the right."""
    log = sample_log(200)
    configs = [MappingConfig(model=model, range_max=8.0) for model in ("fixed_increments", "smooth_ramp")]
    geometry = geometry_for(log, configs[1])  # the ramp reaches beyond the reading
    a, b = OccupancyGrid(geometry), OccupancyGrid(geometry)
    integrate_log(a, log, configs[0])
    integrate_log(b, log, configs[1])
    result = compare(a, b)

    for (before, after), cells in result.changed.items():
        print(f"{cells:6d} cells are {before} with fixed increments and {after} with the smooth ramp.")
    print(f"The mean difference is {result.mean_difference:.2f}, the greatest {result.max_difference:.2f} (log-odds).")
    print("Entropy: {:.0f} and {:.0f} bit.".format(*result.entropy_bits))
    both = Image.new("RGB", (2 * geometry.cols, geometry.rows))
    for place, grid in enumerate((a, b)):
        both.paste(Image.open(io.BytesIO(png_bytes(grid))).convert("RGB"), (place * geometry.cols, 0))
    out.mkdir(parents=True, exist_ok=True)
    both.save(out / "compare_models.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the files that are written")
    main(parser.parse_args().out)
