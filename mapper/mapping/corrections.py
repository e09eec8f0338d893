"""A log with the corrections of its mount and of its clock that the parameters of a map state."""

from __future__ import annotations

from mapper.mapping.parameters import MappingConfig
from mapper.sensors.corrections import corrected_log
from mapper.sensors.scan import ScanLog


def as_mapped(log: ScanLog, config: MappingConfig) -> ScanLog:
    """Return ``log`` as the map with ``config`` has it: what finds poses for that map begins with this.

    See :func:`mapper.sensors.corrections.corrected_log`.
    """
    return corrected_log(log, config.mount, turned_over=config.mount_upside_down, time_offset=config.time_offset)
