"""The kinds of sessions that the service offers."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from server.sessions.kind import Kind
from server.sessions.models.log_kind import LOG
from server.sessions.models.simulation_kind import SIMULATION
from server.sessions.models.volume_kind import VOLUME

#: By the name in ``POST /api/sessions`` and in the message ``hello``.
KINDS: Mapping[str, Kind] = MappingProxyType({"simulation": SIMULATION, "log": LOG, "volume": VOLUME})
