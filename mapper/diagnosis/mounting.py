"""Mount of the sensor: rotated, mirrored, or offset from what the log states."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np

from mapper.core.se2 import wrap_angle
from mapper.diagnosis.consistency import Examined, consistency
from mapper.diagnosis.finding import Finding
from mapper.sensors.scan import ScanLog

BETTER = 1.3  #: times as consistent, and
BY = 0.08  #: the minimum difference, for a sensor to be reported as turned
FINER = 1.12  #: for an offset; improvements for drifting poses are smaller
FINER_BY = 0.04
FARTHER = 6  #: maximum number of steps of one size for a mount that is not stated
DIRECTIONS = np.radians(np.arange(-165.0, 180.1, 15.0)).clip(max=3.1415).tolist()  #: for a mount that is not stated
CHANGING = "mount.changing"
MOST_MOUNTS = 8  #: maximum number of alternating mounts in a log
MOUNT_DECIMALS = 3  #: decimals, in metres and radians, at which two mounts differ
LEAST_TURN = 0.2  #: radians of robot rotation needed to observe the sensor's position on it

_TURNS = (
    ("turned by 180°", math.pi),
    ("turned by 90° to the left", math.pi / 2),
    ("turned by 90° to the right", -math.pi / 2),
)


def check_changing(_: ScanLog, seen: Examined) -> list[Finding]:
    """Try each of the few mounts that the log alternates between for all scans, as if two programs publish one
    frame.
    """
    if seen.log.mounts is None:
        return []
    stated = np.unique(seen.log.mounts.round(MOUNT_DECIMALS), axis=0)
    if not 2 <= len(stated) <= MOST_MOUNTS:  # more than that belong to a sensor that moves on the robot
        return []
    now = seen.agreement
    fixed = (replace(seen.log, mounts=None, mount=(x, y, yaw)) for x, y, yaw in stated.tolist())
    best, k = max((consistency(replace(seen, log=log)), k) for k, log in enumerate(fixed))
    if best < FINER * now or best < now + FINER_BY:
        return []
    x, y, yaw = stated[k].tolist()
    return [
        Finding(
            CHANGING,
            f"The log states {len(stated)} mounts of the sensor in turns, and walls get sharper with one of them at "
            f"all scans, {x:.2f} m ahead, {y:.2f} m to the left and turned by {math.degrees(yaw):.1f}°: beams end "
            f"where others end in {100 * best:.0f} % instead of {100 * now:.0f} % of all cases.",
            "Look for a second program that publishes the sensor’s static transform, and record with one.",
            min(0.99, 0.5 + (best - now)),
        )
    ]


def check_turned(log: ScanLog, seen: Examined) -> list[Finding]:
    """Try the sensor upside down, backwards and sideways.

    A sensor without a stated mount may face any direction, which :func:`check_offset` finds unless it is upside down.
    """
    now = seen.agreement
    tried: list[tuple[float, str, dict[str, object]]] = []
    for over in (False, True):
        for words, yaw in (("", 0.0), *_TURNS):
            if not over and not yaw:
                continue
            what = " and ".join(part for part in ("upside down (mirrored)" if over else "", words) if part)
            values: dict[str, object] = {"mount_upside_down": over, "mount_yaw": min(yaw, 3.1415)}
            tried.append((consistency(seen, **values), what, values))
    best, what, values = max(tried, key=lambda candidate: candidate[0])
    if best < BETTER * now or best < now + BY or (log.mount_assumed and not values["mount_upside_down"]):
        return []
    return [
        Finding(
            "mount.turned",
            f"The laser fits much better {what}: beams end where others end in {100 * best:.0f} % instead of "
            f"{100 * now:.0f} % of all cases.",
            _advice(bool(values["mount_upside_down"]), float(str(values["mount_yaw"]))),
            min(0.99, 0.5 + (best - now)),
            (),
            values,
        )
    ]


def _advice(over: bool, yaw: float) -> str:
    """Return what to do about a mount that is turned: some wrong signs of the odometry have the same effect.

    Where the robot turns to the other side than the odometry states, all is as if seen in a mirror. Where it drives
    forward and the odometry states backward, all is as if turned by 180°.
    """
    if over and not yaw:
        return (
            "Correct the sensor’s mount; or, if that is right, the sign of the turns in the odometry, a wrong one of "
            "which has the same effect: then this map is mirrored."
        )
    if not over and yaw > 3.0:
        return (
            "Correct the sensor’s mount; or, if that is right, the sign of the forward motion in the odometry, a wrong "
            "one of which has the same effect: then this map is turned by 180°."
        )
    return "Correct the sensor’s mount."


def _sharpest(
    consistency_of: Callable[..., float], names: tuple[str, ...], begin: float, yaw: float, tries: int = 1
) -> tuple[float, dict[str, float]]:
    """Return the maximum consistency reached by shrinking steps from a turned mount, and the mount.

    ``consistency_of`` returns the consistency of a mount, ``begin`` is that of the first one, and ``tries`` the maximum
    number of steps of one size.
    """
    best, at = begin, {"mount_x": 0.0, "mount_y": 0.0, "mount_yaw": yaw}
    steps = {"mount_x": 0.2, "mount_y": 0.2, "mount_yaw": math.radians(6.0)}
    for _ in range(5):
        for _ in range(tries):
            before = best
            for name in names:
                for sign in (1.0, -1.0):
                    tried = at | {name: at[name] + sign * steps[name]}
                    tried["mount_yaw"] = float(wrap_angle(tried["mount_yaw"]))
                    value = consistency_of(**tried)
                    if value > best:
                        best, at = value, tried
                        break
            if best == before:
                break
        steps = {name: step / 2.0 for name, step in steps.items()}
    return best, at


def check_offset(log: ScanLog, seen: Examined) -> list[Finding]:
    """Shift and rotate the mount in small steps, axis by axis, as long as the map gets sharper.

    A mount that is not stated is searched for from several directions, over a larger range. If the robot hardly turns,
    shifting the mount shifts the whole map, so it is only rotated.
    """
    has_turned = np.ptp(np.unwrap(seen.log.trajectory().poses[:, 2])) >= LEAST_TURN
    names = ("mount_yaw", "mount_x", "mount_y") if has_turned else ("mount_yaw",)
    now = seen.agreement
    consistency_of = cache(partial(consistency, seen))  # steps lead to the same mounts again
    best, at = _sharpest(consistency_of, names, now, 0.0)
    if log.mount_assumed:
        turned = sorted(((consistency(seen, mount_yaw=yaw), yaw) for yaw in DIRECTIONS), reverse=True)
        candidates = [
            (best, at),
            *(_sharpest(consistency_of, names, *candidate, tries=FARTHER) for candidate in turned[:3]),
        ]
        best, at = max(candidates, key=lambda candidate: candidate[0])
    x, y, yaw = at["mount_x"], at["mount_y"], at["mount_yaw"]
    if best < FINER * now or best < now + FINER_BY or (math.hypot(x, y) < 0.03 and abs(yaw) < math.radians(0.4)):
        return []
    return [
        Finding(
            "mount.offset",
            f"Walls get sharper with the sensor {x:+.2f} m ahead, {y:+.2f} m to the left and {math.degrees(yaw):+.1f}° "
            f"turned: beams end where others end in {100 * best:.0f} % instead of {100 * now:.0f} % of all cases.",
            "Measure the mount again, or correct it by this.",
            min(0.95, 0.4 + 4.0 * (best - now)),
            (),
            {name: round(value, 4) for name, value in at.items()},
        )
    ]
