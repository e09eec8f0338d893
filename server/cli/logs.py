"""``info`` and ``doctor``: the contents of a log, and its diagnosis."""

from __future__ import annotations

from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from server.cli.app import app
from server.cli.common import (
    AsJson,
    LogPath,
    TopicName,
    TopicNames,
    TumTrajectory,
    configured,
    given_parameters,
    print_json,
    progress_bar,
    read_joint,
    refusing,
    with_parameter_options,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mapper.io.contents.model import TopicContents
    from mapper.sensors.robot_log import RobotLog


@app.command()
def info(
    log: LogPath,
    topic: TopicName = None,
    contents: Annotated[
        bool, typer.Option(help="Go through the whole recording for the size, span and rate of every topic.")
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Print the contents of a log, or of an octree of OctoMap."""
    from server.cli.map3d import describe_octree  # noqa: PLC0415 - start-up

    if describe_octree(log, as_json=as_json):
        return
    from mapper.io.logs.summary import summarise  # noqa: PLC0415 - start-up

    robot, topics = _read(log, topic, with_contents=contents)
    facts = asdict(summarise(robot.first))
    facts["contents"] = [asdict(one) | {"span_s": one.span_s, "rate_hz": one.rate_hz} for one in topics]
    facts["clouds"], facts["imus"] = _clouds(robot), _imus(robot)
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
    held = {one["name"]: one for one in facts["contents"]}
    for one in facts["topics"]:
        more = held.pop(one["name"], None)
        size = "" if more is None else _size_line(more, with_rate=one["rate_hz"] is None)
        typer.echo(f"  {'*' if one['chosen'] else ' '} {_topic_line(one)}{size}")
    for one in held.values():
        typer.echo(f"    {one['name']}: {one['messages']} × {one['type']}{_size_line(one)}")
    for one in [*facts["clouds"], *facts["imus"]]:
        typer.echo(f"  {_stream_line(one)}")
    for note in facts["notes"]:
        typer.echo(f"  note: {note}")


def _read(log: Path, topic: str | None, *, with_contents: bool) -> tuple[RobotLog, tuple[TopicContents, ...]]:
    """Return a log, and every topic of a recording if they are wanted, in one pass; end the command where it fails."""
    from mapper.io.contents.inspection import open_inspected  # noqa: PLC0415 - start-up
    from mapper.io.logs import open_robot_log  # noqa: PLC0415 - start-up
    from mapper.io.logs.selection import Selection  # noqa: PLC0415 - start-up

    with refusing(log), progress_bar("Reading") as bar:
        if not with_contents:
            return open_robot_log(log, selection=Selection.of(topic), progress=bar), ()
        robot, contents = open_inspected(log, selection=Selection.of(topic), progress=bar)
        return robot, contents.topics


def _clouds(robot: RobotLog) -> list[dict[str, Any]]:
    """Return what the clouds of a recording are, by the first of each topic."""
    found = []
    for stream in robot.clouds.values():
        first = next(iter(stream), None)
        if first is None:
            continue
        said = {"height": first.shape[0], "width": first.shape[1]} if first.shape else {}
        fields = {"fields": list(first.fields), "has_times": first.times is not None}
        mount = _place(stream.mounts(first.frame_id, np.array([first.stamp_ns])))
        found.append(
            {"topic": stream.topic, "count": stream.count, "frame": first.frame_id, **said, **fields, "mount": mount}
        )
    return found


def _imus(robot: RobotLog) -> list[dict[str, Any]]:
    """Return what the IMUs of a recording are, by the first messages of each topic."""
    found = []
    for stream in robot.imus.values():
        first = next(iter(stream), None)
        if first is None:
            continue
        has_orientation = bool(np.isfinite(first.orientation).any())
        mount = _place(stream.mounts(first.frame_id, first.stamps_ns[:1]))
        found.append(
            {"topic": stream.topic, "count": stream.count, "frame": first.frame_id,
             "has_orientation": has_orientation, "mount": mount}
        )  # fmt: skip
    return found


def _place(mounts: NDArray[np.float64] | None) -> list[float] | None:
    """Return the place x, y, z (m) of the first of the mounts (n, 4, 4)."""
    return None if mounts is None else [round(float(value), 6) for value in mounts[0, :3, 3]]


def _stream_line(one: dict[str, Any]) -> str:
    """Say what the clouds or the IMU of one topic are."""
    at = "" if one["mount"] is None else f" at {', '.join(f'{value:g}' for value in one['mount'])} m"
    said = f"frame {one['frame']}{at}"
    if "fields" not in one:
        return f"IMU {one['topic']}: {one['count']} messages, {said}" + (
            ", with orientation" if one["has_orientation"] else ""
        )
    times = ", a time for each point" if one["has_times"] else ""
    fields = ", ".join(["x, y, z", *one["fields"]])
    return f"clouds {one['topic']}: {one['count']} of {one['width']} × {one['height']} points ({fields}){times}, {said}"


def _size_line(topic: dict[str, Any], *, with_rate: bool = True) -> str:
    """Say how large a topic is, over which time, and how often it comes."""
    size, unit = float(topic["bytes"]), "B"
    for larger in ("kB", "MB", "GB"):
        if size >= 1000.0:
            size, unit = size / 1000.0, larger
    rate = f", {topic['rate_hz']:.1f} Hz" if with_rate and topic["rate_hz"] is not None else ""
    return f"{rate}, {size:.{0 if unit == 'B' else 1}f} {unit} in {topic['span_s']:.1f} s"


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


FEW = 5  #: scan numbers printed per finding


@app.command()
@with_parameter_options("time_offset")
def doctor(
    log: LogPath,
    topic: TopicNames = None,
    trajectory: Annotated[str | None, typer.Option(metavar="NAME", help="Poses to examine. [the log's first]")] = None,
    tum_trajectory: TumTrajectory = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Print what is wrong with a log, where, with what confidence, and what to do about it."""
    from mapper.diagnosis import examine  # noqa: PLC0415 - start-up

    config = configured(given_parameters(parameters))
    scans = read_joint(log, topic or (), tum_trajectory)
    with refusing(log), progress_bar("Examining") as bar:
        found = examine(scans, trajectory, bar, time_offset=config.time_offset)
    if as_json:
        print_json({"log": scans.name, "findings": [finding.public() for finding in found]})
        return
    typer.echo(f"{scans.name}: {len(found)} finding{'' if len(found) == 1 else 's'}")
    for finding in found:
        possible = "possible, " if finding.possible else ""
        of = f" of {finding.sensor}" if finding.sensor else ""
        typer.echo(f"  {finding.check}{of} ({possible}{100 * finding.sure:.0f} % sure): {finding.sentence}")
        typer.echo(f"    {finding.advice}")
        if finding.scans:
            more = ", …" if len(finding.scans) > FEW else ""
            typer.echo(f"    at scan {', '.join(map(str, finding.scans[:FEW]))}{more}")
        if finding.parameters:
            typer.echo(f"    with {', '.join(f'{name} = {value}' for name, value in finding.parameters.items())}")
