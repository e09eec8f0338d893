"""The error of poses against known relations between places: the metric of SLAM benchmarks.

Source: Kümmerle et al. 2009, On measuring the accuracy of SLAM algorithms, Autonomous Robots 27(4), equations 5 to 7
with unit weights and unsquared errors, as its tables have them: the mean over all relations of the length, and of the
angle, of the motion that is left between the known relation and the poses' one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.evaluation.pose_error import magnitudes
from mapper.evaluation.record_order import poses_at_records, records_at, records_of_relations
from mapper.evaluation.statistics import ErrorSeries
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses, check_poses

Float64Array = NDArray[np.float64]
MOST = 0.9  #: of the stamps must be those of records, for the relations to be in record order


@dataclass(frozen=True, slots=True)
class Relations:
    """Known motions between places: ``motions`` (n, 3), ``T_first_second`` in metres and radians, from the first to the
    second of the times ``stamps_ns`` (n, 2). Raises :class:`ConfigError` for other shapes.
    """

    stamps_ns: NDArray[np.int64]
    motions: Float64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "stamps_ns", np.ascontiguousarray(self.stamps_ns, dtype=np.int64))
        object.__setattr__(self, "motions", np.ascontiguousarray(self.motions, dtype=np.float64))
        if self.stamps_ns.shape != (len(self.motions), 2):
            raise ConfigError("relations.stamps", f"Relations need two stamps each, not {self.stamps_ns.shape}.")
        check_poses(self.motions, (len(self.stamps_ns), 3))

    def __len__(self) -> int:
        return len(self.stamps_ns)


@dataclass(frozen=True, slots=True)
class RelationErrors:
    """The errors of the poses over the relations, each at its first stamp; translations metres, rotations radians.

    ``policy`` is "records", where the stamps were mapped to the odometry messages of the log, or "time", where poses
    were interpolated between scans. ``unambiguous`` (n,) marks errors of relations of whose stamps each has one record
    only; with the policy "time" it is all true. ``left_out`` counts relations with a stamp that the log does not have.
    """

    policy: str
    translation: ErrorSeries
    rotation: ErrorSeries
    unambiguous: NDArray[np.bool_]
    left_out: int

    def only_unambiguous(self) -> tuple[ErrorSeries, ErrorSeries]:
        """Return the errors of translation and rotation of the relations without a choice."""
        clear = self.unambiguous
        return (
            ErrorSeries(self.translation.stamps_ns[clear], self.translation.errors[clear]),
            ErrorSeries(self.rotation.stamps_ns[clear], self.rotation.errors[clear]),
        )


def evaluate_relations(
    relations: Relations, scans: TimedPoses, records: OdometryRecords | None = None
) -> RelationErrors:
    """Return the errors of ``scans``, the poses to judge, one for each scan of a log in the log's order.

    ``records`` are the odometry messages of that log. Where nearly all stamps of the relations are theirs, to 5.2 ms,
    the order of the records counts, not the stamps (:mod:`mapper.evaluation.record_order`). Where several records
    have a stamp, the one that fits the raw odometry best is taken, which makes the figures over all relations slightly
    optimistic: the unambiguous relations are the judge. Without records the poses are interpolated in time between the
    scans, of which those with the stamp of one before do not count, and nothing is extrapolated.

    Raises :class:`ConfigError` where there are no relations or poses, the poses are not as many as the records' scans,
    and no relation is at the log's time.
    """
    if not len(relations) or not len(scans):
        raise ConfigError("evaluation.no_relations", "There are no relations, or no poses, to compare.")
    if records is not None and len(records.before_scan) != len(scans):
        raise ConfigError(
            "evaluation.scan_count", f"{len(records.before_scan)} scans need as many poses, not {len(scans)}."
        )
    if records is not None and (records.before_scan >= 0).any() and _are_records(relations, records):
        indices, clear = records_of_relations(relations.stamps_ns, relations.motions, records.messages)
        found = (indices >= 0).all(axis=1)
        poses = poses_at_records(records, scans.poses)
        policy, ends = "records", poses[indices[found]]
    else:
        known = _first_of_each_stamp(scans)
        found = known.covers(relations.stamps_ns.ravel()).reshape(-1, 2).all(axis=1)
        clear = np.ones(len(relations), dtype=np.bool_)
        inside = relations.stamps_ns[found]
        policy, ends = "time", np.stack([known.at(inside[:, 0]), known.at(inside[:, 1])], axis=1)
    if not found.any():
        raise ConfigError("evaluation.no_relations", "No relation is at a time of the log.")
    motions = compose(inverse(ends[:, 0]), ends[:, 1])
    translation, rotation = magnitudes(compose(inverse(relations.motions[found]), motions))
    stamps = relations.stamps_ns[found, 0]
    return RelationErrors(
        policy,
        ErrorSeries(stamps, translation),
        ErrorSeries(stamps, rotation),
        clear[found],
        int(np.count_nonzero(~found)),
    )


def _are_records(relations: Relations, records: OdometryRecords) -> bool:
    with_record = [bool(len(found)) for found in records_at(np.unique(relations.stamps_ns), records.messages)]
    return float(np.mean(with_record)) > MOST


def _first_of_each_stamp(scans: TimedPoses) -> TimedPoses:
    return scans.take(np.unique(scans.stamps_ns, return_index=True)[1])
