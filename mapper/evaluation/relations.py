"""Error of poses against known relations between places: the metric of SLAM benchmarks.

Source: Kümmerle et al. 2009, On measuring the accuracy of SLAM algorithms, Autonomous Robots 27(4), equations 5 to 7
with unit weights and unsquared errors, as in its tables: the mean over all relations of the length, and of the angle,
of the difference between the known relation and that of the poses.

In logs whose stamps repeat or run backwards, time does not order the poses: of Intel's 13,631 odometry messages 2,459
have the stamp of the previous one and 629 an earlier one, and interpolating in time adds errors of 0.05 m. In these
logs the scans' poses are propagated to every message by the raw odometry between them, and a relation's stamps are
mapped to messages.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.core.se2 import check_poses, compose, inverse
from mapper.evaluation.statistics import ErrorSeries
from mapper.evaluation.trajectory_error import magnitudes
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses

STAMP_TOLERANCE_NS = 5_200_000  #: between a relation's stamp and that of its record: stamps are rounded to 10 ms
SHORT_S = 5.0  #: relations over a shorter time select among records by the odometry, which drifts little in that time
SWEEPS = 6
METRES_PER_RADIAN = 0.4  #: weight of an angle relative to a length in the selection
GREATEST_COST = 0.5  #: metres: cost limit per relation in the selection, so that a wrong one does not decide
MOST = 0.9  #: minimum fraction of the stamps that are those of records, for the relations to be in record order


def poses_at_records(records: OdometryRecords, scan_poses: Float64Array) -> Float64Array:
    """Return the corrected pose (n, 3) at each of n odometry messages from those of the scans (n_scans, 3).

    Between two scans the raw odometry is chained from the scan before, and its difference at the scan after is
    distributed in proportion to the motion (metres and half the radians). Of scans after the same message the first is
    used, and scans before the first message are ignored. Before the first and after the last scan it is odometry alone.
    Requires a scan preceded by a message.
    """
    odometry = records.messages.poses
    at, first = np.unique(records.before_scan, return_index=True)
    at, known = at[at >= 0], scan_poses[first][at >= 0]
    every = np.arange(len(odometry))
    last = len(at) - 1
    low = np.clip(np.searchsorted(at, every, side="right") - 1, 0, max(0, last - 1))
    high = np.minimum(low + 1, last)
    from_low = compose(inverse(odometry[at[low]]), odometry)
    from_high = compose(inverse(odometry[at[high]]), odometry)
    forward, backward = compose(known[low], from_low), compose(known[high], from_high)
    weight = _amount(from_low) / (_amount(from_low) + _amount(from_high))
    weight = np.where(every <= at[0], 0.0, np.where(every >= at[-1], 1.0, weight))
    return compose(forward, compose(inverse(forward), backward) * weight[:, np.newaxis])


def _amount(motions: Float64Array) -> Float64Array:
    return np.asarray(np.hypot(motions[:, 0], motions[:, 1]) + 0.5 * np.abs(motions[:, 2]) + 1e-6)


def records_at(stamps_ns: Int64Array, messages: TimedPoses) -> list[Int64Array]:
    """Return for each of the times (m,) the indices of the messages with practically equal stamps, ascending."""
    order = np.argsort(messages.stamps_ns, kind="stable")
    stamps = messages.stamps_ns[order]
    begin = np.searchsorted(stamps, stamps_ns - STAMP_TOLERANCE_NS, side="left")
    end = np.searchsorted(stamps, stamps_ns + STAMP_TOLERANCE_NS, side="right")
    return [np.sort(order[a:b]) for a, b in zip(begin, end, strict=True)]


def records_of_relations(
    stamps_ns: Int64Array, motions: Float64Array, messages: TimedPoses
) -> tuple[Int64Array, NDArray[np.bool_]]:
    """Return the record of each relation's two stamps (n, 2), −1 for none, and which relations (n,) are unambiguous.

    ``stamps_ns`` (n, 2) and ``motions`` (n, 3) are the relations'. If a stamp has several records, the one is selected
    that agrees best with the raw odometry over the relations of less than :data:`SHORT_S`, in :data:`SWEEPS` rounds.
    """
    times, where = np.unique(stamps_ns, return_inverse=True)
    where = where.reshape(stamps_ns.shape)
    candidates = records_at(times, messages)
    count = np.array([len(candidate) for candidate in candidates])
    chosen = np.array([candidate[0] if len(candidate) else -1 for candidate in candidates])
    odometry = messages.poses

    is_short = np.abs(stamps_ns[:, 1] - stamps_ns[:, 0]) < SHORT_S * 1e9
    # Each relation twice: at its first time and, inverted, at its second.
    begin, end = np.concatenate([where[is_short], where[is_short][:, ::-1]]).T
    expected = np.tile(motions[is_short], (2, 1))
    turned = np.arange(len(begin)) >= np.count_nonzero(is_short)
    order = np.flatnonzero(count[end] > 0)
    order = order[np.argsort(begin[order], kind="stable")]
    begin, end, expected, turned = begin[order], end[order], expected[order], turned[order]
    links = np.searchsorted(begin, np.arange(len(times) + 1))

    def costs(records: Int64Array, own: slice) -> Float64Array:
        """Return the disagreement of the odometry at each of ``records`` (c,) with the relations at ``own``, metres
        (c,).
        """
        driven = compose(inverse(odometry[records][:, np.newaxis]), odometry[chosen[end[own]]])
        driven = np.where(turned[own][:, np.newaxis], inverse(driven), driven)
        off = compose(inverse(expected[own]), driven)
        cost = np.hypot(off[..., 0], off[..., 1]) + METRES_PER_RADIAN * np.abs(off[..., 2])
        return np.asarray(np.minimum(cost, GREATEST_COST).sum(axis=1))

    for _ in range(SWEEPS):
        before = chosen.copy()
        for u in np.flatnonzero((count > 1) & (np.diff(links) > 0)):
            chosen[u] = candidates[u][int(np.argmin(costs(candidates[u], slice(links[u], links[u + 1]))))]
        if np.array_equal(before, chosen):
            break
    return chosen[where], (count[where] == 1).all(axis=1)


@dataclass(frozen=True, slots=True)
class Relations:
    """Known motions between places: ``motions`` (n, 3), ``T_first_second``, metres and radians.

    They are from the first to the second of the times ``stamps_ns`` (n, 2). Raises :class:`ConfigError` for other
    shapes.
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

    ``policy`` is "records" if the stamps were mapped to the odometry messages of the log, or "time" if poses were
    interpolated between scans. ``unambiguous`` (n,) marks errors of relations whose stamps have one record each; with
    the policy "time" all are true. ``left_out`` counts relations with a stamp that the log does not have.
    """

    policy: str
    translation: ErrorSeries
    rotation: ErrorSeries
    unambiguous: NDArray[np.bool_]
    left_out: int

    def only_unambiguous(self) -> tuple[ErrorSeries, ErrorSeries]:
        """Return the errors of translation and rotation of the unambiguous relations."""
        clear = self.unambiguous
        return (
            ErrorSeries(self.translation.stamps_ns[clear], self.translation.errors[clear]),
            ErrorSeries(self.rotation.stamps_ns[clear], self.rotation.errors[clear]),
        )


def evaluate_relations(
    relations: Relations, scans: TimedPoses, records: OdometryRecords | None = None
) -> RelationErrors:
    """Return the errors of ``scans``, the poses to evaluate, one for each scan of a log in log order.

    ``records`` are the odometry messages of that log. If nearly all stamps of the relations are theirs, to 5.2 ms, the
    order of the records is used instead of the stamps. If several records have a stamp, the one that fits the raw
    odometry best is used, which makes the figures over all relations slightly optimistic; the unambiguous relations are
    decisive. Without records the poses are interpolated in time between the scans, ignoring those with the stamp of an
    earlier one, without extrapolation. Raises :class:`ConfigError` if there are no relations or poses, the number of
    poses differs from that of the records' scans, or no relation is within the log's time.
    """
    if not len(relations) or not len(scans):
        raise ConfigError("evaluation.no_relations", "There are no relations, or no poses, to compare.")
    if records is not None and len(records.before_scan) != len(scans):
        raise ConfigError(
            "evaluation.scan_count", f"{len(records.before_scan)} scans need as many poses, not {len(scans)}."
        )
    if records is not None and (records.before_scan >= 0).any() and _are_records(relations, records):
        indices, clear = records_of_relations(relations.stamps_ns, relations.motions, records.messages)
        is_known = (indices >= 0).all(axis=1)
        poses = poses_at_records(records, scans.poses)
        policy, ends = "records", poses[indices[is_known]]
    else:
        known = _first_of_each_stamp(scans)
        is_known = known.covers(relations.stamps_ns.ravel()).reshape(-1, 2).all(axis=1)
        clear = np.ones(len(relations), dtype=np.bool_)
        inside = relations.stamps_ns[is_known]
        policy, ends = "time", np.stack([known.at(inside[:, 0]), known.at(inside[:, 1])], axis=1)
    if not is_known.any():
        raise ConfigError("evaluation.no_relations", "No relation is at a time of the log.")
    motions = compose(inverse(ends[:, 0]), ends[:, 1])
    translation, rotation = magnitudes(compose(inverse(relations.motions[is_known]), motions))
    stamps = relations.stamps_ns[is_known, 0]
    return RelationErrors(
        policy,
        ErrorSeries(stamps, translation),
        ErrorSeries(stamps, rotation),
        clear[is_known],
        int(np.count_nonzero(~is_known)),
    )


def _are_records(relations: Relations, records: OdometryRecords) -> bool:
    with_record = [bool(len(near)) for near in records_at(np.unique(relations.stamps_ns), records.messages)]
    return float(np.mean(with_record)) > MOST


def _first_of_each_stamp(scans: TimedPoses) -> TimedPoses:
    return scans.take(np.unique(scans.stamps_ns, return_index=True)[1])
