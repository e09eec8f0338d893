"""``path``: the cheapest path on the costmap of a map file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from mapper.core.errors import MapperError
from mapper.costmap.build import DEFAULT, build_costmap
from mapper.costmap.nav2.reading import costmap_of
from mapper.io.maps import load_map
from mapper.io.ros_parameters import parse_ros_parameters, read_parameter_file
from mapper.planning import plan_path
from mapper.planning.nav2_parameters import Nav2Path, path_of
from mapper.planning.plan import travel_time
from server.cli.commands import app
from server.cli.common import AsJson, fail, make_folder_of, numbers, output_file, print_json, print_notes, refusing
from server.cli.maps.costmap import (
    UNKNOWN_AS_FREE,
    KeepoutMask,
    SpeedAbsolute,
    SpeedBase,
    SpeedMask,
    SpeedMultiplier,
    SpeedScale,
    count_unknown_as_free,
    notes_on_masks,
    with_masks,
)


@app.command()
def path(
    map_yaml: Annotated[Path, typer.Argument(metavar="MAP.yaml", help="A map file.")],
    start: Annotated[str, typer.Option("--from", metavar="X,Y", help="Where the robot is, in metres.")],
    goal: Annotated[str, typer.Option("--to", metavar="X,Y", help="The goal, in metres.")],
    params: Annotated[
        Path | None,
        typer.Option(metavar="NAV2.yaml", help="Nav2 parameter file of costmap and planner; else defaults."),
    ] = None,
    tolerance: Annotated[
        float | None, typer.Option(metavar="METRES", help="How far from an occupied goal the path may end. [0.5]")
    ] = None,
    astar: Annotated[
        bool | None, typer.Option("--astar/--dijkstra", help="The algorithm of the search. [Dijkstra's]")
    ] = None,
    unknown: Annotated[
        bool | None, typer.Option("--unknown/--no-unknown", help="Whether the path may cross unknown cells. [yes]")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Write the points of the path: x,y in metres, one a line.")
    ] = None,
    keepout: KeepoutMask = None,
    speed: SpeedMask = None,
    speed_base: SpeedBase = 0.0,
    speed_multiplier: SpeedMultiplier = 1.0,
    speed_absolute: SpeedAbsolute = False,
    as_json: AsJson = False,
) -> None:
    """Plan the cheapest path between two places of a map, on the costmap of Nav2's layers."""
    start_xy = numbers("--from", "two numbers, X,Y in metres", 2, start)
    goal_xy = numbers("--to", "two numbers, X,Y in metres", 2, goal)
    parameters, nav2 = DEFAULT, Nav2Path()
    if params is not None:
        with refusing(params):
            root = parse_ros_parameters(read_parameter_file(params))
            parameters, nav2 = costmap_of(root), path_of(root)
    options: dict[str, Any] = {"use_astar": astar, "allow_unknown": unknown, "tolerance": tolerance}
    try:
        config = replace(nav2.planner, **{name: value for name, value in options.items() if value is not None})
    except MapperError as error:
        fail(error.message)
    with refusing(map_yaml):
        loaded = load_map(map_yaml)
    scale = SpeedScale(speed_base, speed_multiplier, speed_absolute)
    parameters, masks = with_masks(parameters, params, loaded.description.frame, keepout, speed, scale)
    with refusing(map_yaml):
        built = build_costmap(loaded.grid.geometry, loaded.values, parameters, masks=masks)
        built.costmap.update()
        planned = plan_path(built.costmap.costs, loaded.grid.geometry, start_xy, goal_xy, config)
    greatest = nav2.pursuit.desired_linear_vel
    unknown_as_free = count_unknown_as_free(parameters, loaded.values, built.costmap.costs)
    rows, cols = loaded.grid.geometry.world_to_cell(planned.points).T
    in_unknown = int((loaded.values[rows, cols] < 0).sum())
    without_effect = [*parameters.unused, *nav2.unused]
    notes = [*loaded.notes, *parameters.notes, *nav2.notes, *notes_on_masks(masks)]
    facts: dict[str, object] = {
        "map": str(map_yaml),
        "length": round(planned.length, 3),
        "cost": round(planned.cost, 3),
        "points": len(planned.points),
        "speed": greatest,
        "travel_s": round(travel_time(planned.points, greatest, built.speed), 3),
        "without_effect": without_effect,
        "end": [round(float(value), 6) for value in planned.points[-1]],
        "reaches_goal": planned.reaches_goal,
        "unknown_as_free": unknown_as_free,
        "points_in_unknown": in_unknown,
        "notes": notes,
    }
    if out is not None:
        lines = "".join(f"{x:.6f},{y:.6f}\n" for x, y in planned.points)
        make_folder_of(out)
        with output_file(out) as file:
            file.write(f"x,y\n{lines}".encode())
        facts["file"] = str(out)
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{planned.length:.2f} m, cost {planned.cost:.0f}, {len(planned.points)} points")
    slower = ", less where there are limits" if built.speed else ""
    typer.echo(f"  {facts['travel_s']:.1f} s at {greatest:g} m/s{slower}")
    if not planned.reaches_goal:
        x, y = planned.points[-1]
        typer.echo(f"  ends at ({x:.2f}, {y:.2f}), the nearest place to the goal that the robot can reach")
    if unknown_as_free:
        typer.echo(f"  {UNKNOWN_AS_FREE.format(unknown_as_free)}")
    if in_unknown:
        typer.echo(f"  {in_unknown} of the points are in cells that the map does not know")
    if without_effect:
        typer.echo(f"  parameters without effect here: {', '.join(without_effect)}")
    if out is not None:
        typer.echo(f"  wrote {out}")
    print_notes(notes)
