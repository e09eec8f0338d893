"""Poses at the records of a log: for logs whose stamps repeat or run backwards, so that time does not order them.

Of Intel's 13,631 odometry messages 2,459 have the stamp of the one before and 629 an earlier one. Interpolating in time
there adds errors of 0.05 m. So the poses of the scans are carried to every message by the raw odometry between them,
and a relation's stamps are mapped to messages.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapper.core.se2 import compose, inverse
from mapper.sensors.timed_poses import OdometryRecords, TimedPoses

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]

STAMP_TOLERANCE_NS = 5_200_000  #: between a relation's stamp and that of its record: stamps are rounded to 10 ms
SHORT_S = 5.0  #: relations over less time than this choose among records, by the odometry, which drifts little there
SWEEPS = 6
METRES_PER_RADIAN = 0.4  #: what an angle weighs beside a length in the choice
GREATEST_COST = 0.5  #: metres: of one relation in the choice, so that a wrong one does not decide


def poses_at_records(records: OdometryRecords, scan_poses: Float64Array) -> Float64Array:
    """Return the corrected pose (n, 3) at each of n odometry messages from those of the scans (n_scans, 3).

    Between two scans the raw odometry is chained from the scan before and from the scan after; the difference of the
    two is distributed in proportion to the motion (metres and half the radians). Of scans after the same message the
    first counts, and scans before the first message do not. Before the first and after the last scan it is odometry
    alone. Needs a scan that a message precedes.
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
    """Return for each of the times (m,) the indices of the messages whose stamps are as good as equal, ascending."""
    order = np.argsort(messages.stamps_ns, kind="stable")
    stamps = messages.stamps_ns[order]
    begin = np.searchsorted(stamps, stamps_ns - STAMP_TOLERANCE_NS, side="left")
    end = np.searchsorted(stamps, stamps_ns + STAMP_TOLERANCE_NS, side="right")
    return [np.sort(order[a:b]) for a, b in zip(begin, end, strict=True)]


def records_of_relations(
    stamps_ns: Int64Array, motions: Float64Array, messages: TimedPoses
) -> tuple[Int64Array, NDArray[np.bool_]]:
    """Return the record of each relation's two stamps (n, 2), −1 for none, and which relations (n,) had no choice.

    ``stamps_ns`` (n, 2) and ``motions`` (n, 3) are the relations'. Where a stamp has several records, the one is taken
    that agrees best with the raw odometry over the relations of less than :data:`SHORT_S`, in :data:`SWEEPS` rounds.
    """
    times, where = np.unique(stamps_ns, return_inverse=True)
    where = where.reshape(stamps_ns.shape)
    candidates = records_at(times, messages)
    count = np.array([len(found) for found in candidates])
    chosen = np.array([found[0] if len(found) else -1 for found in candidates])
    odometry = messages.poses

    is_short = np.abs(stamps_ns[:, 1] - stamps_ns[:, 0]) < SHORT_S * 1e9
    # Each relation twice: at its first time, and, turned round, at its second.
    begin, end = np.concatenate([where[is_short], where[is_short][:, ::-1]]).T
    wanted = np.tile(motions[is_short], (2, 1))
    turned = np.arange(len(begin)) >= np.count_nonzero(is_short)
    order = np.flatnonzero(count[end] > 0)
    order = order[np.argsort(begin[order], kind="stable")]
    begin, end, wanted, turned = begin[order], end[order], wanted[order], turned[order]
    links = np.searchsorted(begin, np.arange(len(times) + 1))

    def costs(records: Int64Array, own: slice) -> Float64Array:
        """Return how badly the odometry at each of ``records`` (c,) fits the relations at ``own``, metres (c,)."""
        driven = compose(inverse(odometry[records][:, np.newaxis]), odometry[chosen[end[own]]])
        driven = np.where(turned[own][:, np.newaxis], inverse(driven), driven)
        off = compose(inverse(wanted[own]), driven)
        cost = np.hypot(off[..., 0], off[..., 1]) + METRES_PER_RADIAN * np.abs(off[..., 2])
        return np.asarray(np.minimum(cost, GREATEST_COST).sum(axis=1))

    for _ in range(SWEEPS):
        before = chosen.copy()
        for u in np.flatnonzero((count > 1) & (np.diff(links) > 0)):
            chosen[u] = candidates[u][int(np.argmin(costs(candidates[u], slice(links[u], links[u + 1]))))]
        if np.array_equal(before, chosen):
            break
    return chosen[where], (count[where] == 1).all(axis=1)
