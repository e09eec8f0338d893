"""Default parameters by the sensor, and by where its scans come from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mapper.mapping.parameters import BY_NAME

SONAR_WINDOW = 0.2  #: metres: how thick the arc of a sonar's echo is taken to be


def sensor_defaults(beam_width: float, given: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return ``given`` values of :data:`mapper.mapping.parameters.PARAMETERS` and the default values for
    a sensor.

    Readings of cones, ``beam_width`` > 0 radians, use the sonar cone model. If ``given`` names a model, the other
    values remain those of the table.
    """
    given = given or {}
    if beam_width <= 0.0:
        return dict(given)
    row = BY_NAME["opening"]
    opening = float(np.clip(beam_width, row.low, row.high))
    defaults: dict[str, Any] = {"opening": opening}
    if "model" not in given:
        defaults |= {"model": "sonar_cone", "window": SONAR_WINDOW}
    return defaults | dict(given)


#: Of a recording, where a map is to hold the walls; a simulated world begins with the step of the sources.
RECORDED: Mapping[str, Any] = {"hit_and_passed": "only_hits"}


def recorded_defaults(beam_width: float, given: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return :func:`sensor_defaults` with :data:`RECORDED`, for the scans of a recording."""
    return {**RECORDED, **sensor_defaults(beam_width, given)}
