"""The ``gridbloom`` command.

``serve`` runs the service; ``info``, ``map``, ``view`` and ``bench map`` work on files; ``upload`` sends one to a
service. What is slow to import is imported where it is used, so that the command starts quickly. Bad input is one
sentence on standard error and exit status 2. With ``--json`` standard output is one JSON object and nothing else.
"""

from __future__ import annotations

import inspect
import json
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from mapper.errors import MapperError
from mapper.parameters import BY_NAME, PARAMETERS, MappingConfig, Parameter

if TYPE_CHECKING:
    from mapper.grid import OccupancyGrid
    from mapper.scan import ScanLog

BAD_INPUT = 2  #: exit status
FEW = 5  #: scans that a finding names on the command line
MOUNT = ("mount_x", "mount_y", "mount_yaw")  #: one option for the three

#: Names that are shorter than the table's, or customary; the table's own name is an option too.
SHORT_NAMES = {
    "range_max": "--max-range",
    "log_odds_hit": "--hit",
    "log_odds_miss": "--miss",
}

app = typer.Typer(
    help="Watch an occupancy grid map fill in: a live world, and robot logs.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
bench_app = typer.Typer(no_args_is_help=True)
app.add_typer(bench_app, name="bench")

LogPath = Annotated[Path, typer.Argument(metavar="LOG", help="A robot's log, plain or compressed.")]
TopicName = Annotated[
    str | None, typer.Option("--topic", metavar="NAME", help="The sensor, where the log has several. [most scans]")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]


def fail(message: str) -> NoReturn:
    """Say in one sentence why the command cannot go on, and end it."""
    typer.echo(f"gridbloom: {message}", err=True)
    raise typer.Exit(BAD_INPUT)


@contextmanager
def refusing(path: Path) -> Iterator[None]:
    """Turn what the mapper refuses of the file at ``path`` into one sentence."""
    try:
        yield
    except MapperError as error:
        fail(f"{path}: {error.message}")


def print_json(values: dict[str, Any]) -> None:
    """Print one object on one line; numbers that JSON lacks must have been replaced."""
    typer.echo(json.dumps(values, allow_nan=False, ensure_ascii=False))


def _option(row: Parameter) -> inspect.Parameter:
    names = [SHORT_NAMES[row.name]] if row.name in SHORT_NAMES else []
    name = "--" + row.name.replace("_", "-")
    names.append(f"{name}/--no-{row.name.replace('_', '-')}" if row.kind == "flag" else name)
    unit = f" {row.unit}" if row.unit else ""
    initial = row.initial if row.kind != "flag" else ("on" if row.initial else "off")
    bounds = f"; {row.low:g} to {row.high:g}{unit}" if row.kind == "number" else ""
    sentence = f"{row.sentence} [{initial}{unit if row.kind == 'number' else ''}{bounds}]"
    kind: Any = {"number": float | None, "choice": str | None, "flag": bool | None}[row.kind]
    metavar = "|".join(row.choices) if row.kind == "choice" else None
    annotation = Annotated[kind, typer.Option(*names, help=sentence, metavar=metavar, show_default=False)]
    return inspect.Parameter(row.name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def with_parameter_options(*names: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command an option for each named row of the parameter table, in place of its ``**parameters``."""

    def widened(command: Callable[..., None]) -> Callable[..., None]:
        own = [p for p in inspect.signature(command, eval_str=True).parameters.values() if p.kind is not p.VAR_KEYWORD]
        options = [_option(BY_NAME[name]) for name in names]
        signature = inspect.Signature([p.replace(kind=p.KEYWORD_ONLY) for p in own] + options)
        command.__signature__ = signature  # type: ignore[attr-defined]
        command.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()}
        return command

    return widened


def given_parameters(values: dict[str, Any], mount: str | None = None) -> dict[str, Any]:
    """Return the parameters that were given, or end the command with what is wrong with them."""
    given = {name: value for name, value in values.items() if value is not None}
    for name, value in given.items():
        if BY_NAME[name].kind == "choice":
            given[name] = value.replace("-", "_")
    if mount is not None:
        given |= zip(MOUNT, _three_numbers(mount), strict=True)
    configured(given)
    return given


def configured(given: dict[str, Any]) -> MappingConfig:
    """Return the parameters with those replaced that were given, or end the command with what is wrong."""
    try:
        return MappingConfig().with_values(given)
    except MapperError as error:
        fail(error.message)


def _prior(text: str, given: dict[str, Any]) -> tuple[dict[str, Any], OccupancyGrid | None]:
    """Return the parameters with a prior that is a number or a map file, and the map."""
    from mapper.maps import load_map  # noqa: PLC0415 - start-up

    try:
        number = float(text)
    except ValueError:
        path = Path(text)
        with refusing(path):
            grid = load_map(path).grid
        return {"resolution": grid.geometry.resolution} | given, grid
    return given | {"log_odds_prior": number}, None


def _three_numbers(text: str) -> list[float]:
    try:
        x, y, yaw = (float(part) for part in text.split(","))
    except ValueError:
        fail(f"--mount needs three numbers, X,Y,YAW in metres and radians, not {text!r:.40}.")
    return [x, y, yaw]


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None] | None]:
    """Yield a function that takes the share that is done, 0 … 1, and shows it; None where nobody watches."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console  # noqa: PLC0415 - start-up
    from rich.progress import Progress  # noqa: PLC0415 - start-up

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def read_log(path: Path, topic: str | None = None) -> ScanLog:
    """Return the log at ``path``, or end the command with what is wrong with it."""
    from mapper.logs import open_log  # noqa: PLC0415 - start-up

    with refusing(path), progress_bar("Reading") as progress:
        return open_log(path, topic=topic, progress=progress)


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on. [127.0.0.1]")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 takes a free one. [8000]")] = None,
    data_dir: Annotated[Path | None, typer.Option(help="Folder for uploaded logs.")] = None,
    logs_dir: Annotated[Path | None, typer.Option(help="Folder whose logs everybody sees, read-only.")] = None,
) -> None:
    """Run the service. Every option is also a setting in the environment, as GRIDBLOOM_PORT."""
    from pydantic import ValidationError  # noqa: PLC0415 - start-up

    from server.serving import run  # noqa: PLC0415 - start-up
    from server.settings import Settings  # noqa: PLC0415 - start-up

    options: dict[str, Any] = {"host": host, "port": port, "data_dir": data_dir, "logs_dir": logs_dir}
    if logs_dir is not None and not logs_dir.is_dir():
        fail(f"--logs-dir: {logs_dir} is no folder.")
    try:
        settings = Settings(**{name: value for name, value in options.items() if value is not None})
    except ValidationError as error:
        first = error.errors()[0]
        fail(f"the setting {'.'.join(str(part) for part in first['loc'])} is refused: {first['msg']}.")
    run(settings)


@app.command()
def info(log: LogPath, topic: TopicName = None, as_json: AsJson = False) -> None:
    """Say what a log holds."""
    from mapper.logs.summary import summarise  # noqa: PLC0415 - start-up

    facts = asdict(summarise(read_log(log, topic)))
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{facts['name']}: {facts['format']}")
    typer.echo(
        f"  {facts['scans']} scans of {facts['beams']} beams over {facts['field_of_view_deg']:.1f}°, "
        f"{facts['duration_s']:.1f} s"
    )
    typer.echo(f"  {_time_line(facts['time'])}")
    n = facts["readings"]
    typer.echo(f"  {n['measured']} readings measured, {n['no_return']} without return, {n['invalid']} invalid")
    typer.echo(
        f"  sensor on the robot at {', '.join(f'{value:g}' for value in facts['mount'])} (m, m, rad)"
        + (", upside-down" if facts["upside_down"] else "")
    )
    for trajectory in facts["trajectories"]:
        typer.echo(f"  trajectory {trajectory['name']}: {trajectory['length_m']:.1f} m, {trajectory['description']}")
    for one in facts["topics"]:
        typer.echo(f"  {'*' if one['chosen'] else ' '} {_topic_line(one)}")
    for note in facts["notes"]:
        typer.echo(f"  note: {note}")


def _time_line(time: dict[str, Any]) -> str:
    """Say when the scans of a log were made."""
    if time["rate_hz"] is None:
        return "no times"
    said = (
        []
        if time["start_s"] is None
        else [f"from {datetime.fromtimestamp(time['start_s'], UTC):%Y-%m-%d %H:%M:%S} UTC"]
    )
    said.append(f"{time['rate_hz']:.1f} scans a second")
    gaps = f"{time['gaps']} gap{'s' if time['gaps'] != 1 else ''}"
    at = f", the longest of {time['longest_gap_s']:.1f} s at {time['longest_gap_at_s']:.1f} s" if time["gaps"] else ""
    return ", ".join(said) + f", {gaps}{at}"


def _topic_line(topic: dict[str, Any]) -> str:
    """Say what is known of one topic of a log."""
    said = [f"{topic['name']}: {topic['count']} × {topic['type']}"]
    if topic["beams"] is not None:
        said.append(f"{topic['beams']} beam{'s' if topic['beams'] != 1 else ''} over {topic['field_of_view_deg']:.1f}°")
    if topic["rate_hz"] is not None:
        said.append(f"{topic['rate_hz']:.1f} Hz")
    if topic["frame"]:
        said.append(f"frame {topic['frame']}")
    if topic["mount"] is not None:
        said.append(f"at {', '.join(f'{value:g}' for value in topic['mount'])}")
    return ", ".join(said)


@app.command()
def doctor(
    log: LogPath,
    topic: TopicName = None,
    trajectory: Annotated[str | None, typer.Option(metavar="NAME", help="Poses to judge. [the log's first]")] = None,
    as_json: AsJson = False,
) -> None:
    """Say what is wrong with a log, where, how surely, and what to do about it."""
    from mapper.doctor import examine  # noqa: PLC0415 - start-up

    scans = read_log(log, topic)
    with refusing(log), progress_bar("Examining") as bar:
        found = examine(scans, trajectory, bar)
    if as_json:
        print_json({"log": scans.name, "findings": [asdict(finding) for finding in found]})
        return
    typer.echo(f"{scans.name}: {len(found)} finding{'' if len(found) == 1 else 's'}")
    for finding in found:
        typer.echo(f"  {finding.check} ({100 * finding.sure:.0f} % sure): {finding.sentence}")
        typer.echo(f"    {finding.advice}")
        if finding.scans:
            more = ", …" if len(finding.scans) > FEW else ""
            typer.echo(f"    at scan {', '.join(map(str, finding.scans[:FEW]))}{more}")
        if finding.parameters:
            typer.echo(f"    with {', '.join(f'{name} = {value}' for name, value in finding.parameters.items())}")


@app.command()
@with_parameter_options(*(row.name for row in PARAMETERS if row.name not in MOUNT))
def compare(
    log: LogPath,
    other: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="A parameter that the second map has another value of; repeatable."),
    ] = None,
    other_log: Annotated[Path | None, typer.Option(metavar="LOG", help="Make the second map of another log.")] = None,
    trajectory: Annotated[str | None, typer.Option(metavar="NAME", help="Poses to map with. [the log's first]")] = None,
    other_trajectory: Annotated[
        str | None, typer.Option(metavar="NAME", help="Poses of the second map. [those of the first]")
    ] = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each row of the table
) -> None:
    """Make two maps, with other parameters, poses or of another log, and say how they differ, cell by cell."""
    from mapper.compare import compare as compare_maps  # noqa: PLC0415 - start-up
    from mapper.integrate import grid_for, integrate_log  # noqa: PLC0415 - start-up

    given = given_parameters(parameters)
    changed = _pairs(other or [])
    sides = [
        (log, trajectory, configured(given)),
        (other_log or log, other_trajectory or (None if other_log else trajectory), configured(given | changed)),
    ]
    grids = []
    for path, poses, config in sides:
        scans = read_log(path)
        with refusing(path):
            grid = grid_for(scans, config, poses)
            integrate_log(grid, scans, config, poses)
        grids.append(grid)
    with refusing(sides[1][0]):
        found = compare_maps(*grids)
    facts = {
        "same": found.same,
        "changed": [{"from": a, "to": b, "cells": n} for (a, b), n in found.changed.items()],
        "entropy_bits": [round(bits, 1) for bits in found.entropy_bits],
        "wall_contrast": [round(contrast, 4) for contrast in found.contrast],
        "log_odds_difference": {"least": float(found.log_odds.min()), "greatest": float(found.log_odds.max())},
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"  {found.same} observed cells are in the same state in both maps")
    for (before, after), cells in found.changed.items():
        typer.echo(f"  {cells} cells: {before} → {after}")
    typer.echo(f"  entropy {found.entropy_bits[0]:.0f} → {found.entropy_bits[1]:.0f} bits")
    typer.echo(f"  contrast of the walls {found.contrast[0]:.3f} → {found.contrast[1]:.3f}")


def _pairs(texts: list[str]) -> dict[str, Any]:
    """Return parameters given as NAME=VALUE, or end the command with what is wrong with one."""
    out: dict[str, Any] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        row = BY_NAME.get(name.replace("-", "_"))
        if row is None or not equals:
            fail(f"--other needs NAME=VALUE with a parameter's name, not {text!r:.60}.")
        if row.kind == "choice":
            out[row.name] = value.replace("-", "_")
        elif row.kind == "flag":
            out[row.name] = {"on": True, "true": True, "off": False, "false": False}.get(value.lower(), value)
        else:
            try:
                out[row.name] = float(value)
            except ValueError:
                out[row.name] = value
    return out


@app.command("map")
@with_parameter_options(*(row.name for row in PARAMETERS if row.name not in (*MOUNT, "log_odds_prior")))
def map_log(
    log: LogPath,
    topic: TopicName = None,
    trajectory: Annotated[str | None, typer.Option(metavar="NAME", help="Poses to map with. [the log's first]")] = None,
    mount: Annotated[
        str | None, typer.Option(metavar="X,Y,YAW", help="Correction of the sensor's place on the robot (m, m, rad).")
    ] = None,
    prior: Annotated[
        str | None,
        typer.Option(
            "--prior",
            "--log-odds-prior",
            metavar="NUMBER|MAP.yaml",
            help=f"{BY_NAME['log_odds_prior'].sentence} Or a map file, from which mapping goes on. [0; -2 to 2]",
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="PREFIX", help="Write PREFIX.pgm and PREFIX.yaml.")] = None,
    mcap: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the map, the poses and the scans for Foxglove and ROS 2.")
    ] = None,
    tum: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the trajectory in TUM format.")] = None,
    mode: Annotated[str, typer.Option(metavar="trinary|scale|raw", help="Kind of map file.")] = "trinary",
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each row of the table
) -> None:
    """Make the map of a log."""
    from mapper.integrate import grid_for, integrate_log  # noqa: PLC0415 - start-up
    from mapper.suited import suited_parameters  # noqa: PLC0415 - start-up

    given, prior_map = given_parameters(parameters, mount), None
    if prior is not None:
        given, prior_map = _prior(prior, given)
        configured(given)
    if mode not in ("trinary", "scale", "raw"):
        fail(f"--mode must be trinary, scale or raw, not {mode!r:.40}.")
    scans = read_log(log, topic)
    config = configured(suited_parameters(scans.beam_width, given))
    with refusing(log):
        grid = grid_for(scans, config, trajectory, prior=prior_map)
        # No scan at all: the kernels are compiled, or loaded from the cache, before the clock runs.
        integrate_log(grid, scans, config, trajectory, 0, 0)
        with progress_bar("Mapping") as bar:
            start = time.perf_counter()
            updated = integrate_log(
                grid, scans, config, trajectory, progress=bar and (lambda done, total: bar(done / max(1, total)))
            )
            seconds = time.perf_counter() - start
    written = _save(grid, out, mode) if out is not None else []
    written += _export(scans, grid, trajectory, mcap, tum)
    geometry = grid.geometry
    facts: dict[str, Any] = {
        "log": scans.name,
        "trajectory": trajectory or scans.default_trajectory,
        "scans": scans.n_scans,
        "beams": scans.n_beams,
        "cells_updated": updated,
        "seconds": round(seconds, 6),
        "resolution": geometry.resolution,
        "rows": geometry.rows,
        "cols": geometry.cols,
        "origin": list(geometry.origin),
        **_states(grid),
        "files": [str(path) for path in written],
        "notes": list(scans.notes),
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{facts['log']}: {facts['scans']} scans of {facts['beams']} beams, trajectory {facts['trajectory']}")
    typer.echo(
        f"  {geometry.rows} × {geometry.cols} cells of {geometry.resolution:g} m, "
        f"origin {', '.join(f'{value:g}' for value in geometry.origin)}"
    )
    typer.echo(f"  {facts['occupied']} occupied, {facts['free']} free, {facts['unknown']} unknown")
    typer.echo(
        f"  {facts['information_gain_bits']:.0f} bits learned, {facts['entropy_bits']:.0f} bits open in seen cells"
    )
    typer.echo(f"  {updated} cell updates in {seconds:.3f} s")
    for path in written:
        typer.echo(f"  wrote {path}")
    for note in scans.notes:
        typer.echo(f"  note: {note}")


def _save(grid: OccupancyGrid, prefix: Path, mode: Any) -> list[Path]:  # noqa: ANN401 - checked by the caller
    from mapper.maps import save_map  # noqa: PLC0415 - start-up

    with refusing(prefix):
        yaml_path, image_path = save_map(grid, prefix, mode)
    return [image_path, yaml_path]


def _export(
    log: ScanLog, grid: OccupancyGrid, trajectory: str | None, mcap: Path | None, tum: Path | None
) -> list[Path]:
    """Write what was asked for; return the paths."""
    from mapper.export import tum_text, write_mcap  # noqa: PLC0415 - start-up
    from mapper.files import whole_file  # noqa: PLC0415 - start-up

    for path in (mcap, tum):
        if path is None:
            continue
        try:
            with whole_file(path) as file:
                if path is tum:
                    file.write(tum_text(log, trajectory).encode())
                else:
                    with progress_bar("Writing") as progress:
                        write_mcap(file, log, grid, trajectory, progress)
        except OSError as error:
            fail(f"{path}: the file cannot be written: {error.strerror}.")
    return [path for path in (mcap, tum) if path is not None]


def _states(grid: OccupancyGrid) -> dict[str, float]:
    from mapper.metrics import map_metrics  # noqa: PLC0415 - start-up

    found = map_metrics(grid)
    return {
        "occupied": found.occupied,
        "free": found.free,
        "unknown": found.unknown,
        "entropy_bits": round(found.entropy_bits, 1),
        "information_gain_bits": round(found.information_gain_bits, 1),
    }


@app.command()
def upload(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A robot's log.")],
    url: Annotated[str, typer.Argument(metavar="URL", help="The service's address, as it prints it.")],
    as_json: AsJson = False,
) -> None:
    """Send a log to a service, go on after a cut, and say where its map is to be seen."""
    from server.settings import Settings  # noqa: PLC0415 - start-up
    from server.uploading import upload as send  # noqa: PLC0415 - start-up

    with refusing(file), progress_bar("Uploading") as progress:
        record, link = send(file, url, Settings().data_dir / "visitors.json", progress=progress)
    if as_json:
        print_json(record | {"link": link})
        return
    typer.echo(f"{record['name']}: {record['scans']} scans of {record['beams']} beams, {record['format']}")
    for note in record["notes"]:
        typer.echo(f"  note: {note}")
    typer.echo(f"  {link}")


@app.command()
def view(
    map_yaml: Annotated[Path, typer.Argument(metavar="MAP.yaml", help="A map file.")],
    width: Annotated[int | None, typer.Option(help="Characters across. [the terminal's]")] = None,
) -> None:
    """Draw a map file as text: in three states, and in characters that grow denser with the occupancy."""
    from mapper.maps import load_map  # noqa: PLC0415 - start-up
    from mapper.render import RAMP, density, three_state  # noqa: PLC0415 - start-up

    across = shutil.get_terminal_size().columns if width is None else width
    with refusing(map_yaml):
        loaded = load_map(map_yaml)
        pictures = three_state(loaded.grid, across), density(loaded.grid, across)
    geometry = loaded.grid.geometry
    typer.echo(
        f"{map_yaml.name}: {geometry.rows} × {geometry.cols} cells of {geometry.resolution:g} m, "
        f"{loaded.description.mode}, origin {', '.join(f'{value:g}' for value in geometry.origin)}"
    )
    for note in loaded.notes:
        typer.echo(f"note: {note}")
    typer.echo("\n# occupied   . free   ? unknown\n" + pictures[0])
    typer.echo(f"\n{RAMP[0]} free … {RAMP[-1]} occupied, blank: never observed\n" + pictures[1])


@bench_app.callback()
def bench() -> None:
    """Measure, in this process, without reading and start-up."""


@bench_app.command("map")
@with_parameter_options("resolution", "range_max")
def bench_map_command(
    log: LogPath,
    trajectory: Annotated[str | None, typer.Option(metavar="NAME", help="Poses to map with. [the log's first]")] = None,
    repeats: Annotated[int, typer.Option(help="Times each kind of update is measured; the best counts.")] = 5,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Measure how long a log's map takes: the best of several runs, for each kind of update."""
    from mapper.bench import bench_map  # noqa: PLC0415 - start-up

    config = configured(given_parameters(parameters))
    scans = read_log(log)
    with refusing(log):
        measured = bench_map(scans, config, repeats, trajectory)
    facts = {
        "log": scans.name,
        "scans": scans.n_scans,
        "beams": scans.n_beams,
        "resolution": config.resolution,
        "range_max": config.range_max,
        **measured,
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{scans.name}: {scans.n_scans} scans of {scans.n_beams} beams at {config.resolution:g} m a cell")
    typer.echo(f"  per beam {measured['per_beam_ms']:.1f} ms, {measured['cells']} cell updates")
    typer.echo(f"  per scan {measured['per_scan_ms']:.1f} ms, {measured['per_scan_cells']} cell updates")


def main() -> None:
    """Run the command line."""
    app(prog_name="gridbloom")
