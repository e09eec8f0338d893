"""The beams of CARMEN's lasers, as their scan lines state them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mapper.core.errors import ReadError
from mapper.sensors.scan import is_angle_step


@dataclass(frozen=True, slots=True)
class Beams:
    """Beams of one sensor, as its scan lines describe them."""

    angle_min: float
    angle_increment: float
    range_max: float | None = None


def front_laser_beams(n_beams: int) -> tuple[float, float]:
    """Return (angle_min, angle_increment) in radians of a FLASER or RLASER line with ``n_beams``."""
    if n_beams in (180, 181):
        step = math.pi / 180.0
    else:
        step = math.pi / n_beams if n_beams % 2 == 0 else math.pi / max(1, n_beams - 1)
    return -math.pi / 2.0, step


def robot_laser_beams(n: int, stated: list[float], line: int, word: str) -> Beams:
    """Check what a ROBOTLASER line states of its n beams: start angle, field of view, resolution, maximum range.

    The stated resolution has six digits, too few for a thousand beams; where it is the field of view in n or n − 1
    steps, that quotient is taken.
    """
    start, fov, resolution, range_max = stated
    if not (abs(start) <= 7.0 and 0.0 < fov <= 7.0 and 0.0 < resolution <= 7.0 and is_angle_step(resolution, n)):
        raise ReadError(
            "log.beam_angles",
            f"Line {line}: this {word} line states impossible angles: start {start}, field of view {fov}, "
            f"resolution {resolution} rad.",
        )
    if not 0.0 < range_max <= 1e4:
        raise ReadError("log.range_max", f"Line {line}: this {word} line states a maximum range of {range_max} m.")
    for steps in (n, n - 1):
        if steps > 0 and abs(fov / steps - resolution) < 1e-6:
            resolution = fov / steps
            break
    return Beams(start, resolution, range_max)
