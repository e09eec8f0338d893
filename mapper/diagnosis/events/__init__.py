"""Events of a log: when the robot was pushed, slipped or was lifted, and when its clock was set."""

from mapper.diagnosis.events.event import CLOCK, KINDS, LIFTED, PUSHED, SLIPPED, Event, clock_time
from mapper.diagnosis.events.finding import find_events, wheels_of

__all__ = ["CLOCK", "KINDS", "LIFTED", "PUSHED", "SLIPPED", "Event", "clock_time", "find_events", "wheels_of"]
