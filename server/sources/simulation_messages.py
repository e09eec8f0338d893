"""The message ``world`` of a session of the lab."""

from __future__ import annotations

from typing import Any

import numpy as np

from mapper.simulation import WORLDS
from mapper.simulation.edits import solid_ids
from mapper.simulation.faults import polished_faces
from mapper.simulation.live_map import LiveMap


def world_message(mapper: LiveMap) -> dict[str, Any]:
    """Return the message ``world``: what stands in the true world, and the edits of its floor plan; metres."""
    world = mapper.simulation.world
    added, erased = mapper.edits.as_lists()
    return {
        "type": "world",
        "name": world.name,
        "title": world.title,
        "names": list(WORLDS),
        "bounds": [float(v) for v in world.bounds],
        "polygons": [np.round(solid, 4).tolist() for solid in world.solids],
        "ids": solid_ids(mapper.plan, mapper.edits),
        "edits": {"added": added, "erased": erased},
        "polished": np.round(polished_faces(world), 4).tolist(),
        "blocks": [
            {"outline": np.round(one.outline, 4).tolist(), "low": one.bottom, "high": float(one.heights.max())}
            for one in world.blocks
        ],
    }
