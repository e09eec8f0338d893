"""The contents of a report: facts, events, findings, maps with their figures, notes, parameters and versions."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np

from mapper.core.array_types import Float64Array
from mapper.diagnosis.figures import MapFigures, map_figures
from mapper.diagnosis.verdict import map_of
from mapper.io.logs.summary import path_length, recorded_seconds, start_s
from mapper.mapping.parameters import PARAMETERS, MappingConfig, recorded_defaults
from mapper.replay.overview import FREE, OCCUPIED, UNOBSERVED
from mapper.sensors.joint_log import sensors_of
from mapper.sensors.scan import ScanLog
from server.library.packs.picture import png_of
from server.version import package_version

if TYPE_CHECKING:
    from mapper.diagnosis import Diagnosis, Event, Finding
    from server.library.annotations.notes import Pin

MOST_CELLS = 1600  #: along a side of a picture; in a larger map several cells become one pixel
MOST_POSES = 2000  #: of the path in a picture


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of a camera: the file, its media type, the topic, and seconds from the log's first scan."""

    data: bytes
    media_type: str
    topic: str
    seconds: float


@dataclass(frozen=True, slots=True)
class PlacedNote:
    """A note on the log: at a time, seconds from the log's first scan, at a place on the map, metres, or both.

    ``outline`` has the corners of an area around that place, metres, if the note refers to one.
    """

    text: str
    seconds: float | None
    xy: tuple[float, float] | None
    outline: tuple[tuple[float, float], ...] | None = None

    @classmethod
    def of(cls, text: str, pin: Pin) -> PlacedNote:
        """Return a note of the library."""
        return cls(text, pin.at_s, None if pin.x is None or pin.y is None else (pin.x, pin.y), pin.outline)


@dataclass(frozen=True, slots=True)
class ReportMap:
    """A map along one trajectory: the picture as PNG, of ``size_m`` metres from ``low_xy``, and its figures.

    ``path_xy`` is the path of the robot and ``events_xy`` the place of each event, in the frame of ``low_xy``, metres.
    """

    trajectory: str
    png: bytes
    size_px: tuple[int, int]
    size_m: tuple[float, float]
    low_xy: tuple[float, float]
    resolution: float
    figures: MapFigures
    length_m: float
    path_xy: tuple[tuple[float, float], ...]
    events_xy: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Report:
    """A report. ``maps`` has one map, or those before and after a correction of the poses."""

    title: str
    made: datetime
    start_s: float | None
    facts: tuple[tuple[str, str], ...]
    events: tuple[Event, ...]
    findings: tuple[Finding, ...]
    maps: tuple[ReportMap, ...]
    picture: Picture | None
    notes: tuple[PlacedNote, ...]
    parameters: tuple[tuple[str, str], ...]
    changed: frozenset[str]  #: names of the parameters that differ from the default values
    versions: tuple[tuple[str, str], ...]


def make_report(
    log: ScanLog,
    trajectory: str,
    diagnosis: Diagnosis,
    config: MappingConfig,
    *,
    title: str | None = None,
    picture: Picture | None = None,
    notes: Sequence[PlacedNote] = (),
) -> Report:
    """Return the report on ``log`` with the map along ``trajectory``, made with ``config``.

    If that is not the log's first trajectory, the map along the first one precedes it. Raises :class:`ConfigError` for
    an unknown trajectory and :class:`LimitError` for a map that is too large.
    """
    events = tuple(diagnosis.events)
    names = dict.fromkeys((log.default_trajectory, trajectory))
    maps = tuple(_map(log, name, config, events) for name in names)
    first = MappingConfig().with_values(recorded_defaults(log.beam_width))
    values = [(row, getattr(config, row.name)) for row in PARAMETERS]
    return Report(
        title=title or log.name,
        made=datetime.now(UTC),
        start_s=start_s(log.stamps_ns),
        facts=_facts(log, maps[-1]),
        events=events,
        findings=tuple(diagnosis.findings),
        maps=maps,
        picture=picture,
        notes=tuple(notes),
        parameters=tuple((row.name, f"{_value(value)} {row.unit}".strip()) for row, value in values),
        changed=frozenset(row.name for row, value in values if value != getattr(first, row.name)),
        versions=(
            ("Gridbloom", package_version()),
            ("Python", platform.python_version()),
            ("NumPy", np.__version__),
        ),
    )


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _facts(log: ScanLog, last: ReportMap) -> tuple[tuple[str, str], ...]:
    seconds = recorded_seconds(log)
    duration = float(seconds[-1]) if len(seconds) else 0.0
    rate = (log.n_scans - 1) / duration if duration > 0.0 else 0.0
    return (
        ("Log", log.name),
        ("Format", log.format),
        ("Sensor", f"{log.topic or 'lidar'}, {sensors_of(log)[0].n_beams:,} beams"),
        ("Scans", f"{log.n_scans:,}" + (f", {rate:.1f} a second" if rate > 0.0 else ", without times")),
        *((("Duration", f"{duration:,.1f} s"),) if duration > 0.0 else ()),
        ("Driven", f"{last.length_m:,.1f} m along {last.trajectory}"),
        ("Map", f"{last.size_m[0]:.1f} m × {last.size_m[1]:.1f} m, cells of {last.resolution:g} m"),
    )


def _map(log: ScanLog, trajectory: str, config: MappingConfig, events: Sequence[Event]) -> ReportMap:
    grid = map_of(log, trajectory, config)
    free, occupied = grid.observed & (grid.log_odds < 0.0), grid.observed & (grid.log_odds > 0.0)
    seen = np.argwhere(free | occupied)
    low, high = (seen.min(axis=0), seen.max(axis=0) + 1) if len(seen) else (np.zeros(2, int), np.array(free.shape))
    low, high = np.maximum(low - 4, 0), np.minimum(high + 4, free.shape)
    step = -(-int((high - low).max()) // MOST_CELLS)
    rows, cols = (-(-(high - low) // step)).tolist()
    codes = np.full((rows, cols), UNOBSERVED, dtype=np.uint8)
    for cells, code in ((free, FREE), (occupied, OCCUPIED)):
        at = np.argwhere(cells[low[0] : high[0], low[1] : high[1]]) // step
        codes[at[:, 0], at[:, 1]] = code
    cell = grid.geometry.resolution * step
    low_xy = np.array(grid.geometry.origin[:2]) + low[::-1] * grid.geometry.resolution
    poses = log.trajectory(trajectory).poses
    every = max(1, len(poses) // MOST_POSES)
    return ReportMap(
        trajectory=trajectory,
        png=png_of(codes[::-1]),
        size_px=(cols, rows),
        size_m=(cols * cell, rows * cell),
        low_xy=(float(low_xy[0]), float(low_xy[1])),
        resolution=grid.geometry.resolution,
        figures=map_figures(log, trajectory, config, grid),
        length_m=path_length(poses),
        path_xy=_points(poses[::every]),
        events_xy=_points(poses[[event.scan for event in events]]),
    )


def _points(poses: Float64Array) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in poses[:, :2])
