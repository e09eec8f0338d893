"""Events of a log: when the robot was pushed, slipped or was lifted, when its clock was set, and gaps."""

from mapper.diagnosis.events.event import CLOCK, DISPLACED, GAP, KINDS, LIFTED, PUSHED, SLIPPED, Event, clock_time
from mapper.diagnosis.events.finding import find_events, wheels_of

__all__ = [
    "CLOCK",
    "DISPLACED",
    "GAP",
    "KINDS",
    "LIFTED",
    "PUSHED",
    "SLIPPED",
    "Event",
    "clock_time",
    "find_events",
    "wheels_of",
]
