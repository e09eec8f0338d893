"""Events of a log: when the robot was pushed, slipped or was lifted, when its clock was set, and gaps."""

from mapper.diagnosis.events.event import DISPLACED, Event, clock_time
from mapper.diagnosis.events.finding import find_events

__all__ = [
    "DISPLACED",
    "Event",
    "clock_time",
    "find_events",
]
