"""``report`` writes the report on a log as one page of HTML, or as PDF."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from mapper.core.errors import MapperError
from mapper.diagnosis import Event, diagnose
from mapper.io.contents.inspection import inspect
from mapper.io.contents.model import CAMERAS
from mapper.io.contents.pictures import picture_of
from mapper.io.contents.seeking import message_at
from mapper.mapping.parameters import MappingConfig, recorded_defaults
from mapper.sensors.scan import ScanLog
from mapper.slam import SlamProgress, slam_log
from server.cli.commands import app
from server.cli.common import (
    LogPath,
    Mount,
    TfTopic,
    TopicNames,
    TumTrajectory,
    configured,
    fail,
    given_parameters,
    output_file,
    progress_bar,
    refusing,
    with_parameter_options,
)
from server.cli.poses.slam import SLAM, with_slam_poses
from server.cli.reading import read_joint, with_corrections
from server.library.annotations.note_files import MapFrame, notes_from_geojson
from server.report import Picture, PlacedNote, make_report, report_page, report_pdf


@app.command()
@with_parameter_options("mount_upside_down", "time_offset", "resolution")
def report(
    log: LogPath,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="HTML, or a .pdf.")] = Path("report.html"),
    topic: TopicNames = None,
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Poses of the map, or with --slam those to correct; the map along the log's first ones is shown "
            "before it.",
        ),
    ] = None,
    slam: Annotated[
        bool, typer.Option("--slam", help="Correct the poses (SLAM): the maps before and after it.")
    ] = False,
    notes: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Notes on the log, GeoJSON as its page writes them."),
    ] = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    mount: Mount = None,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Write a report on a log: facts, events, findings, maps, drift, a picture, notes, parameters and versions."""
    values = given_parameters(parameters, mount)
    config = configured(values)
    scans = read_joint(log, topic or (), tum_trajectory, tf)
    name = trajectory or (list(scans.trajectories)[-1] if tum_trajectory is not None else scans.default_trajectory)
    if slam:
        with refusing(log), progress_bar("SLAM") as bar:
            scans, name = _corrected(log, scans, config, trajectory, bar), SLAM
    placed = [] if notes is None else _notes(notes, scans.trajectory(name).offset)
    with refusing(log), progress_bar("Examining") as bar:
        corrected = with_corrections(log, scans, replace(config, time_offset=0.0))
        diagnosis = diagnose(corrected, name, bar, time_offset=config.time_offset)
        shown = config.with_values(recorded_defaults(scans.beam_width, values))
        content = make_report(
            scans, name, diagnosis, shown, picture=_picture(log, scans, diagnosis.events), notes=placed
        )
        page = report_page(content)
        data = report_pdf(page) if out.suffix.lower() == ".pdf" else page.encode()
    with output_file(out) as file:
        file.write(data)
    typer.echo(f"{out} written")


def _corrected(
    path: Path, log: ScanLog, config: MappingConfig, trajectory: str | None, bar: Callable[[float], None] | None
) -> ScanLog:
    """Return the log with its poses from ``trajectory`` (None: from odometry) corrected by SLAM."""

    def show(done: SlamProgress) -> None:
        if bar is not None:
            bar(done.fraction)

    return with_slam_poses(log, slam_log(with_corrections(path, log, config), trajectory=trajectory, progress=show))


def _notes(path: Path, offset: tuple[float, float]) -> list[PlacedNote]:
    with refusing(path):
        try:
            data = path.read_bytes()
        except OSError as error:
            fail(f"{path}: {error.strerror}")
        return [PlacedNote.of(text, pin) for text, pin in notes_from_geojson(data, MapFrame("map", offset))]


def _picture(path: Path, log: ScanLog, events: tuple[Event, ...]) -> Picture | None:
    """Return the first camera's picture at the first event, otherwise at the middle; None if there is none."""
    if not log.n_scans:
        return None
    scan = events[0].scan if events else log.n_scans // 2
    stamp_ns = int(log.stamps_ns[scan])
    try:
        topics = [topic for topic in inspect(path).topics if topic.type in CAMERAS]
        if not topics:
            return None
        message = message_at(path, topics[0].name, stamp_ns)
        data, media_type = picture_of(message.type, message.data, cdr=message.cdr)
    except MapperError:
        return None  # the report does not need a readable picture
    return Picture(data, media_type, topics[0].name, (stamp_ns - int(log.stamps_ns.min())) * 1e-9)
