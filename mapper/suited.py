"""Which parameters suit a log, where nobody has said others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mapper.parameters import BY_NAME
from mapper.scan import ScanLog

SONAR_WINDOW = 0.2  #: metres: how thick the arc of a sonar's echo is taken to be


def suited_parameters(log: ScanLog, given: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return ``given`` values of :data:`mapper.parameters.PARAMETERS` and those that the log calls for besides.

    The readings of wide beams are put all over their cones, which open as far as the log says. Whoever names a model
    gets the table's other values with it.
    """
    given = given or {}
    if log.beam_width <= 0.0:
        return dict(given)
    row = BY_NAME["opening"]
    opening = float(np.clip(log.beam_width, row.low, row.high))
    suited: dict[str, Any] = {"opening": opening}
    if "model" not in given:
        suited |= {"model": "sonar_cone", "window": SONAR_WINDOW}
    return suited | dict(given)
