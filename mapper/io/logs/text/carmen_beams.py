"""Beams of CARMEN's lasers: as stated by their scan lines, or else derived from their number.

Source of the numbers: the readers of gmapping (carmenconfiguration.cpp), MRPT (carmen_log_tools) and CARMEN
(readlog.c); the manuals of SICK's LMS 200, LMS 511 and TiM, and of Hokuyo's URG-04LX and UTM-30LX.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mapper.core.errors import ReadError
from mapper.sensors.scan import is_angle_step


@dataclass(frozen=True, slots=True)
class Beams:
    """Beams of one sensor, radians and metres, as stated by its scan lines or, if ``is_assumed``, a guess."""

    angle_min: float
    angle_increment: float
    range_max: float | None = None
    notes: tuple[str, ...] = ()
    is_assumed: bool = False


NO_RETURN = 80.0  #: metres: larger readings of a SICK LMS are no returns, if no maximum range is stated
HOKUYO_STEP = 360.0 / 1024.0  #: degrees: angular step of a Hokuyo URG-04LX

#: Number of beams → degrees between beams, and whether all readers agree on it.
BY_COUNT: dict[int, tuple[float, bool]] = {
    101: (1.0, False),
    180: (1.0, True),
    181: (1.0, True),
    191: (1.0, False),
    201: (0.5, False),
    270: (1.0, False),
    271: (1.0, False),
    360: (0.5, True),
    361: (0.5, True),
    381: (0.5, False),
    401: (0.25, False),
    540: (0.5, True),
    541: (0.5, True),
    571: (1.0 / 3.0, False),
    682: (HOKUYO_STEP, True),
    683: (HOKUYO_STEP, True),
    720: (0.25, False),
    721: (0.25, False),
    726: (HOKUYO_STEP, False),
    761: (0.25, False),
    768: (HOKUYO_STEP, False),
    769: (HOKUYO_STEP, True),
    810: (1.0 / 3.0, False),
    811: (1.0 / 3.0, False),
    1080: (0.25, False),
    1081: (0.25, False),
    1440: (0.25, False),
    1441: (0.25, False),
}
FIRST_OF_EVEN = {
    180: -90.0, 270: -135.0, 360: -90.0, 540: -135.0, 720: -90.0, 810: -135.0, 1080: -135.0, 1440: -180.0,
}  # fmt: skip  #: degrees: their last beam is missing
NO_NOTE = (180, 181)  #: the usual numbers
AGREE = 0.05  #: relative tolerance between two statements of one angle


def front_laser_beams(n_beams: int, word: str, fov: float | None = None, resolution: float | None = None) -> Beams:
    """Return the beams of lines ``word`` that state no angles, with notes on them.

    ``fov`` and ``resolution``, radians, are the log's parameters. They are used if they agree with the number of beams;
    otherwise the field of view of lidars with this number of beams, then the parameters as stated, then the field of
    view of lidars with one beam more or less, and otherwise 180°.
    """
    by_count = BY_COUNT.get(n_beams)
    if fov is not None and resolution is not None and _agree(resolution * max(1, n_beams - 1), fov, resolution):
        return _around(n_beams, resolution, word, "as PARAM states")
    if by_count is not None:
        step, is_agreed = math.radians(by_count[0]), by_count[1]
        stated = resolution if resolution is not None else None if fov is None else fov / max(1, n_beams - 1)
        if stated is None or is_agreed or abs(stated - step) <= AGREE * step:
            first = FIRST_OF_EVEN.get(n_beams)
            beams = _around(n_beams, step, word, "as lidars with so many beams send them")
            start = beams.angle_min if first is None else math.radians(first)
            notes = () if n_beams in NO_NOTE else beams.notes
            if stated is not None and abs(stated - step) > AGREE * step:
                notes += (f"PARAM states {math.degrees(stated):.4g}° between the beams, which is not used.",)
            return Beams(start, step, notes=notes)
    if resolution is not None and resolution * (n_beams - 1) <= 2.0 * math.pi + resolution:
        return _around(n_beams, resolution, word, "as PARAM states")
    if fov is not None:
        step = fov / max(1, n_beams - 1)
        return _around(n_beams, step, word, "as PARAM states")
    for other, one in ((n_beams + 1, "more"), (n_beams - 1, "less")):
        if other in BY_COUNT:
            step = math.radians(BY_COUNT[other][0])
            return _around(n_beams, step, word, f"as lidars with one beam {one} send them")
    step = math.pi / n_beams if n_beams % 2 == 0 else math.pi / max(1, n_beams - 1)
    note = (
        f"180° is assumed: {word} lines state no angles, no PARAM does, and {n_beams} beams are of no lidar that is "
        "known here. If walls are bent or doubled, give the log a line PARAM laser_front_laser_resolution, in degrees."
    )
    return Beams(-math.pi / 2.0, step, notes=(note,), is_assumed=True)


def _agree(a: float, b: float, step: float) -> bool:
    return abs(a - b) <= max(AGREE * b, 1.5 * step)


def _around(n_beams: int, step: float, word: str, why: str) -> Beams:
    """Return beams symmetric about straight ahead, ``step`` radians apart, and a note with the reason."""
    view = math.degrees(step) * (n_beams - 1)
    note = (
        f"The {n_beams} beams of the {word} lines, which state no angles, are taken to be {math.degrees(step):.4g}° "
        f"apart, {view:.4g}° in all, {why}."
    )
    return Beams(-0.5 * (n_beams - 1) * step, step, notes=(note,))


def robot_laser_beams(n: int, stated: list[float], line: int, word: str) -> Beams:
    """Check the values stated by a ROBOTLASER line of n beams: start angle, field of view, resolution, maximum range.

    The stated resolution has six digits, too few for a thousand beams; if it matches the field of view in n or n − 1
    steps, that quotient is used. Otherwise it is used as in CARMEN, with a note.
    """
    start, fov, resolution, range_max = stated
    if not (abs(start) <= 7.0 and 0.0 < fov <= 7.0 and 0.0 < resolution <= 7.0 and is_angle_step(resolution, n)):
        raise ReadError(
            "log.beam_angles",
            f"Line {line}: this {word} line states impossible angles: start {start}, field of view {fov}, "
            f"resolution {resolution} rad.",
        )
    limit, notes = range_max if 0.0 < range_max <= 1e4 else None, tuple[str, ...]()
    if limit is None:
        why = f"{word} lines state a maximum range of {range_max:g} m, which no lidar has: "
        notes = (f"{why}readings below {NO_RETURN:g} m count.",)
    for steps in (n, n - 1):
        if steps > 0 and abs(fov / steps - resolution) < 1e-6:
            return Beams(start, fov / steps, limit, notes)
    if n == 1 or _agree(resolution * (n - 1), fov, resolution):
        return Beams(start, resolution, limit, notes)
    view = math.degrees(resolution * (n - 1))
    note = (
        f"{word} lines contradict themselves: {n} beams {math.degrees(resolution):.4g}° apart are {view:.4g}°, and the "
        f"field of view is {math.degrees(fov):.4g}°. The resolution counts here, as in CARMEN; if walls are bent, it "
        "is wrong."
    )
    return Beams(start, resolution, limit, (*notes, note))
