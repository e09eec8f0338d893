"""Where the robot of a simulation takes itself to be."""

from __future__ import annotations

import numpy as np

from mapper.core.se2 import compose, inverse
from mapper.simulation.live_map import LiveMap
from mapper.simulation.robot import PoseTuple
from server.sessions.view import as_pose


def believed_now(mapper: LiveMap) -> PoseTuple:
    """Return where the robot takes itself to be in the map now.

    Its true motion since the newest scan is added: the drift in a tenth of a second is negligible.
    """
    since = compose(inverse(np.array(mapper.newest_pose)), np.array(mapper.simulation.pose))
    return as_pose(compose(mapper.believed_pose, since))
