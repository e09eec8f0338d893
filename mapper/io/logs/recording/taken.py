"""Messages of a recording from which a log is made."""

from __future__ import annotations

from dataclasses import dataclass, field

from mapper.core.limits import Limits
from mapper.io.logs.recording.clocks import Clock
from mapper.io.logs.recording.sensor_scans import SensorScans
from mapper.io.logs.recording.stream import Stream
from mapper.io.logs.recording.tf_topics import TfTopics
from mapper.io.logs.recording.timeline import Timeline

MAX_FRAME_NAME = 200  #: characters of a frame name stored in a log
SONAR = "sensor_msgs/Range"
ODOMETRY = "nav_msgs/Odometry"


@dataclass(slots=True)
class PoseTopic:
    """The poses of one topic, ``T_frame_child``; for a topic with several pairs of frames, those of one pair.

    ``fastest`` is the maximum speed stated by the messages, m/s.
    """

    topic: str
    kind: str
    frame: str
    child: str
    timeline: Timeline
    clock: Clock
    fastest: float = 0.0


@dataclass(slots=True)
class Taken:
    """Messages so far; ``children`` are frames whose poses are stated by odometry messages.

    ``unplaced`` are frames whose pose on the robot was unknown when their clouds were processed. ``low`` is, by topic,
    the fraction of a cloud's beams that end at low points, probably on the floor; ``heights`` are the minimum and
    maximum height of the points, metres in the base frame, of a topic none of whose clouds gave a beam.
    ``run_offsets`` are added to stamps so that each run follows the one before, see
    :mod:`mapper.io.logs.recording.runs`.
    """

    limits: Limits
    tf: TfTopics
    notes: list[str]
    streams: list[Stream] = field(default_factory=list)
    sensors: dict[str, SensorScans] = field(default_factory=dict)
    poses: dict[str, PoseTopic] = field(default_factory=dict)
    children: set[str] = field(default_factory=set)
    tf_clock: Clock = field(default_factory=Clock)
    unplaced: set[str] = field(default_factory=set)
    low: dict[str, float] = field(default_factory=dict)
    heights: dict[str, tuple[float, float]] = field(default_factory=dict)
    run_offsets: tuple[int, ...] = (0,)
