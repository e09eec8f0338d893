"""``compare``: compare two maps cell by cell."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from mapper.grid.compare import STATES, difference
from mapper.grid.compare import compare as compare_maps
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import BY_NAME, PARAMETERS, recorded_defaults
from server.cli.commands import app
from server.cli.common import (
    MOUNT,
    AsJson,
    LogPath,
    Mount,
    TfTopic,
    TopicName,
    TrajectoryName,
    TumTrajectory,
    configured,
    given_parameters,
    print_json,
    refusing,
    set_values,
    with_parameter_options,
)
from server.cli.reading import read_log


@app.command()
@with_parameter_options(*(row.name for row in PARAMETERS if row.name not in MOUNT))
def compare(
    log: LogPath,
    other: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="Parameter with another value in the second map; repeatable."),
    ] = None,
    other_log: Annotated[Path | None, typer.Option(metavar="LOG", help="Make the second map of another log.")] = None,
    topic: TopicName = None,
    trajectory: TrajectoryName = None,
    other_trajectory: Annotated[
        str | None, typer.Option(metavar="NAME", help="Poses of the second map. [those of the first]")
    ] = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each row of the table
) -> None:
    """Make two maps that differ in parameters, poses or log, and compare them cell by cell."""
    values = given_parameters(parameters, mount)
    changed = set_values(BY_NAME, other or [], "--other")
    configured(values | changed)
    sides = [
        (log, topic, trajectory, values),
        (
            other_log or log,
            None if other_log else topic,
            other_trajectory or (None if other_log else trajectory),
            values | changed,
        ),
    ]
    grids = []
    for path, sensor, poses, changes in sides:
        scans = read_log(path, sensor, tum_trajectory if path == log else None, tf)
        config = configured(recorded_defaults(scans.beam_width, changes))
        with refusing(path):
            grid = grid_for(scans, config, poses)
            integrate_log(grid, scans, config, poses)
        grids.append(grid)
    with refusing(sides[1][0]):
        comparison = compare_maps(*grids)
        apart = difference(grids[0], grids[1]).log_odds
    facts = {
        "same": comparison.same,
        "changed": [{"from": a, "to": b, "cells": n} for (a, b), n in comparison.changed.items()],
        "entropy_bits": [round(bits, 1) for bits in comparison.entropy_bits],
        "wall_contrast": [round(contrast, 4) for contrast in comparison.contrast],
        "cells": comparison.cells,
        "states": {
            a: dict(zip(STATES, row, strict=True)) for a, row in zip(STATES, comparison.states.tolist(), strict=True)
        },
        "observed": {"only_first": comparison.only[0], "only_second": comparison.only[1], "both": comparison.both},
        "log_odds_difference": {
            "least": float(apart.min()),
            "greatest": float(apart.max()),
            "mean_absolute": round(comparison.mean_difference, 4),
            "greatest_absolute": round(comparison.max_difference, 4),
        },
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"  {comparison.same} observed cells are in the same state in both maps")
    for (before, after), cells in comparison.changed.items():
        typer.echo(f"  {cells} cells: {before} → {after}")
    typer.echo(f"  {comparison.only[0]} cells are known only in the first map, {comparison.only[1]} only in the second")
    typer.echo(
        f"  log-odds differ by {comparison.mean_difference:.3f} on average, {comparison.max_difference:.3f} at most"
    )
    typer.echo(f"  entropy {comparison.entropy_bits[0]:.0f} → {comparison.entropy_bits[1]:.0f} bits")
    typer.echo(f"  contrast of the walls {comparison.contrast[0]:.3f} → {comparison.contrast[1]:.3f}")
