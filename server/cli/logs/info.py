"""``info`` and ``doctor``: the contents of a log, and its diagnosis."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer
from msgspec import to_builtins

from mapper.core.errors import ReadError
from mapper.diagnosis import diagnose
from mapper.io.clouds.depth_folder import is_depth_folder
from mapper.io.clouds.reading import TEXT, format_of
from mapper.io.contents.inspection import Held, open_held, open_inspected
from mapper.io.contents.model import TopicContents
from mapper.io.contents.report import excerpt
from mapper.io.logs import is_log, open_robot_log
from mapper.io.logs.selection import Selection
from mapper.io.logs.summary import TimeSummary, summarise
from mapper.mapping.parameters import recorded_defaults
from mapper.sensors.robot_log import RobotLog
from mapper.sensors.scan import ScanLog, Topic
from server.cli.clouds.map3d import describe_octree
from server.cli.clouds.surface import describe_mesh
from server.cli.commands import app
from server.cli.common import (
    AsJson,
    LogPath,
    Mount,
    TfTopic,
    TopicName,
    TopicNames,
    TrajectoryName,
    TumTrajectory,
    configured,
    fail,
    given_parameters,
    output_file,
    print_json,
    print_notes,
    progress_bar,
    refusing,
    with_parameter_options,
)
from server.cli.logs.held import (
    clouds_facts,
    contents_facts,
    imus_facts,
    print_cloud,
    print_depth_folder,
    print_held,
    size_line,
    stream_line,
    topic_line,
)
from server.cli.map_files import describe_map
from server.cli.maps.map_log import cause_and_drift
from server.cli.reading import read_joint, with_corrections, with_tum
from server.version import package_version

REPORT = "gridbloom-report.json"  #: file that ``info --report`` writes, in the current folder
#: Endings of text clouds that look like other tables of numbers.
TEXT_ENDINGS = {".xyz", ".xyzi", ".xyzn", ".xyzrgb", ".pts", ".csv", ".asc", ".neu", ".txt"}


@app.command()
@with_parameter_options("mount_upside_down", "time_offset")
def info(
    log: LogPath,
    topic: TopicName = None,
    trajectory: TrajectoryName = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    contents: Annotated[
        bool, typer.Option(help="Go through the whole recording for the size, span and rate of every topic.")
    ] = True,
    report: Annotated[
        bool,
        typer.Option(
            "--report",
            help=f"Write {REPORT}: what the log is made of, without its readings and names, to attach to a report of a "
            "log that is not read, or read wrong.",
        ),
    ] = False,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Print the contents of a log, a recording, a cloud, a scan graph, depth images, an octree, a mesh or a map."""
    if report:
        _write_report(log)
        return

    if any(describe(log, as_json=as_json) for describe in (describe_octree, describe_mesh, describe_map)):
        return

    if _print_cloud(log, as_json=as_json):
        return
    read = _read(log, topic, tf, with_contents=contents)
    if isinstance(read, Held):
        print_held(log, read, as_json=as_json)
        return
    robot, topics = read
    scans = with_tum(robot.first, tum_trajectory)
    summary = summarise(scans)
    notes = [*summary.notes, *_causes(scans, trajectory, given_parameters(parameters, mount))]
    clouds, imus = clouds_facts(robot.clouds), imus_facts(robot.imus)
    if as_json:
        more = {"contents": contents_facts(topics), "clouds": to_builtins(clouds), "imus": to_builtins(imus)}
        print_json(asdict(summary) | {"notes": notes} | more)
        return
    typer.echo(f"{summary.name}: {summary.format}")
    typer.echo(
        f"  {summary.scans} scans of {summary.beams} beams over {summary.field_of_view_deg:.1f}°, "
        f"{summary.duration_s:.1f} s"
    )
    typer.echo(f"  {_time_line(summary.time)}")
    n = summary.readings
    typer.echo(f"  {n.measured} readings measured, {n.no_return} without return, {n.invalid} invalid")
    typer.echo(
        f"  sensor on the robot at {', '.join(f'{value:g}' for value in summary.mount)} (m, m, rad)"
        + (", upside-down" if summary.upside_down else "")
    )
    for path in summary.trajectories:
        typer.echo(f"  trajectory {path.name}: {path.length_m:.1f} m, {path.description}")
    others = {topic.name: topic for topic in topics}
    for topic_of_scans in summary.topics:
        contents_of = others.pop(topic_of_scans.name, None)
        size = "" if contents_of is None else size_line(contents_of, with_rate=topic_of_scans.rate_hz is None)
        typer.echo(f"  {'*' if topic_of_scans.chosen else ' '} {_sensor_line(topic_of_scans)}{size}")
    for other in others.values():
        typer.echo(f"    {topic_line(other)}")
    for line in (*map(stream_line, clouds), *map(stream_line, imus)):
        typer.echo(f"  {line}")
    print_notes(notes)


def _write_report(path: Path) -> None:
    """Write the excerpt of a log, whether or not it can be read."""
    if not path.exists():
        fail(f"{path}: There is no such file.")
    text = json.dumps({"gridbloom": package_version()} | excerpt(path), indent=1, ensure_ascii=False, allow_nan=False)
    with output_file(Path(REPORT)) as file:
        file.write(text.encode())
    typer.echo(
        f"wrote {REPORT}, {len(text.encode()):,} bytes: types, topics, frames, counts, limits and notes. Readings, "
        "positions and names of files, users and machines are not in it; look at it before you attach it."
    )


def _causes(log: ScanLog, trajectory: str | None, parameters: dict[str, object]) -> list[str]:
    """Return the note of ``map`` on the cause of a bad map, if it is known."""
    config = configured(recorded_defaults(log.beam_width, parameters))

    return [line for line in cause_and_drift(log, trajectory, config) if line]


def _print_cloud(path: Path, *, as_json: bool) -> bool:
    """Print a cloud, a scan graph or a folder of depth images; return whether it is one."""
    if is_depth_folder(path):
        print_depth_folder(path, as_json=as_json)
        return True
    kind = None
    if path.is_file():
        with refusing(path):
            kind = format_of(path)
    if kind is None or (
        kind == TEXT and (not {suffix.lower() for suffix in path.suffixes} & TEXT_ENDINGS or is_log(path))
    ):
        return False
    print_cloud(path, kind, as_json=as_json)
    return True


def _read(
    log: Path, topic: str | None, tf: str | None, *, with_contents: bool
) -> tuple[RobotLog, tuple[TopicContents, ...]] | Held:
    """Return a log and, if requested, every topic of a recording, in one pass; end the command on errors.

    For a recording without scans, return its other contents.
    """
    with refusing(log), progress_bar("Reading") as bar:
        if not with_contents:
            return open_robot_log(log, selection=Selection.of(topic, tf=tf), progress=bar), ()
        try:
            robot, contents = open_inspected(log, selection=Selection.of(topic, tf=tf), progress=bar)
        except ReadError as error:
            content = open_held(log) if error.code == "log.no_scans" and topic is None else None
            if content is None or not content.contents.topics:
                raise
            return replace(content, no_scans=error.message)
        return robot, contents.topics


def _time_line(time: TimeSummary | None) -> str:
    """Return a line with the time of a log's scans."""
    if time is None or time.rate_hz is None:
        return "no times"
    parts = [] if time.start_s is None else [f"from {datetime.fromtimestamp(time.start_s, UTC):%Y-%m-%d %H:%M:%S} UTC"]
    parts.append(f"{time.rate_hz:.1f} scans a second")
    gaps = f"{time.gaps} gap{'s' if time.gaps != 1 else ''}"
    at = f", the longest of {time.longest_gap_s:.1f} s at {time.longest_gap_at_s:.1f} s" if time.gaps else ""
    return ", ".join(parts) + f", {gaps}{at}"


def _sensor_line(topic: Topic) -> str:
    """Return a line with the facts about one topic of a log."""
    parts = [f"{topic.name}: {topic.count} × {topic.type}"]
    if topic.beams is not None:
        parts.append(f"{topic.beams} beam{'s' if topic.beams != 1 else ''} over {topic.field_of_view_deg:.1f}°")
    if topic.rate_hz is not None:
        parts.append(f"{topic.rate_hz:.1f} Hz")
    if topic.frame:
        parts.append(f"frame {topic.frame}")
    if topic.mount is not None:
        parts.append(f"at {', '.join(f'{value:g}' for value in topic.mount)}")
    return ", ".join(parts)


FEW = 5  #: scan numbers printed per finding


@app.command()
@with_parameter_options("mount_upside_down", "time_offset")
def doctor(
    log: LogPath,
    topic: TopicNames = None,
    trajectory: Annotated[str | None, typer.Option(metavar="NAME", help="Poses to examine. [the log's first]")] = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Print what is wrong with a log, where, with what confidence, and what to do about it; then its events.

    Events are pushes, slips and lifts of the robot, which its wheels did not measure, and steps of its clock.
    """
    config = configured(given_parameters(parameters, mount))
    of_mount = replace(config, time_offset=0.0)  # the doctor takes the offset into account itself
    scans = with_corrections(log, read_joint(log, topic or (), tum_trajectory, tf), of_mount)
    with refusing(log), progress_bar("Examining") as bar:
        diagnosis = diagnose(scans, trajectory, bar, time_offset=config.time_offset)
    findings, events = diagnosis.findings, diagnosis.events
    if as_json:
        print_json(
            {
                "log": scans.name,
                "findings": [finding.public() for finding in findings],
                "events": [event.public() for event in events],
            }
        )
        return
    counts = [(len(findings), "finding"), (len(events), "event")]
    totals = [f"{n} {name}{'' if n == 1 else 's'}" for n, name in counts if n or name == "finding"]
    typer.echo(f"{scans.name}: {', '.join(totals)}")
    for finding in findings:
        possible = "possible, " if finding.possible else ""
        of = f" of {finding.sensor}" if finding.sensor else ""
        typer.echo(f"  {finding.check}{of} ({possible}{100 * finding.sure:.0f} % sure): {finding.sentence}")
        typer.echo(f"    {finding.advice}")
        if finding.scans:
            more = ", …" if len(finding.scans) > FEW else ""
            typer.echo(f"    at scan {', '.join(map(str, finding.scans[:FEW]))}{more}")
        if finding.parameters:
            typer.echo(f"    with {', '.join(f'{name} = {value}' for name, value in finding.parameters.items())}")
    for event in events:
        utc = "" if event.utc is None else f", {event.utc}"
        typer.echo(f"  {event.kind} at {event.time}{utc}: {event.sentence}")
        typer.echo(f"    at scan {event.scan}")
