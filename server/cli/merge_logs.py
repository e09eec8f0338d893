"""``merge`` of logs: two logs of one place in one map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from server.cli.common import fail, print_json, progress_bar, refusing
from server.cli.map_files import save, states

if TYPE_CHECKING:
    from mapper.sensors.scan import ScanLog


def are_logs(paths: list[Path]) -> bool:
    """Return whether all files are logs; end the command with an error where only some are."""
    from mapper.io.logs import is_log  # noqa: PLC0415 - start-up

    logs = [path for path in paths if path.suffix.lower() not in {".yaml", ".yml"} and is_log(path)]
    if logs and len(logs) != len(paths):
        fail(f"{logs[0]} is a log and others are map files: map files can be merged, or two logs.")
    return bool(logs)


def merge_log_files(
    paths: list[Path],
    read: Callable[[Path], ScanLog],
    out: Path,
    mode: str,
    guess: list[float] | None,
    *,
    as_json: bool,
) -> None:
    """Merge two logs, which ``read`` returns, and print what came of it."""
    import numpy as np  # noqa: PLC0415 - start-up

    from mapper.io.export import tum_text  # noqa: PLC0415 - start-up
    from mapper.io.graphs import g2o_lines  # noqa: PLC0415 - start-up
    from mapper.sensors.scan import Trajectory  # noqa: PLC0415 - start-up
    from mapper.slam import MergeProgress, map_along, merge_logs  # noqa: PLC0415 - start-up
    from server.cli.slam import SLAM, write_texts  # noqa: PLC0415 - start-up

    if len(paths) != 2:
        fail(f"merge takes two logs at a time, not {len(paths)}.")
    first, second = map(read, paths)
    with refusing(paths[1]), progress_bar("Merging") as bar:

        def report(done: MergeProgress) -> None:
            if bar is not None:
                bar(done.fraction)

        found = merge_logs(first, second, guess=None if guess is None else np.array(guess), progress=report)
        grid = map_along([(first, found.poses[0]), (second, found.poses[1])])
    texts = {".g2o": "".join(g2o_lines(found.graph))}
    for number, (log, poses) in enumerate(zip((first, second), found.poses, strict=True), 1):
        texts[f"-{number}.tum"] = tum_text(replace(log, trajectories={SLAM: Trajectory(poses)}), SLAM)
    written = [*save(grid, out, mode, "map"), *write_texts(out, texts)]
    geometry = grid.geometry
    facts: dict[str, Any] = {
        "logs": [str(path) for path in paths],
        "placed": found.placed.tolist(),
        "score": round(found.score, 4),
        "loops": len(found.loops),
        "loops_tried": len(found.tried),
        "cpu_seconds": round(found.cpu_seconds, 3),
        "resolution": geometry.resolution,
        "rows": geometry.rows,
        "cols": geometry.cols,
        "origin": list(geometry.origin),
        **states(grid),
        "files": [str(path) for path in written],
    }
    if as_json:
        print_json(facts)
        return
    x, y, theta = found.placed
    typer.echo(f"{paths[1]} in the frame of {paths[0]}: {x:.2f} m, {y:.2f} m, {np.degrees(theta):.1f}°")
    typer.echo(f"  {len(found.loops)} loops between the logs, of {len(found.tried)} tried; {found.cpu_seconds:.1f} s")
    typer.echo(f"  {facts['occupied']} occupied, {facts['free']} free, {facts['unknown']} unknown")
    for path in written:
        typer.echo(f"  wrote {path}")
