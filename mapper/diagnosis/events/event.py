"""One event of a log: kind, time, size, and direction relative to the robot."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from mapper.core.time_units import EPOCH_S

PUSHED, SLIPPED, LIFTED, CLOCK, GAP = "pushed", "slipped", "lifted", "clock", "gap"
DISPLACED = (PUSHED, SLIPPED, LIFTED)  #: kinds of events in which the robot moved other than its wheels measured
KINDS = (*DISPLACED, CLOCK, GAP)

SMALL_SHARE = 0.4  #: of the larger component of a displacement, below which the smaller one is not mentioned
LEAST_M, LEAST_RAD = 0.05, math.radians(4.0)  #: smaller displacements and turns are not stated
LONG_S = 1.0  #: a longer event is described with its end


@dataclass(frozen=True, slots=True)
class Event:
    """An event of the robot, its clock or its recorder during the recording.

    ``kind`` is one of :data:`KINDS`. ``seconds`` and ``until_s`` are its start and end in recorded time, seconds since
    the log's first scan, see :func:`mapper.io.logs.summary.recorded_seconds`; ``stamp_ns`` is the start on the log's
    clock, None for a log without times. ``scan`` is the last scan before it, ``until_scan`` the first one after it.
    ``ahead_m``, ``left_m`` and ``turned_rad`` are the robot's motion by the scans minus that by the wheels, in the
    robot's frame at the time (REP 103): for a push the robot's displacement, for a slip the negative of the wheels'
    excess motion. None if the scans do not determine it. ``step_s`` is the clock step in seconds, 0 for other events.
    ``moved_m`` is the straight-line distance the robot moved meanwhile according to its poses, metres, for gaps of the
    recording only; None without poses.
    """

    kind: str
    seconds: float
    until_s: float
    stamp_ns: int | None
    scan: int
    until_scan: int
    ahead_m: float | None = None
    left_m: float | None = None
    turned_rad: float | None = None
    step_s: float = 0.0
    moved_m: float | None = None

    @property
    def distance_m(self) -> float | None:
        """Distance by which the robot was displaced, metres."""
        if self.ahead_m is None or self.left_m is None:
            return None
        return math.hypot(self.ahead_m, self.left_m)

    @property
    def direction(self) -> str | None:
        """Side of the robot to which it was displaced: ahead, behind, left or right; None without displacement."""
        if self.ahead_m is None or self.left_m is None or math.hypot(self.ahead_m, self.left_m) < LEAST_M:
            return None
        if abs(self.ahead_m) >= abs(self.left_m):
            return "ahead" if self.ahead_m > 0.0 else "behind"
        return "left" if self.left_m > 0.0 else "right"

    @property
    def time(self) -> str:
        """The start in recorded time, m:ss.mmm."""
        return clock_time(self.seconds)

    @property
    def utc(self) -> str | None:
        """The start in UTC, ISO 8601 with milliseconds; None if the log's clock does not provide it."""
        if self.stamp_ns is None or not EPOCH_S[0] < self.stamp_ns * 1e-9 < EPOCH_S[1]:
            return None
        begin = datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=self.stamp_ns // 1000)
        return f"{begin:%Y-%m-%dT%H:%M:%S}.{begin.microsecond // 1000:03d}Z"

    @property
    def sentence(self) -> str:
        """One sentence with the event and its time."""
        lasts = self.kind in (PUSHED, SLIPPED) and self.until_s - self.seconds > LONG_S
        return f"{f'From {self.time} to {clock_time(self.until_s)}' if lasts else f'At {self.time}'} {self.what}"

    @property
    def what(self) -> str:
        """The event as the rest of a sentence that starts with its time."""
        lasted = self.until_s - self.seconds
        if self.kind == CLOCK:
            return f"the clock was set {'back' if self.step_s < 0.0 else 'forward'} by {abs(self.step_s):.2f} s."
        if self.kind == GAP:
            if self.moved_m is None:
                return f"nothing was recorded for {lasted:.2f} s; how far the robot moved meanwhile is not known."
            return f"nothing was recorded for {lasted:.2f} s; the robot moved {self.moved_m:.2f} m meanwhile."
        if self.kind == LIFTED:
            sentence = f"the robot was lifted or carried: for {lasted:.1f} s no scan fits those before."
            if self.distance_m is None:
                return f"{sentence} Where it was set down is not known."
            return f"{sentence} It was set down {self._displacement()}."
        if self.kind == SLIPPED:
            return f"the wheels measured {self._displacement(-1.0)} that the robot did not move: a slip."
        verb = "moved" if self._moved() else "was"
        return f"the robot {verb} {self._displacement()}, which the wheels did not measure."

    def _moved(self) -> bool:
        return (self.distance_m or 0.0) >= LEAST_M

    def _displacement(self, sign: float = 1.0) -> str:
        """Return the displacement, negated for a sign of −1, in words."""
        ahead, left, turn = (sign * (component or 0.0) for component in (self.ahead_m, self.left_m, self.turned_rad))
        parts = []
        greater = max(abs(ahead), abs(left))
        if self._moved():
            if abs(ahead) >= SMALL_SHARE * greater:
                parts.append(f"{abs(ahead):.2f} m {'ahead' if ahead > 0.0 else 'backwards'}")
            if abs(left) >= SMALL_SHARE * greater:
                parts.append(f"{abs(left):.2f} m to its {'left' if left > 0.0 else 'right'}")
        text = " and ".join(parts)
        if abs(turn) >= LEAST_RAD or not text:
            turned = f"turned by {math.degrees(abs(turn)):.0f}° to its {'left' if turn > 0.0 else 'right'}"
            text = f"{text}, {turned}" if text else turned
        return text

    def public(self) -> dict[str, Any]:
        """Return the fields and derived values for JSON: metres, radians and seconds with three decimals."""

        def rounded(value: float | None) -> float | None:
            return None if value is None else round(value, 3)

        return {
            **asdict(self),
            **{
                name: rounded(getattr(self, name))
                for name in ("seconds", "until_s", "ahead_m", "left_m", "turned_rad", "step_s", "moved_m", "distance_m")
            },
            "direction": self.direction,
            "time": self.time,
            "utc": self.utc,
            "sentence": self.sentence,
            "what": self.what,
        }


def clock_time(seconds: float) -> str:
    """Format a time of a recording as m:ss.mmm."""
    minutes, rest = divmod(round(seconds * 1000), 60_000)
    return f"{minutes}:{rest // 1000:02d}.{rest % 1000:03d}"
