"""The kinds of sessions: the content and computation of each, its request and its plan."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from server.sessions.kind import Kind
from server.sources.log_kind import LOG, costmaps_plan, log_plan
from server.sources.simulation_kind import SIMULATION
from server.sources.volume_kind import VOLUME, volume_plan

#: By the name in ``POST /api/sessions`` and in the ``hello`` message.
KINDS: Mapping[str, Kind] = MappingProxyType({"simulation": SIMULATION, "log": LOG, "volume": VOLUME})


__all__ = ["KINDS", "costmaps_plan", "log_plan", "volume_plan"]
