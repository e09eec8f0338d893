"""Events of a log: the robot was pushed, slipped or was lifted, its clock was set, or the recording has a gap."""

from mapper.diagnosis.events.event import DISPLACED, Event, clock_time
from mapper.diagnosis.events.finding import find_events

__all__ = [
    "DISPLACED",
    "Event",
    "clock_time",
    "find_events",
]
