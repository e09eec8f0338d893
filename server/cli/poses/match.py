"""``match``: the pose of one scan or map relative to another one."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, cast

import numpy as np
import typer

from mapper.core.errors import MapperError
from mapper.core.se2 import compose, inverse
from mapper.grid import OccupancyGrid
from mapper.io.logs import is_log
from mapper.io.maps import load_map
from mapper.mapping.integrate import grid_for, integrate_log
from mapper.mapping.parameters import MappingConfig, recorded_defaults
from mapper.matching import Match, match_maps, match_scan, prepare_scans, scan_target
from mapper.matching.parameters import MAP_CONFIG, METHODS, MatchConfig
from mapper.sensors.scan import ScanLog
from server.cli.commands import app
from server.cli.common import (
    AsJson,
    Mount,
    TfTopic,
    TopicName,
    TrajectoryName,
    TumTrajectory,
    configured,
    fail,
    given_parameters,
    numbers,
    print_json,
    print_notes,
    refusing,
    with_parameter_options,
)
from server.cli.reading import read_log, with_corrections

Read = Callable[[Path], ScanLog]  #: reads a log according to the options


@dataclass(frozen=True, slots=True)
class Side:
    """One of the two inputs: a scan of a log, or a map (``index`` None)."""

    name: str
    path: Path
    index: int | None


@app.command()
@with_parameter_options("mount_upside_down", "time_offset")
def match(
    first: Annotated[str, typer.Argument(metavar="A", help="A scan, LOG#I; or a map: MAP.yaml, or a LOG to map.")],
    second: Annotated[
        str | None, typer.Argument(metavar="B", help="What is matched to A: as A. [with --scans: of the same log]")
    ] = None,
    scans: Annotated[
        tuple[int, int] | None, typer.Option(metavar="I J", help="The two scans of LOG, counted from 0.")
    ] = None,
    method: Annotated[
        str | None,
        typer.Option(metavar="|".join(METHODS), help="How the match is found. [global; of maps global_field]"),
    ] = None,
    guess: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,YAW",
            help="Pose of B in A to begin with (m, m, rad). [of scans of one log that by its poses; otherwise 0,0,0]",
        ),
    ] = None,
    window: Annotated[
        str | None,
        typer.Option(metavar="M,RAD", help="How far from the guess poses are searched. [1.5,1.222; of maps 5,3.142]"),
    ] = None,
    topic: TopicName = None,
    trajectory: TrajectoryName = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Print the pose at which two scans, or two maps, lie on one another, and how certain it is.

    A topic, a mount and a time offset are those of both; a TUM file is the first log's.
    """
    base, other = _sides(first, second, scans)
    if (base.index is None) != (other.index is None):
        fail(f"{base.name} and {other.name}: Two scans can be matched, or two maps; these are one of each.")
    is_map = base.index is None
    mapping = configured(given_parameters(parameters, mount))

    def read(path: Path) -> ScanLog:
        log = read_log(path, topic, tum_trajectory if path == base.path else None, tf)
        return with_corrections(path, log, mapping)

    options: dict[str, object] = {}
    if method is not None:
        options["method"] = method.replace("-", "_")
    if window is not None:
        pair = numbers("--window", "two numbers, M,RAD in metres and radians", 2, window)
        options |= zip(("window_m", "window_rad"), pair, strict=True)
    begin = None if guess is None else numbers("--guess", "three numbers, X,Y,YAW in metres and radians", 3, guess)
    try:
        config = (MAP_CONFIG if is_map else MatchConfig()).with_values(options)
    except MapperError as error:
        fail(error.message)
    began = time.process_time()
    if is_map:
        begin = begin or [0.0, 0.0, 0.0]
        aligned, notes = _match_maps(base, other, begin, config, read, trajectory)
    else:
        notes = []
        begin, aligned = _match_scans(base, other, begin, config, read, trajectory)
    _print(base, other, begin, config, aligned, time.process_time() - began, notes, as_json=as_json)


def _sides(first: str, second: str | None, scans: tuple[int, int] | None) -> tuple[Side, Side]:
    """Return the inputs to match, or end the command with an error."""
    if scans is not None:
        if second is not None:
            fail("match takes LOG --scans I J, or A and B, not both.")
        return cast("tuple[Side, Side]", tuple(Side(f"{first}#{index}", Path(first), index) for index in scans))
    if second is None:
        fail("match needs A and B, each LOG#I, a MAP.yaml or a LOG; or LOG --scans I J.")
    return _side(first), _side(second)


def _side(text: str) -> Side:
    path, mark, number = text.rpartition("#")
    if not mark or Path(text).exists():
        return Side(text, Path(text), None)
    if not number.removeprefix("-").isdecimal():
        fail(f"{text}: A scan is LOG#I with its number I, not {number!r:.40}.")
    return Side(text, Path(path), int(number))


def _match_scans(
    base: Side, other: Side, guess: list[float] | None, config: MatchConfig, read: Read, trajectory: str | None
) -> tuple[list[float], Match]:
    log = read(base.path)
    second = log if other.path == base.path else read(other.path)
    indices = [_index(side, side_log) for side, side_log in ((base, log), (other, second))]
    if guess is None:
        guess = [0.0, 0.0, 0.0]
        with refusing(base.path):
            poses = log.trajectory(trajectory)
        if second is log and not poses.is_placeholder:
            guess = compose(inverse(poses.poses[indices[0]]), poses.poses[indices[1]]).tolist()
    with refusing(base.path):
        target = scan_target(prepare_scans(log, indices[0], indices[0] + 1), 0)
    with refusing(other.path):
        return guess, match_scan(prepare_scans(second, indices[1], indices[1] + 1), 0, target, np.array(guess), config)


def _index(side: Side, log: ScanLog) -> int:
    index = side.index if side.index is not None and side.index >= 0 else log.n_scans + (side.index or 0)
    if not 0 <= index < log.n_scans:
        fail(f"{side.path}: The log has {log.n_scans} scans, counted from 0, and no scan {side.index}.")
    return index


def _match_maps(
    base: Side, other: Side, guess: list[float], config: MatchConfig, read: Read, trajectory: str | None
) -> tuple[Match, list[str]]:
    """Return the match, and the notes on map files."""
    (first, of_first), (second, of_second) = (_grid(side.path, read, trajectory) for side in (base, other))
    notes = [f"{side.path.name}: {note}" for side, of in ((base, of_first), (other, of_second)) for note in of]
    with refusing(other.path):
        return match_maps(first, second, np.array(guess), config), notes


def _grid(path: Path, read: Read, trajectory: str | None) -> tuple[OccupancyGrid, tuple[str, ...]]:
    """Return the map of a map file with the notes on it, or that of a log along its poses."""
    if path.suffix.lower() in {".yaml", ".yml"} or not is_log(path):
        with refusing(path):
            loaded = load_map(path)
        return loaded.grid, loaded.notes
    log = read(path)
    with refusing(path):
        config = MappingConfig().with_values(recorded_defaults(log.beam_width, {}))
        grid = grid_for(log, config, trajectory)
        integrate_log(grid, log, config, trajectory)
    return grid, ()


def _print(
    base: Side, other: Side, guess: list[float], config: MatchConfig, aligned: Match, seconds: float,
    notes: list[str], *, as_json: bool,
) -> None:  # fmt: skip
    direction = None if aligned.unknown_direction is None else aligned.unknown_direction.tolist()
    if as_json:
        print_json(
            {
                "first": base.name,
                "second": other.name,
                "method": aligned.method,
                "guess": guess,
                "window": [config.window_m, config.window_rad],
                "pose": aligned.pose.tolist(),
                "covariance": aligned.covariance.tolist(),
                "score": aligned.score,
                "degenerate": aligned.is_degenerate,
                "unknown_direction": direction,
                "information": aligned.information,
                "rms": aligned.rms,
                "pairs": aligned.pairs,
                "iterations": aligned.iterations,
                "candidates": [
                    {"pose": pose.tolist(), "score": float(score)}
                    for pose, score in zip(aligned.candidates, aligned.scores, strict=True)
                ],
                "cpu_seconds": round(seconds, 4),
                "notes": notes,
            }
        )
        return
    x, y, theta = aligned.pose
    sigma = np.sqrt(np.diag(aligned.covariance))
    typer.echo(f"{other.name} in {base.name}, method {aligned.method}")
    typer.echo(f"  pose {x:.4f} m, {y:.4f} m, {math.degrees(theta):.3f}°")
    spread = f"{sigma[0]:.4f} m, {sigma[1]:.4f} m, {math.degrees(sigma[2]):.3f}°"
    typer.echo(f"  standard deviation {spread}, if it is the right one")
    typer.echo(f"  score {aligned.score:.3f} of 1, {aligned.pairs} pairs, {aligned.iterations} iterations")
    if len(aligned.scores) > 1:
        others = sorted((float(score) for score in aligned.scores), reverse=True)[1:]
        typer.echo(f"  other modes score {', '.join(f'{score:.3f}' for score in others)}")
    if aligned.unknown_direction is not None:
        a, b, c = aligned.unknown_direction
        typer.echo(
            f"  degenerate: hardly anything tells how far it is along ({a:.2f} m, {b:.2f} m, {math.degrees(c):.1f}°), "
            f"which has {100 * aligned.information:.1f} % of the information"
        )
    print_notes(notes)
