"""The messages ``world`` and ``forgetting`` of a session of the lab."""

from __future__ import annotations

import msgspec
import numpy as np

from mapper.simulation import WORLDS
from mapper.simulation.edits import solid_ids
from mapper.simulation.faults import polished_faces
from mapper.simulation.live_map import LiveMap
from mapper.simulation.second_map import Vanishing
from server.stream.message_parts import Block, Edits
from server.stream.messages import Forgetting, WorldMessage


def world_message(mapper: LiveMap) -> WorldMessage:
    """Return the message ``world``: what stands in the true world, and the edits of its floor plan; metres."""
    world = mapper.simulation.world
    added, erased = mapper.edits.as_lists()
    return WorldMessage(
        name=world.name,
        title=world.title,
        names=list(WORLDS),
        bounds=world.bounds,
        polygons=[np.round(solid, 4).tolist() for solid in world.solids],
        ids=solid_ids(mapper.plan, mapper.edits),
        edits=msgspec.convert({"added": added, "erased": erased}, Edits),
        polished=np.round(polished_faces(world), 4).tolist(),
        blocks=[Block(np.round(one.outline, 4).tolist(), one.bottom, float(one.heights.max())) for one in world.blocks],
    )


def forgetting_message(vanishing: Vanishing | None) -> Forgetting:
    """Return the message ``forgetting``; without cells where nothing is watched."""
    if vanishing is None:
        return Forgetting(0, 0, None, None, 0.0, 0.0)
    pair = (vanishing.first, vanishing.second)
    clamped, unclamped = pair if vanishing.clamped_first else pair[::-1]
    return Forgetting(
        cells=len(vanishing.first.places),
        scans=len(vanishing.first.free),
        with_clamp=clamped.after,
        without_clamp=unclamped.after,
        free_with_clamp=round(clamped.free[-1], 4) if clamped.free else 0.0,
        free_without_clamp=round(unclamped.free[-1], 4) if unclamped.free else 0.0,
    )
