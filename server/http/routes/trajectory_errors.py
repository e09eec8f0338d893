"""``/api/sessions/{id}/trajectory-errors``: errors of a session's trajectory against another one, as in evo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from fastapi import APIRouter, Query, Request
from numpy.typing import NDArray

from mapper.evaluation import Alignment, ComparisonOptions, ErrorSeries, ErrorStatistics
from mapper.io.contents.downsampling import min_max
from mapper.io.contents.scan_series import plot_origin_ns
from mapper.sensors.scan import ScanLog
from server.http.clients import in_turn
from server.http.computed_series import errors_between
from server.http.guests import GuestRight, guests_may
from server.http.services import RequestWork, Sessions, Visitor
from server.http.session_access import part_of_log
from server.sessions.parts import Recording

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

PATH_POINTS = 2000  #: points of each path
BUCKETS = 500  #: of the errors over time

Name = Annotated[str, Query(max_length=400, description="Name of one of the log's trajectories.")]


@dataclass(frozen=True, slots=True)
class ErrorFigures:
    """Statistics of the errors of position and heading."""

    translation_m: ErrorStatistics
    rotation_rad: ErrorStatistics


@dataclass(frozen=True, slots=True)
class RelativeFigures(ErrorFigures):
    """Statistics of relative errors over ``delta`` of a ``unit``."""

    delta: float
    unit: str
    pairs: int


@dataclass(frozen=True, slots=True)
class ErrorsOverTime:
    """Errors at some times, seconds since the log's first scan."""

    times: list[float]
    translation_m: list[float]
    rotation_rad: list[float]


@dataclass(frozen=True, slots=True)
class SeriesOfErrors:
    """Absolute and relative errors over time."""

    absolute: ErrorsOverTime
    relative: ErrorsOverTime


@dataclass(frozen=True, slots=True)
class ComparedPaths:
    """Positions of both trajectories in the frame of the reference, metres, and the errors there."""

    reference: list[tuple[float, float]]
    estimate: list[tuple[float, float]]
    errors_m: list[float]


@dataclass(frozen=True, slots=True)
class TrajectoryErrors:
    """The errors of a trajectory: figures, errors over time, both paths."""

    pairs: int
    alignment: Alignment
    absolute: ErrorFigures
    relative: RelativeFigures
    series: SeriesOfErrors
    paths: ComparedPaths


@router.get("/{session_id}/trajectory-errors")
@guests_may(GuestRight.LINKED_SESSION)
async def errors(
    request: Request,
    sessions: Sessions,
    visitor: Visitor,
    work: RequestWork,
    session_id: str,
    reference: Name,
    estimate: Name,
    align: Annotated[
        Literal["rigid", "scaled", "origin", "none"], Query(description="How the estimate is brought onto the other.")
    ] = "rigid",
    delta: Annotated[float, Query(gt=0.0, le=1e6, description="Distance or time of the relative error.")] = 1.0,
    unit: Annotated[Literal["m", "s", "frames"], Query(description="Unit of delta.")] = "m",
) -> TrajectoryErrors:
    """Return absolute and relative errors of a trajectory at the log's scans: figures, errors over time, both paths.

    The definitions are those of ``gridbloom evaluate``. Paths are in the frame of ``reference``, the estimate aligned.
    """
    session = sessions.get(session_id)
    log = part_of_log(session, Recording, "Only the trajectories of a log can be compared.").log
    options = ComparisonOptions(align=align, delta=delta, delta_unit=unit)
    return await in_turn(request, work, visitor, lambda: _errors(log, reference, estimate, options))


def _errors(log: ScanLog, reference: str, estimate: str, options: ComparisonOptions) -> TrajectoryErrors:
    errors = errors_between(log, reference, estimate, options)
    origin_ns = plot_origin_ns(log)
    step = max(1, -(-len(errors.estimate) // PATH_POINTS))
    translation, rotation = errors.relative_translation, errors.relative_rotation
    return TrajectoryErrors(
        pairs=len(errors.estimate),
        alignment=errors.alignment,
        absolute=ErrorFigures(errors.absolute_translation.statistics, errors.absolute_rotation.statistics),
        relative=RelativeFigures(
            translation.statistics, rotation.statistics, options.delta, options.delta_unit, len(translation.errors)
        ),
        series=SeriesOfErrors(
            _over_time(errors.absolute_translation, errors.absolute_rotation, origin_ns),
            _over_time(translation, rotation, origin_ns),
        ),
        paths=ComparedPaths(
            _places(errors.reference.poses[::step]),
            _places(errors.estimate.poses[::step]),
            errors.absolute_translation.errors[::step].round(6).tolist(),
        ),
    )


def _over_time(translation: ErrorSeries, rotation: ErrorSeries, origin_ns: int) -> ErrorsOverTime:
    order = np.argsort(translation.stamps_ns, kind="stable")
    both = np.column_stack([translation.errors, rotation.errors])[order].astype(np.float32)
    stamps, values = min_max(translation.stamps_ns[order], both, BUCKETS)
    return ErrorsOverTime(
        ((stamps - origin_ns) * 1e-9).round(6).tolist(),
        values[:, 0].round(6).tolist(),
        values[:, 1].round(6).tolist(),
    )


def _places(poses: NDArray[np.float64]) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in poses[:, :2].round(4)]
