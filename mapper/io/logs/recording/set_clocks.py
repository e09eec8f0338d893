"""Clocks that are set individually during a recording, such as that of a lidar's computer by a time server.

The stamps of its sender then step, while its messages are still recorded at their usual intervals. Late messages and
pauses of a sender are not such steps. If most other topics step as well, the common clock was set, or has restarted
(:mod:`mapper.io.logs.recording.runs`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mapper.core.array_types import Int64Array
from mapper.io.logs.recording.clocks import FAR_NS
from mapper.io.logs.recording.runs import NEAR_S, Track

LEAST_NS = 500_000_000  #: minimum step; smaller ones are due to threads and networks
REGULAR, SHARE = 0.25, 0.8  #: tolerance, and minimum fraction, of the intervals near the usual one for a regular sender
AROUND = 5  #: messages before and after a step whose stamps must show it relative to the recording times
ALIKE = 0.25  #: of a step: tolerance to the recording times
MOST = 20  #: steps of one sender; a clock with more is unusable


def settings_of(track: Track) -> list[tuple[int, int]]:
    """Return the indices of messages before which a sender's clock was set, and by how many nanoseconds."""
    recorded, stamps = track.recorded_ns, track.stamps_ns
    if recorded is None or not recorded.all() or len(stamps) <= 2 * AROUND:
        return []
    stated, came = np.diff(stamps), np.diff(recorded)
    usual = int(np.median(stated))
    if usual <= 0 or np.mean(np.abs(stated - usual) < REGULAR * usual) < SHARE:
        return []
    if abs(float(np.median(came)) - usual) > REGULAR * usual:  # as for a simulation slower than the recorder
        return []
    by = stated - usual
    steps = np.flatnonzero((np.abs(by) > LEAST_NS) & (np.abs(came - usual) < ALIKE * np.abs(by)))
    settings = [(int(k) + 1, int(by[k])) for k in steps]
    settings = [(at, step) for at, step in settings if _is_step(stamps - recorded, at, step)]
    return settings if len(settings) <= MOST else []


def as_never_set(stamps_ns: Int64Array, recorded_ns: Int64Array, settings: Sequence[tuple[int, int]]) -> Int64Array:
    """Return the stamps (n,) of a sender by its clock as it was when nearest to the recorder's.

    For a clock far from that, such as a simulation's, as it was at first.
    """
    shift = np.zeros(len(stamps_ns), dtype=np.int64)
    for at, step in settings:
        shift[at:] -= step
    parts = np.split(stamps_ns - recorded_ns, [at for at, _ in settings])
    ahead = [abs(float(np.median(part))) for part in parts]
    nearest = int(np.argmin(ahead)) if min(ahead) < FAR_NS else 0
    return np.asarray(stamps_ns + shift - shift[0 if nearest == 0 else settings[nearest - 1][0]])


def own_settings(tracks: Sequence[Track]) -> list[list[tuple[int, int]]]:
    """Return :func:`settings_of` each sender that are shared by at most as many other topics as continue there."""
    return [[setting for setting in settings_of(track) if _is_alone(track, setting, tracks)] for track in tracks]


def _is_step(ahead_ns: Int64Array, at: int, step: int) -> bool:
    """Return whether stamps are ahead of the recording times (n,) by an additional step from index ``at`` on."""
    before, after = ahead_ns[max(0, at - AROUND) : at], ahead_ns[at : at + AROUND]
    enough = min(len(before), len(after)) > 1
    return bool(enough and abs(float(np.median(after)) - float(np.median(before)) - step) < ALIKE * abs(step))


def _is_alone(track: Track, setting: tuple[int, int], tracks: Sequence[Track]) -> bool:
    at, step = setting
    votes: dict[str, bool] = {}
    when = 0 if track.recorded_ns is None else int(track.recorded_ns[at])
    for other in tracks:
        recorded = other.recorded_ns
        if other.topic == track.topic or recorded is None or not recorded.all():
            continue
        k = int(np.searchsorted(recorded, when))
        if 0 < k < len(recorded) and recorded[k] - recorded[k - 1] < NEAR_S * 1e9:
            votes[other.topic] = votes.get(other.topic, False) or _is_step(other.stamps_ns - recorded, k, step)
    shared = sum(votes.values())
    return bool(votes) and shared <= len(votes) - shared
