"""``/api/sessions/{id}/trajectory-errors``: one trajectory of a session's log against another one, as evo does."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Query, Request
from numpy.typing import NDArray

from mapper.core.errors import MapperError
from mapper.evaluation import Comparison, ComparisonOptions, ErrorSeries, compare_trajectories
from mapper.io.contents.downsampling import min_max
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses
from server.http.guests import GuestRight, guests_may
from server.http.request_work import in_turn
from server.http.services import RequestWork, Sessions, Visitor
from server.sessions.parts import Recording

router = APIRouter(prefix="/api/sessions", tags=["sessions"])

PATH_POINTS = 2000  #: points of each path
BUCKETS = 500  #: of the errors over time

Name = Annotated[str, Query(max_length=400, description="Name of one of the log's trajectories.")]


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
) -> dict[str, Any]:
    """Return absolute and relative errors of a trajectory at the log's scans: figures, courses over time, both paths.

    The definitions are those of ``gridbloom evaluate``. Paths are in the frame of ``reference``, the estimate aligned.
    """
    recording = sessions.get(session_id).model.find(Recording)
    if recording is None:
        raise MapperError("session.not_a_log", "Only the trajectories of a log can be compared.")
    log = recording.log
    options = ComparisonOptions(align=align, delta=delta, delta_unit=unit)
    return await in_turn(request, work, visitor, lambda: _errors(log, reference, estimate, options))


def _errors(log: ScanLog, reference: str, estimate: str, options: ComparisonOptions) -> dict[str, Any]:
    sides = [TimedPoses(log.stamps_ns, log.trajectory(name).poses) for name in (reference, estimate)]
    found = compare_trajectories(sides[0], sides[1], options)
    origin_ns = int(log.stamps_ns.min())
    step = max(1, -(-len(found.estimate) // PATH_POINTS))
    return {
        "pairs": len(found.estimate),
        "alignment": asdict(found.alignment),
        "absolute": _figures(found.absolute_translation, found.absolute_rotation),
        "relative": _figures(found.relative_translation, found.relative_rotation)
        | {"delta": options.delta, "unit": options.delta_unit, "pairs": len(found.relative_translation.errors)},
        "series": {
            "absolute": _course(found.absolute_translation, found.absolute_rotation, origin_ns),
            "relative": _course(found.relative_translation, found.relative_rotation, origin_ns),
        },
        "paths": _paths(found, step),
    }


def _figures(translation: ErrorSeries, rotation: ErrorSeries) -> dict[str, Any]:
    return {"translation_m": asdict(translation.statistics), "rotation_rad": asdict(rotation.statistics)}


def _course(translation: ErrorSeries, rotation: ErrorSeries, origin_ns: int) -> dict[str, list[float]]:
    order = np.argsort(translation.stamps_ns, kind="stable")
    both = np.column_stack([translation.errors, rotation.errors])[order].astype(np.float32)
    stamps, values = min_max(translation.stamps_ns[order], both, BUCKETS)
    return {
        "times": ((stamps - origin_ns) * 1e-9).round(6).tolist(),
        "translation_m": values[:, 0].round(6).tolist(),
        "rotation_rad": values[:, 1].round(6).tolist(),
    }


def _paths(found: Comparison, step: int) -> dict[str, list[Any]]:
    def places(poses: NDArray[np.float64]) -> list[Any]:
        return list(poses[::step, :2].round(4).tolist())

    return {
        "reference": places(found.reference.poses),
        "estimate": places(found.estimate.poses),
        "errors_m": found.absolute_translation.errors[::step].round(6).tolist(),
    }
